#include "lab/speech/passage_microphone.h"

#include <utility>

namespace mien::lab {

Result<std::unique_ptr<PassageMicrophone>> PassageMicrophone::create(const synthetic::SpokenPassage& passage,
                                                                     DeviceTime begin,
                                                                     speech::SpeechTracker::MakeListener make,
                                                                     Asked asked) {
  sensor::Rig rig{.name = "microphone", .reference = "microphone"};
  rig.sensors.push_back({.name = "microphone", .kind = "speech", .role = "face"});
  MIEN_TRY_ASSIGN(auto listener, speech::SpeechTracker::create(rig, std::move(make)));
  return std::unique_ptr<PassageMicrophone>(
      new PassageMicrophone(synthetic::blocks_of(passage.sound), begin, std::move(listener), asked));
}

void PassageMicrophone::hear(DeviceTime frame) {
  frame_ = frame;
  for (; next_ < blocks_.size(); ++next_) {
    const DeviceTime middle =
        begin_ + speech::kBlockDuration * static_cast<std::int64_t>(next_) + speech::kBlockDuration / 2;
    // A frame waits for the sample that reaches it.
    if (middle > frame + speech::kBlockDuration / 2) break;
    sensor::Sample sample;
    sample.kind = sensor::SampleKind::sound;
    sample.time = middle;
    const HostTime arrival(middle.time_since_epoch());
    lines_.add(arrival, sample);
    listener_->add_with_payload(arrival, sample, speech::payload_of(blocks_[next_]));
  }
}

tracker::TickResult PassageMicrophone::tick(DeviceTime frame, const sensor::TimeLines&,
                                            face::OutputFrame& out) {
  return listener_->tick(asked_ == Asked::as_told ? frame : frame_, lines_, out);
}

}  // namespace mien::lab
