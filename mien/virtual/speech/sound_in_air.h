#pragma once

#include <vector>

#include "mien/core/error.h"
#include "mien/core/wav.h"

namespace mien::virt {

/// The sound of a performance as the air has it: at any moment of the motion. Immutable.
class SoundInAir {
 public:
  /// Silence.
  SoundInAir() = default;
  /// From the motion's time 0 on, by the way of every sound of the program (speech::BlockMaker). Errors:
  /// out_of_range (a rate outside 1 kHz to 768 kHz).
  [[nodiscard]] static Result<SoundInAir> of(const Sound& sound);

  /// -1 to 1, and a little beyond between two samples at full scale; 0 before and after it.
  [[nodiscard]] double at(double motion_s) const;

 private:
  std::vector<float> samples_;  // Of speech::kRateHz.
};

}  // namespace mien::virt
