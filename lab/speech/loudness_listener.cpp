#include "lab/speech/loudness_listener.h"

#include <algorithm>
#include <cmath>

#include "mien/speech/articulator.h"

namespace mien::lab {

speech::Heard LoudnessListener::push(DeviceTime time, const speech::Block& block) {
  // A block: how fast the floor rises and the peak falls, dB.
  constexpr double kRise_db = 0.1, kFall_db = 1;
  constexpr double kVoice_db = 10, kOpen_db = 30, kOpen = 0.4, kDip_db = 12;
  const double level_db = 20 * std::log10(std::max(1e-4, double{speech::loudness_of(block).rms}));
  if (!begun_) floor_db_ = peak_db_ = level_db;
  begun_ = true;
  floor_db_ = std::min(level_db, floor_db_ + kRise_db);
  peak_db_ = std::max(level_db, peak_db_ - kFall_db);
  speech::Heard heard{.time = time + speech::kBlockDuration / 2, .weights = {}};
  heard.voice = level_db > floor_db_ + kVoice_db ? 1 : 0;
  heard.weights[face::shape("jawOpen")] =
      static_cast<float>(kOpen * std::clamp((level_db - floor_db_ - kVoice_db) / kOpen_db, 0.0, 1.0));
  heard.closure = peak_db_ > floor_db_ + kVoice_db && level_db < peak_db_ - kDip_db ? 1 : 0;
  speech::close_lips(heard.closure, heard.weights);
  return heard;
}

void LoudnessListener::reset() {
  begun_ = false;
}

}  // namespace mien::lab
