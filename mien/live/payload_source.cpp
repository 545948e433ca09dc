#include "mien/live/payload_source.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace mien::live {
namespace {

/// What stands before a source's datagram and payload in its queue.
struct SourceHead {
  HostTime arrival;
  std::uint64_t datagram_bytes;
};

}  // namespace

PayloadSource::PayloadSource(sensor::Peer peer, Clock clock, Signal& awake)
    : peer_(peer), clock_(std::move(clock)), awake_(awake), ring_(kQueueBytes) {}

bool PayloadSource::hand_over(std::span<const std::byte> datagram, std::span<const std::byte> payload) {
  const SourceHead head{clock_(), datagram.size()};
  received_.fetch_add(1, std::memory_order_relaxed);
  if (datagram.size() > kMaxDatagram || payload.size() > sensor::kMaxPayload) {
    too_long_.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  const std::span<std::byte> room = ring_.claim(sizeof(head) + datagram.size() + payload.size());
  if (room.empty()) {
    overrun_.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  std::memcpy(room.data(), &head, sizeof(head));
  const auto rest = std::ranges::copy(datagram, room.begin() + sizeof(head)).out;
  std::ranges::copy(payload, rest);
  ring_.publish();
  awake_.give();
  return true;
}

std::optional<PayloadSource::Waiting> PayloadSource::front() {
  const std::span<const std::byte> record = ring_.front();
  if (record.empty()) return std::nullopt;
  SourceHead head{};
  std::memcpy(&head, record.data(), sizeof(head));
  const std::span<const std::byte> rest = record.subspan(sizeof(head));
  return Waiting{head.arrival, rest.first(head.datagram_bytes), rest.subspan(head.datagram_bytes)};
}

PayloadSource::Counts PayloadSource::counts() const {
  return {.received = received_.load(std::memory_order_relaxed),
          .too_long = too_long_.load(std::memory_order_relaxed),
          .overrun = overrun_.load(std::memory_order_relaxed)};
}

}  // namespace mien::live
