#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "mien/headset/picture_fault.h"
#include "mien/sensor/payload_stream.h"

namespace mien::headset {

/// Where a camera's connection is left by pictures that no session would decode (jpeg_gate.h), each counted
/// by what is wrong with it. No allocation in passes().
class StreamGate {
 public:
  [[nodiscard]] bool passes(std::span<const std::byte> jpeg);
  /// `found`: what the stream was found to hold, its whole pictures before the gate.
  [[nodiscard]] sensor::StreamCounts counts(const sensor::StreamCounts& found) const;
  [[nodiscard]] std::vector<sensor::Refusal> refusals() const;

 private:
  std::array<std::uint64_t, kPictureFaults> faults_{};
  std::uint64_t refused_ = 0;
};

}  // namespace mien::headset
