#include "mien/live/page_inlet.h"

#include <algorithm>
#include <cstring>

namespace mien::live {
namespace {

/// What stands before a message in the queue.
struct InletHead {
  std::uint64_t client;
  PageInlet::Clock::time_point arrival;
};

}  // namespace

bool PageInlet::offer(std::uint64_t client, std::span<const std::byte> bytes, Clock::time_point now) {
  const bool admitted = client != 0 && client == admitted_;
  const std::span<std::byte> room =
      admitted ? ring_.claim(sizeof(InletHead) + bytes.size()) : std::span<std::byte>();
  if (room.empty()) {
    count_refused();
    return false;
  }
  const InletHead head{client, now};
  std::memcpy(room.data(), &head, sizeof(head));
  std::ranges::copy(bytes, room.begin() + sizeof(head));
  ring_.publish();
  awake_.give();
  return true;
}

std::optional<PageInlet::Message> PageInlet::front() {
  const std::span<const std::byte> record = ring_.front();
  if (record.empty()) return std::nullopt;
  InletHead head{};
  std::memcpy(&head, record.data(), sizeof(head));
  return Message{head.client, head.arrival, record.subspan(sizeof(head))};
}

}  // namespace mien::live
