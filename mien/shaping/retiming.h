#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "mien/core/time.h"

namespace mien::shaping {

/// What lies between sound and face beyond their clocks: a wireless microphone, sensors that are filtered.
/// The lag of the jaw as it is heard behind the jaw as it is sensed, followed by correlation over 20 s of
/// frames in which both are known (REFA's supplement, 1.4, names the step and no figures: all of them are
/// ours). A lag is believed where its correlation is above kPeak and kLead above every other peak, and where
/// frames enough were seen; the offset moves towards it by kSpeed, and stays where none is believed. No
/// allocation. A pure function of the calls.
class Retiming {
 public:
  static constexpr int kFarthest_ms = 250, kStep_ms = 5;
  static constexpr double kPeak = 0.4, kLead = 0.1;
  static constexpr double kSpeed_ms_per_s = 5;
  static constexpr std::size_t kFrames = 1'200;  ///< 20 s.
  static constexpr std::size_t kFewest = 300;    ///< Frames of which both are known: 5 s.
  static constexpr std::size_t kEvery = 60;      ///< Frames between two looks.

  /// The next frame's jaws, 0 to 1; none where either is unknown. `heard`: as it was asked for, at the
  /// frame's time and offset(), and was told `behind` of that: what is not heard yet cannot be asked for, so
  /// the offset rises no further while it is.
  void push(std::optional<float> heard, std::optional<float> sensed, Duration behind = {});
  /// What is heard is to be asked for so much later: above 0 where sound lags behind the face.
  [[nodiscard]] Duration offset() const;
  /// Whether the last look believed a lag.
  [[nodiscard]] bool follows() const { return believed_ms_.has_value(); }
  void reset();

 private:
  void look();
  [[nodiscard]] double correlation_at(int lag_ms) const;

  std::array<float, kFrames> heard_{}, sensed_{};
  std::array<float, kFrames> asked_ms_{};  // The offset at which it was told.
  std::array<bool, kFrames> known_{};
  std::size_t next_ = 0;
  std::size_t since_look_ = 0;
  std::optional<int> believed_ms_;
  double offset_ms_ = 0;
};

}  // namespace mien::shaping
