#include "mien/live/payload_source.h"

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
  if (!ring_.put(head, datagram, payload)) {
    overrun_.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  awake_.give();
  return true;
}

std::optional<PayloadSource::Waiting> PayloadSource::front() {
  const auto record = ring_.front_of<SourceHead>();
  if (!record) return std::nullopt;
  const auto& [head, rest] = *record;
  return Waiting{head.arrival, rest.first(head.datagram_bytes), rest.subspan(head.datagram_bytes)};
}

PayloadSource::Counts PayloadSource::counts() const {
  return {.received = received_.load(std::memory_order_relaxed),
          .too_long = too_long_.load(std::memory_order_relaxed),
          .overrun = overrun_.load(std::memory_order_relaxed)};
}

}  // namespace mien::live
