#pragma once

#include <oscpack/osc/OscOutboundPacketStream.h>

#include <array>
#include <cstddef>
#include <string_view>

#include "mien/sink/datagrams.h"

namespace mien::sink {

/// Writes OSC 1.0 messages into bundles of time tag "now", as many as it takes for each to be small enough to
/// cross a network in one piece. Messages keep their order within a bundle and from bundle to bundle.
class OscBundles {
 public:
  /// The VMC protocol recommends at most 1500 bytes; with IPv6's headers this is what fits into an Ethernet
  /// frame.
  static constexpr std::size_t kMaxBytes = 1400;

  explicit OscBundles(Datagrams& out) : out_(&out), stream_(buffer_.data(), buffer_.size()) {}
  OscBundles(const OscBundles&) = delete;
  OscBundles& operator=(const OscBundles&) = delete;

  /// Adds one message; arguments are float, std::int32_t (as osc::int32), bool (tags T and F) or
  /// zero-terminated text. A message that fits into no bundle is left out and returns false.
  template <class... Argument>
  bool add(const char* address, Argument... arguments) {
    const std::size_t need = sizeof(std::int32_t) + padded(std::string_view(address).size() + 1) +
                             padded(sizeof...(arguments) + 2) + (std::size_t{0} + ... + bytes(arguments));
    if (need + kHeaderBytes > kMaxBytes) return false;
    if (open_ && stream_.Size() + need > kMaxBytes) finish();
    if (!open_) {
      stream_.Clear();
      stream_ << osc::BeginBundleImmediate;
      open_ = true;
    }
    stream_ << osc::BeginMessage(address);
    (void)(stream_ << ... << arguments);
    stream_ << osc::EndMessage;
    return true;
  }
  /// Closes the last bundle. Call it once, at the end; without messages nothing is written.
  void finish() {
    if (!open_) return;
    stream_ << osc::EndBundle;
    out_->begin();
    out_->append(std::string_view(stream_.Data(), stream_.Size()));
    open_ = false;
  }

 private:
  static constexpr std::size_t kHeaderBytes = 16;
  static constexpr std::size_t padded(std::size_t size) { return (size + 3) / 4 * 4; }
  static std::size_t bytes(float /*value*/) { return 4; }
  static std::size_t bytes(osc::int32 /*value*/) { return 4; }
  static std::size_t bytes(bool /*value*/) { return 0; }
  static std::size_t bytes(const char* text) { return padded(std::string_view(text).size() + 1); }

  Datagrams* out_;
  std::array<char, 2048> buffer_;  ///< Larger than kMaxBytes: oscpack keeps its type tags at the far end.
  osc::OutboundPacketStream stream_;
  bool open_ = false;
};

}  // namespace mien::sink
