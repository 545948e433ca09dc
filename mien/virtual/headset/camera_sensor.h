#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "mien/core/random.h"
#include "mien/virtual/headset/headset_faults.h"

namespace mien::virt {

/// What a camera's lens and sensor make of the light: sizes and pixels of one picture.
struct PictureSize {
  int width = 0, height = 0;
  bool operator==(const PictureSize&) const = default;
};

/// A camera's lens and sensor, drawn: vignetting, blur, grease, exposure control, noise, gamma, hot pixels.
/// The same stream and calls give the same bits. Thread: one at a time.
class CameraSensor {
 public:
  /// `distance_m`: of what it looks at, usually. `pixel`: the tangent that one fills. `usual`: the radiance
  /// of skin there as the lamps light it; what has less than kAmplified of it is amplified, noise and all.
  CameraSensor(const HeadsetFaults& faults, PictureSize size, float distance_m, float pixel, double usual,
               Random random);

  static constexpr double kAmplified = 0.25;

  /// One picture, grey, row by row, of the radiance at each pixel; `time_s` does not run backwards. The
  /// radiance is blurred in place. Exposure follows from picture to picture, the first is exposed right.
  void expose(double time_s, std::span<float> radiance, std::span<std::uint8_t> out);

  /// Grease on the lens spreads this share of the light, 0 to 1.
  void set_smear(float share) { smear_ = share; }
  [[nodiscard]] float smear() const { return smear_; }

 private:
  void blur(std::span<float> picture);
  void spread(std::span<float> picture);

  HeadsetFaults faults_;
  PictureSize size_;
  std::vector<float> vignette_;  // Beside the pixels: factor.
  std::vector<float> kernel_;    // Of the blur: the middle one and those to one side.
  float smear_ = 0;
  double target_ = 0.45;
  double full_gain_ = 1;  // What exposure alone can do.
  double gain_ = 0;       // 0: not yet exposed.
  double exposed_s_ = 0;
  std::array<std::uint8_t, 4097> developed_{};  // Of light, in 4096ths of full scale.
  std::vector<float> noise_;                    // Standard normal, read from places that are drawn.
  struct HotPixel {
    std::size_t place;
    std::uint8_t value;
  };
  std::vector<HotPixel> hot_;
  std::vector<float> memory_, seen_;
  Random random_;
};

}  // namespace mien::virt
