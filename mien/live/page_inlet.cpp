#include "mien/live/page_inlet.h"

namespace mien::live {
namespace {

/// What stands before a message in the queue.
struct InletHead {
  std::uint64_t client;
  PageInlet::Clock::time_point arrival;
};

}  // namespace

bool PageInlet::offer(std::uint64_t client, std::span<const std::byte> bytes, Clock::time_point now) {
  if (client == 0 || client != admitted_ || !ring_.put(InletHead{client, now}, bytes)) {
    count_refused();
    return false;
  }
  awake_.give();
  return true;
}

std::optional<PageInlet::Message> PageInlet::front() {
  const auto record = ring_.front_of<InletHead>();
  if (!record) return std::nullopt;
  return Message{record->first.client, record->first.arrival, record->second};
}

}  // namespace mien::live
