#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "mien/core/error.h"

namespace mien {

/// Sound of one channel.
struct Sound {
  std::uint32_t rate_hz = 0;
  std::vector<float> samples;  ///< -1 to 1.
  /// Samples after these that its file promised and that are not in it: it was cut short.
  std::size_t missing = 0;

  [[nodiscard]] double duration_s() const {
    return rate_hz == 0 ? 0 : static_cast<double>(samples.size()) / rate_hz;
  }
};

/// Reads a RIFF WAVE file of 16-bit integers or 32-bit floats; several channels become their mean. A data
/// chunk that promises more than is there gives what is there, since recorders that were killed leave such
/// files; one of 0xFFFFFFFF bytes promises nothing, since who writes to a pipe does not know. Errors:
/// malformed, truncated, unsupported (another coding), out_of_range (a rate outside 1 kHz to 768 kHz, a
/// sample that is not finite). `name` is what errors call it.
[[nodiscard]] Result<Sound> parse_wav(std::span<const std::byte> bytes, std::string_view name);

/// The sound as a RIFF WAVE file of 16-bit integers; what exceeds -1 to 1 is clipped.
[[nodiscard]] std::vector<std::byte> format_wav(const Sound& sound);

}  // namespace mien
