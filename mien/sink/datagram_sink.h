#pragma once

#include <functional>
#include <string>
#include <utility>

#include "mien/sink/frame_pace.h"
#include "mien/sink/sink.h"
#include "mien/sink/udp_target.h"

namespace mien::sink {

/// A protocol whose frames are datagrams to one receiver: what is left of it is its encoder.
class DatagramSink final : public Sink {
 public:
  /// Fills cleared datagrams with one frame; may leave them empty where nothing is to be said.
  using Encode = std::function<void(const face::OutputFrame&, std::int64_t frame_index, Datagrams&)>;

  DatagramSink(std::string address, UdpTarget target, int rate_hz, Encode encode)
      : address_(std::move(address)),
        target_(std::move(target)),
        pace_(rate_hz),
        encode_(std::move(encode)) {}

  void send(const face::OutputFrame& frame, std::int64_t frame_index) noexcept override;
  [[nodiscard]] Status status() const override;

 private:
  void trouble(Delivery what);

  std::string address_;
  UdpTarget target_;
  FramePace pace_;
  Encode encode_;
  Datagrams datagrams_;
  Delivery trouble_ = Delivery::taken;
  int good_since_ = 0;  ///< Frames since the trouble.
};

}  // namespace mien::sink
