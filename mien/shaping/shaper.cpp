#include "mien/shaping/shaper.h"

#include "mien/shaping/bounds.h"
#include "mien/shaping/eyes.h"

namespace mien::shaping {

Shaper::Shaper(const ShaperSettings& settings) : last_(neutral_frame({})) {
  set(settings);
}

void Shaper::set(const ShaperSettings& settings) {
  settings_ = settings;
  limited_ = settings.limits != Limits{};
  fallback_.set(settings.fallback);
  resting_.set(settings.resting);
  smoothing_.set(smoothing_for(settings.smoothing, settings.smooth_head));
}

void Shaper::reset() {
  begun_ = false;
  last_ = neutral_frame({});
  fallback_.reset();
  resting_.reset();
  recentre_.settle();
  lids_.reset();
  smoothing_.reset();
}

void Shaper::apply(face::OutputFrame& frame, std::size_t sensors_present) {
  if (begun_ && frame.time <= last_.time) reset();
  mend(frame, last_);
  last_ = frame;
  fallback_.apply(frame, sensors_present);
  recentre_.observe(frame);
  resting_.apply(frame);
  recentre_.take_off(frame, resting_.present());
  lids_.apply(frame, settings_.lids_follow_eyes, settings_.fallback.within_range().return_s);
  if (limited_) settings_.limits.apply(frame);
  smoothing_.apply(frame);
  if (settings_.constraints) settings_.rules.live().project(frame.weights);
  if (begun_) bound_steps(frame, shown_);
  bound(frame);
  settings_.rules.always().project(frame.weights);
  eyes_from_weights(frame);
  shown_ = frame;
  begun_ = true;
}

}  // namespace mien::shaping
