#include "mien/shaping/resting.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "mien/core/smoothstep.h"

namespace mien::shaping {
namespace {

/// Ten seconds of the 60 Hz grid: enough frames to tell rest from what is performed meanwhile.
constexpr std::size_t kEnoughValues = 600;
constexpr float kLeastConfidence = 0.5F;
/// Blinks are looked for from here on: a rest of less than a second is no rest.
constexpr std::size_t kLeastValues = 60;
/// Weights rise from rest: a mode above what the lowest 2 % reach is performed. Half a bin is granted: of a
/// face that keeps still the lowest 2 % reach no further than the lower edge of the bin in whose middle it
/// rests.
constexpr double kLowestShare = 0.02;
constexpr double kHalfBin = 0.5 / (StreamingMode::kBins - 1);
/// A tracker that reads open lids right is believed of closed ones: only from this rest on the blinks' peak
/// is taken for closed as it is, and below in proportion.
constexpr float kUnusualRest = 0.1F;
constexpr double kEaseIn_s = 2;
constexpr double kChangeOver_s = 0.5;
constexpr double kSlew_per_s = 0.02;

/// The shapes with a rule, in the profile's order.
constexpr auto kShapes = [] {
  std::array<std::size_t, kRestAtZero.size() + kLids.size()> shapes{};
  std::size_t count = 0;
  for (std::size_t i = 0; i < face::kShapeCount; ++i)
    if (kRestingRules[i] != RestingRule::none) shapes.at(count++) = i;
  return shapes;
}();

float stepped(float from, float to, double most) {
  return from + static_cast<float>(std::clamp(static_cast<double>(to) - from, -most, most));
}

/// Shapes that blinks and lowered eyes bring to 0: lower values say nothing of their rest.
bool falls_in_blinks(std::size_t shape) {
  return shape == face::shape_index("eyeWide_L") || shape == face::shape_index("eyeWide_R");
}

/// Which of kLids a shape is.
std::size_t lid_of(std::size_t shape) {
  return shape == face::shape_index(kLids[0]) ? 0 : 1;
}

bool trusted(const face::OutputFrame& frame, std::size_t shape) {
  return frame.provenance[shape] == face::Provenance::measured &&
         frame.confidence[shape] >= kLeastConfidence && std::isfinite(frame.weights[shape]);
}

}  // namespace

void Resting::set(bool on) {
  if (on == on_) return;
  on_ = on;
  idle_ = false;
  changed_ = true;
  forget();
}

void Resting::use(const RestingFace& face) {
  learnt_ = face.within_range();
  changed_ = true;
  forget();
}

void Resting::reset() {
  forget();
  for (Ease& ease : eases_) ease.active = false;
  changed_ = false;
  begun_ = false;
  present_ = on_ ? learnt_ : RestingFace{};
}

void Resting::forget() {
  for (StreamingMode& seen : seen_) seen.reset();
  for (BlinkPeaks& blinks : blinks_) blinks.reset();
}

void Resting::apply(face::OutputFrame& frame) {
  const double step_s = begun_ ? to_seconds(frame.time - last_) : 0;
  begun_ = true;
  last_ = frame.time;
  if (idle_) return;
  if (changed_) {
    for (std::size_t c = 0; c < kCalibrated; ++c) begin_ease(c, frame.time, kChangeOver_s);
    changed_ = false;
  }
  for (std::size_t c = 0; c < kCalibrated; ++c) {
    const std::size_t shape = kShapes[c];
    if (on_ && trusted(frame, shape))
      learn(c, frame, step_s);
    else if (on_ && kRestingRules[shape] == RestingRule::lids)
      blinks_.at(lid_of(shape)).lose();
    ease_on(c, frame.time);
    frame.weights[shape] = present_.applied(shape, frame.weights[shape]);
  }
  idle_ = !on_ && std::ranges::none_of(eases_, &Ease::active);
}

void Resting::learn(std::size_t c, const face::OutputFrame& frame, double step_s) {
  const std::size_t shape = kShapes[c];
  StreamingMode& seen = seen_[c];
  seen.add(frame.weights[shape]);
  const bool lids = kRestingRules[shape] == RestingRule::lids;
  if (seen.count() < (lids ? kLeastValues : kEnoughValues)) return;
  float& rest = learnt_.rest[shape];
  const double mode = seen.mode();
  const double lowest = falls_in_blinks(shape) ? mode : seen.upper(1 - kLowestShare);
  const double usual = std::min(mode, lowest > 0 ? lowest + kHalfBin : 0);
  const float target = mode <= RestingFace::kRestAtMost ? static_cast<float>(usual) : rest;
  if (lids) blinks_.at(lid_of(shape)).add(frame.weights[shape], target);
  if (seen.count() < kEnoughValues) return;
  // What nothing is known of yet may begin where it was seen, eased in; later it creeps.
  if (!learnt_.changes(shape) && seen.count() == kEnoughValues) {
    begin_ease(c, frame.time, kEaseIn_s);
    rest = target;
  }
  const double most = kSlew_per_s * step_s;
  rest = stepped(rest, target, most);
  if (lids) learn_full(shape, most);
}

void Resting::learn_full(std::size_t shape, double most) {
  const float rest = learnt_.rest[shape];
  float& full = learnt_.full[shape];
  if (const std::optional<float> closed = blinks_.at(lid_of(shape)).largest()) {
    const float believed = 1 - std::min(1.0F, rest / kUnusualRest) * (1 - *closed);
    full = stepped(full, std::clamp(believed, rest + RestingFace::kLeastRange, 1.0F), most);
  }
  full = std::max(full, rest + RestingFace::kLeastRange);
}

void Resting::begin_ease(std::size_t c, DeviceTime time, double length_s) {
  const std::size_t shape = kShapes[c];
  eases_[c] = {.active = true,
               .since = time,
               .length_s = length_s,
               .rest = present_.rest[shape],
               .full = present_.full[shape]};
}

void Resting::ease_on(std::size_t c, DeviceTime time) {
  const std::size_t shape = kShapes[c];
  const float rest = on_ ? learnt_.rest[shape] : 0;
  const float full = on_ ? learnt_.full[shape] : 1;
  Ease& ease = eases_[c];
  const double u = ease.active ? to_seconds(time - ease.since) / ease.length_s : 1;
  if (u >= 1) {
    ease.active = false;
    present_.rest[shape] = rest;
    present_.full[shape] = full;
    return;
  }
  const auto s = static_cast<float>(smoothstep(u));
  present_.rest[shape] = ease.rest + s * (rest - ease.rest);
  present_.full[shape] = ease.full + s * (full - ease.full);
}

}  // namespace mien::shaping
