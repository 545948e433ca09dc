#include "lab/speech/heard_frames.h"

#include "mien/core/time.h"
#include "mien/speech/spoken_mouth.h"

namespace mien::lab {

void hear_frames(speech::Listener& listener, std::span<const speech::Block> blocks, const SeeHeard& see) {
  listener.reset();
  speech::SpokenMouth mouth(listener.smoothing());
  DeviceTime block_time{};
  std::int64_t frame = 0;
  for (const speech::Block& block : blocks) {
    mouth.push(listener.push(block_time, block));
    // A frame is fired by the sample that reaches it, which is in the middle of its block.
    for (; DeviceTime(frame_offset(frame)) <= block_time + speech::kBlockDuration / 2; ++frame) {
      const DeviceTime time(frame_offset(frame));
      see(time, mouth.tick(time));
    }
    block_time += speech::kBlockDuration;
  }
}

}  // namespace mien::lab
