#include "mien/shaping/fallback.h"

#include <algorithm>

#include "mien/shaping/bounds.h"
#include "mien/shaping/fading.h"
#include "mien/shaping/frame_parts.h"

namespace mien::shaping {

namespace {

/// The frame after `shown` of a face that goes on as from `before` to it; head and eyes stay.
face::OutputFrame gone_on(const face::OutputFrame& before, const face::OutputFrame& shown) {
  face::OutputFrame next = shown;
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    next.weights[k] = std::clamp(2 * shown.weights[k] - before.weights[k], 0.0F, 1.0F);
  return next;
}

}  // namespace

Fallback::Fallback(const FallbackSettings& settings)
    : before_(face::neutral_frame({})), shown_(face::neutral_frame({})), from_(face::neutral_frame({})) {
  set(settings);
}

void Fallback::set(const FallbackSettings& settings) {
  settings_ = settings.within_range();
}

void Fallback::apply(face::OutputFrame& frame, std::size_t sensors_present) {
  if (sensors_present == 0)
    lose(frame);
  else
    follow(frame, sensors_present);
  before_ = begun_ ? shown_ : frame;
  shown_ = frame;
  begun_ = true;
}

void Fallback::lose(face::OutputFrame& frame) {
  if (phase_ != Phase::lost) {
    from_ = shown_;
    since_ = phase_ == Phase::waiting ? frame.time : shown_.time;
    phase_ = Phase::lost;
    ease_out_.stop();
  }
  const Fading fading(to_seconds(frame.time - since_), settings_);
  for (std::size_t part = 0; part < kPartCount; ++part) fading.apply(part, from_, frame);
  for (std::size_t r = 0; r < face::kShapeRegionCount; ++r)
    frame.region_confidence[r] = fading.fade(from_.region_confidence[r]);
}

void Fallback::follow(face::OutputFrame& frame, std::size_t sensors_present) {
  const bool back = phase_ == Phase::lost;
  if (back) from_ = shown_;
  if (back || (phase_ == Phase::following && sensors_present != sensors_present_)) {
    if (!ease_out_.active()) returning_ = back;
    since_ = shown_.time;
    // Of sensors that come and go with every frame only the first change goes on: else it would run away.
    ease_out_.begin_all(back || ease_out_.active() ? shown_ : gone_on(before_, shown_), frame);
  }
  phase_ = Phase::following;
  sensors_present_ = sensors_present;
  ease_out_.apply(frame, to_seconds(frame.time - shown_.time), settings_.return_s);
  if (returning_ && ease_out_.active()) fade_in(frame);
}

void Fallback::fade_in(face::OutputFrame& frame) const {
  // Confidence grows with the tracker's share of what is shown; provenance switches where that share is a
  // half.
  const double back =
      1 - offset_left(kConstantsTo5Percent / settings_.return_s * to_seconds(frame.time - since_));
  const auto share = static_cast<float>(back);
  for (std::size_t i = 0; i < face::kShapeCount; ++i) {
    frame.confidence[i] *= share;
    if (back < 0.5) frame.provenance[i] = from_.provenance[i];
  }
  for (float& confidence : frame.region_confidence) confidence *= share;
  frame.head_confidence *= share;
  frame.eyes_confidence *= share;
  if (back < 0.5) {
    frame.head_provenance = from_.head_provenance;
    frame.eyes_provenance = from_.eyes_provenance;
  }
}

}  // namespace mien::shaping
