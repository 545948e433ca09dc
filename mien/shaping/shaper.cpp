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
  smoothing_.set(smoothing_for(settings.smoothing, settings.smooth_head));
}

void Shaper::reset() {
  begun_ = false;
  last_ = neutral_frame({});
  fallback_.reset();
  recentre_.settle();
  lids_.reset();
  smoothing_.reset();
}

void Shaper::apply(face::OutputFrame& frame, std::size_t sensors_present) {
  if (begun_ && frame.time <= last_.time) reset();
  mend(frame, last_);
  last_ = frame;
  fallback_.apply(frame, sensors_present);
  recentre_.apply(frame);
  lids_.apply(frame, settings_.lids_follow_eyes, settings_.fallback.within_range().return_s);
  if (limited_) settings_.limits.apply(frame);
  smoothing_.apply(frame);
  if (begun_) bound_steps(frame, shown_);
  bound(frame);
  eyes_from_weights(frame);
  shown_ = frame;
  begun_ = true;
}

}  // namespace mien::shaping
