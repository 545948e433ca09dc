#include "mien/shaping/shaper.h"

#include <utility>

#include "mien/shaping/bounds.h"
#include "mien/shaping/eyes.h"

namespace mien::shaping {

namespace {

/// Nothing is left that was heard. Returns how many sensors count then.
std::size_t take_out_audio(face::OutputFrame& frame, std::size_t sensors_present) {
  bool heard = false, others = false;
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    others = others || (frame.provenance[k] != face::Provenance::audio &&
                        frame.provenance[k] != face::Provenance::neutral);
    if (frame.provenance[k] != face::Provenance::audio) continue;
    heard = true;
    frame.provenance[k] = face::Provenance::neutral;
    frame.weights[k] = frame.confidence[k] = 0;
  }
  if (heard && !others) frame.tongue_out = 0;
  return heard && !others ? 0 : sensors_present;
}

}  // namespace

Shaper::Shaper(const ShaperSettings& settings, std::vector<std::string> modalities)
    : last_(face::neutral_frame({})), merge_(std::move(modalities)) {
  set(settings);
}

void Shaper::set(const ShaperSettings& settings) {
  settings_ = settings;
  limited_ = settings.limits != Limits{} && settings.runs(ChainStep::gains);
  merge_.set(settings.merge, settings.fallback, settings.runs(ChainStep::merge));
  fallback_.set(settings.fallback);
  if (!settings.runs(ChainStep::fallback)) {
    fallback_.reset();
    position_.reset();
  }
  resting_.set(settings.resting && settings.runs(ChainStep::resting));
  const bool smooth = settings.runs(ChainStep::smoothing);
  smoothing_.set(smoothing_for(smooth ? settings.smoothing : 0, smooth && settings.smooth_head));
  if (!settings.runs(ChainStep::blinks)) blinks_.reset();
  if (!settings.runs(ChainStep::gaze)) lids_.reset();
}

void Shaper::reset() {
  begun_ = false;
  last_ = face::neutral_frame({});
  merge_.reset();
  fallback_.reset();
  resting_.reset();
  recentre_.settle();
  position_.reset();
  blinks_.reset();
  lids_.reset();
  smoothing_.reset();
}

std::size_t Shaper::merge(std::span<const Merge::Source> sources, face::OutputFrame& frame) {
  const Merge::Source& first = sources.front();
  // What a lone tracker's sensors explain was not measured: there is nothing to select by.
  if (sources.size() > 1 ||
      (first.explained != nullptr && settings_.runs(ChainStep::mend) && settings_.runs(ChainStep::merge)))
    return merge_.apply(sources, frame);
  frame = *first.frame;
  return first.sensors_present;
}

void Shaper::apply(face::OutputFrame& frame, std::size_t sensors_present,
                   const tracker::Explained* explained) {
  face::OutputFrame estimate = frame;
  const Merge::Source source{.frame = &estimate, .sensors_present = sensors_present, .explained = explained};
  apply({&source, 1}, frame);
}

std::size_t Shaper::apply(std::span<const Merge::Source> sources, face::OutputFrame& frame) {
  if (begun_ && sources.front().frame->time <= last_.time) reset();
  const std::size_t merged = merge(sources, frame);
  std::size_t sensors_present = merged;
  if (!settings_.merge.audio) sensors_present = take_out_audio(frame, sensors_present);
  const double return_s = settings_.fallback.within_range().return_s;
  const bool bounded = settings_.runs(ChainStep::bounds), gazing = settings_.runs(ChainStep::gaze);
  if (settings_.runs(ChainStep::mend)) mend(frame, last_);
  last_ = frame;
  if (settings_.runs(ChainStep::fallback)) fallback_.apply(frame, sensors_present);
  recentre_.observe(frame);
  resting_.apply(frame);
  if (settings_.runs(ChainStep::recentring)) recentre_.take_off(frame, resting_.present());
  if (settings_.runs(ChainStep::fallback)) position_.apply(frame, return_s);
  if (settings_.runs(ChainStep::blinks)) blinks_.apply(frame, settings_.blinks_per_min);
  if (limited_) settings_.limits.apply(frame);
  smoothing_.apply(frame);
  const bool ruled = settings_.runs(ChainStep::constraints);
  if (ruled && settings_.constraints) settings_.rules.live().project(frame.weights);
  if (bounded && begun_) bound_steps(frame, shown_);
  if (gazing) lids_.apply(frame, settings_.lids_follow_eyes, return_s);
  if (bounded) bound(frame);
  if (ruled) settings_.rules.always().project(frame.weights);
  if (gazing) eyes_from_weights(frame);
  shown_ = frame;
  begun_ = true;
  return merged;
}

}  // namespace mien::shaping
