#include "mien/sink/datagram_sink.h"

namespace mien::sink {
namespace {

/// After so many frames without it a trouble is over.
constexpr int kRecovered = 30;

}  // namespace

void DatagramSink::trouble(Delivery what) {
  trouble_ = what;
  good_since_ = 0;
}

void DatagramSink::send(const face::OutputFrame& frame, std::int64_t frame_index) noexcept {
  try {
    if (!pace_.due(frame_index)) return;
    // A refusal tells of a datagram before: that frame was lost, and this one is tried.
    if (const Delivery news = target_.news(); news != Delivery::taken) {
      pace_.undelivered();
      trouble(news);
    } else if (good_since_ < kRecovered && ++good_since_ == kRecovered) {
      trouble_ = Delivery::taken;
    }
    datagrams_.clear();
    encode_(frame, frame_index, datagrams_);
    const Delivery delivery = target_.send(datagrams_);
    if (delivery == Delivery::taken) {
      pace_.sent();
    } else {
      pace_.failed();
      trouble(delivery);
    }
  } catch (...) {  // Out of memory while the buffers grow: the frame is lost, the session is not.
    pace_.failed();
  }
}

Status DatagramSink::status() const {
  return {address_,
          pace_.sent_count(),
          pace_.failed_count(),
          pace_.measured_hz(),
          trouble_ == Delivery::refused ? std::optional<std::size_t>(0) : std::nullopt,
          std::string(describe(trouble_))};
}

}  // namespace mien::sink
