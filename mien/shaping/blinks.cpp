#include "mien/shaping/blinks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "mien/core/random.h"

namespace mien::shaping {
namespace {

using face::Provenance;
using face::shape;

struct Eye {
  std::size_t blink;
  std::size_t wide;
  std::size_t squint;
};
constexpr std::array<Eye, 2> kEyes = {Eye{shape("eyeBlink_L"), shape("eyeWide_L"), shape("eyeSquint_L")},
                                      Eye{shape("eyeBlink_R"), shape("eyeWide_R"), shape("eyeSquint_R")}};

constexpr std::uint64_t kSeed = 3;
constexpr double kFastTurn_rad_s = 2;      // A glance over the shoulder, not a nod.
constexpr double kFastSquint_per_s = 2.5;  // Weight; a tracker's noise stays below 1.
constexpr double kLeastPause_s = 0.4;      // From the end of one blink to the next.
constexpr double kFade_s = 0.2;            // When a sensor begins or ceases to observe the lid.
constexpr double kNone = 0.2,
                 kTwo = 0.2;  // Shares of intervals of the mean length with no blink and with two.

/// The spontaneous blink whose beginning lies within the step that ends at `time_s`.
std::optional<face::Blink> spontaneous(double time_s, double step_s, double rate_per_min) {
  if (rate_per_min <= 0) return {};
  const double interval_s = 60 / rate_per_min;
  const double number = std::floor(time_s / interval_s);
  Random random = Random(kSeed).fork("blinks", static_cast<std::uint64_t>(static_cast<std::int64_t>(number)));
  const double which = random.uniform();
  const int count = which < kNone ? 0 : which < kNone + kTwo ? 2 : 1;
  for (int i = 0; i < count; ++i) {
    const double begin_s = (number + random.uniform()) * interval_s;
    const face::Blink blink = face::draw_blink(begin_s, random);
    if (begin_s <= time_s && begin_s > time_s - step_s) return blink;
  }
  return {};
}

}  // namespace

bool Blinks::Cue::begins(double speed, double threshold) {
  const bool was = high;
  high = speed > (was ? 0.5 : 1) * threshold;
  return high && !was;
}

bool Blinks::cued(const face::OutputFrame& frame, double step_s) {
  const double turned_rad =
      frame.head_provenance == Provenance::measured ? frame.head.angularDistance(last_.head) : 0;
  bool cue = turn_.begins(turned_rad / step_s, kFastTurn_rad_s);
  for (std::size_t e = 0; e < 2; ++e) {
    const std::size_t squint = kEyes[e].squint;
    const double rise = frame.provenance[squint] == Provenance::measured
                            ? static_cast<double>(frame.weights[squint] - last_.weights[squint])
                            : 0;
    cue = squints_[e].begins(rise / step_s, kFastSquint_per_s) || cue;
  }
  return cue;
}

void Blinks::apply(face::OutputFrame& frame, double rate_per_min) {
  const double time_s = to_seconds(frame.time.time_since_epoch());
  const double step_s = begun_ ? std::clamp(to_seconds(frame.time - last_.time), 1e-3, 0.1) : 1e-3;
  const bool cue = begun_ && cued(frame, step_s);
  if (!blink_ || time_s > blink_->end_s() + kLeastPause_s) {
    blink_ = spontaneous(time_s, step_s, rate_per_min);
    if (!blink_ && cue && rate_per_min > 0) {
      Random random =
          Random(kSeed).fork("cued", static_cast<std::uint64_t>(frame.time.time_since_epoch().count()));
      blink_ = face::draw_blink(time_s, random);
    }
  }
  for (std::size_t e = 0; e < 2; ++e) {
    const Eye& eye = kEyes[e];
    const bool shown = frame.provenance[eye.blink] == Provenance::predicted;
    share_[e] =
        begun_ ? std::clamp(share_[e] + static_cast<float>((shown ? step_s : -step_s) / kFade_s), 0.0F, 1.0F)
               : (shown ? 1.0F : 0.0F);
    if (!blink_ || share_[e] == 0) continue;
    const float shut = share_[e] * static_cast<float>(blink_->at(time_s, static_cast<int>(e)));
    if (shut <= 0) continue;
    float& lid = frame.weights[eye.blink];
    lid = std::max(lid, lid + shut * (1 - lid));
    frame.confidence[eye.blink] *= 1 - shut;
    if (frame.provenance[eye.wide] != Provenance::predicted) continue;
    frame.weights[eye.wide] *= 1 - shut;
    frame.confidence[eye.wide] *= 1 - shut;
  }
  last_ = frame;
  begun_ = true;
}

}  // namespace mien::shaping
