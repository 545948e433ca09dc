#include "mien/speech/speech_tracker.h"

#include <algorithm>
#include <utility>

#include "mien/sensor/rig_part.h"

namespace mien::speech {
namespace {

using face::Provenance;

/// Times that run back farther than this are of another start of the microphone.
constexpr Duration kRestart = std::chrono::milliseconds(200);

}  // namespace

Result<std::unique_ptr<SpeechTracker>> SpeechTracker::create(const sensor::Rig& rig, MakeListener make) {
  const std::vector<std::uint16_t> microphones = sensor::sensors_of(rig, "speech");
  if (microphones.empty())
    return fail(ErrorCode::mismatch, "no sensor of this rig is of the kind speech", "rig " + rig.name);
  return std::unique_ptr<SpeechTracker>(new SpeechTracker(microphones.front(), std::move(make)));
}

void SpeechTracker::forget_all() {
  if (listener_) listener_->reset();
  mouth_.reset();
  last_block_.reset();
}

void SpeechTracker::forget(std::uint16_t sensor) {
  if (sensor == sensor_) forget_all();
}

void SpeechTracker::add_with_payload(HostTime, const sensor::Sample& sample,
                                     std::span<const std::byte> payload) {
  if (sample.sensor != sensor_) return;
  const auto block = samples_of(payload);
  if (!block) return;
  if (last_block_) {
    const Duration since = sample.time - *last_block_;
    if (since < -kRestart)
      forget_all();
    else if (since <= Duration::zero())
      return;  // Doubled, or out of order.
    else if (since > kPresent)
      forget_all();  // What is remembered of before a gap is of no use.
  }
  last_block_ = sample.time;
  if (const MakeListener make = std::exchange(make_, nullptr))
    if (auto made = make()) {
      listener_ = *std::move(made);
      mouth_ = SpokenMouth(listener_->smoothing());
    }
  if (!listener_) return;
  mouth_.push(listener_->push(sample.time - kBlockDuration / 2, *block));
}

tracker::TickResult SpeechTracker::tick(DeviceTime frame, const sensor::TimeLines& lines,
                                        face::OutputFrame& out) {
  tracker::TickResult result{.hearing = tracker::TickResult::Hearing{}};
  out = face::neutral_frame(frame);
  if (!lines.ready() || !last_block_) return result;
  const DeviceTime time = lines.from_line(sensor_, frame);
  if (time - *last_block_ > kPresent) {
    mouth_.reset();
    return result;
  }
  result.sensors_present = 1;
  const std::optional<Heard> heard = mouth_.tick(time);
  result.hearing->speaks = heard.has_value();
  if (!heard) return result;
  result.hearing->behind = std::max(Duration::zero(), time - heard->time);
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    if (is_heard(k)) out.weights[k] = heard->weights[k];
  if (const tracker::ShapeConfidence* const confidence = listener_->confidence()) {
    tracker::Coverage coverage;
    coverage.fill(heard->voice);
    confidence->write(coverage, out);
  }
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    out.provenance[k] = is_heard(k) ? Provenance::audio : Provenance::neutral;
    if (!is_heard(k)) out.confidence[k] = 0;
  }
  for (std::size_t r = 0; r < face::kShapeRegionCount; ++r)
    if (!is_heard(static_cast<face::ShapeRegion>(r))) out.region_confidence[r] = 0;
  out.tongue_out = heard->tongue;
  return result;
}

}  // namespace mien::speech
