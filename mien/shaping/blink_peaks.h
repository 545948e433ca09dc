#pragma once

#include <array>
#include <cstddef>
#include <optional>

namespace mien::shaping {

/// How far one lid closes, from its last 16 closures (about a minute of blinks). A closure begins where the
/// lid is 0.15 above its rest, and ends below half of that. No allocation.
class BlinkPeaks {
 public:
  static constexpr std::size_t kKept = 16;
  /// Fewer say nothing: one may have been a half-closed lid, or no blink at all.
  static constexpr std::size_t kLeast = 3;

  /// The next frame's weight, finite, and what the lid rests at.
  void add(float weight, float rest);
  /// A frame of which nothing is known: a closure under way, whose peak may lie in it, does not count.
  void lose();
  /// The largest weight of all closures kept: people close their lids halfway more often than too far. None
  /// before there are kLeast.
  [[nodiscard]] std::optional<float> largest() const;
  void reset() { *this = {}; }

 private:
  std::array<float, kKept> peaks_{};  // In the order in which they came, from next_ on once full.
  std::size_t count_ = 0;
  std::size_t next_ = 0;
  bool closing_ = false;
  bool seen_open_ = false;  // Since the last lost frame: what was closed before has an unknown peak.
  float peak_ = 0;
};

}  // namespace mien::shaping
