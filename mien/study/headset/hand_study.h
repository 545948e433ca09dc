#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/core/wav.h"
#include "mien/face/output_frame.h"
#include "mien/headset/headset_model.h"
#include "mien/sensor/rig.h"
#include "mien/speech/speech_network.h"
#include "mien/study/speech/hand_over.h"
#include "mien/study/speech/speaker.h"

namespace mien::study {

/// A hand that comes before the mouth in the middle of a sentence and leaves it again: what a session with a
/// headset shows, with a microphone and without.
struct HandStudyRequest {
  int people = 5;       ///< Seeds from `seed` on: another wearer, voice and moment each.
  double hand_s = 1.5;  ///< How long the hand is there.
  std::uint64_t seed = 1;
  unsigned threads = 0;  ///< 0: one a core.
};

struct HandScene {
  sensor::Rig rig;  ///< Of nothing but cameras.
  std::shared_ptr<const headset::HeadsetModel> model;
  speech::SpeechNetworkFile network;
};

struct HandRow {
  HandOver over;  ///< Of the hand as a loss.
  /// What the hand moves: mean absolute difference that it makes to weights of mouth and jaw that claim to be
  /// sensed while it is there, ...
  double mouth_change = 0;
  double last_change = 0;  ///< ... and of the last frame before it is noticed, which is then held.
};

/// One moment of the performance, for a picture.
struct HandMoment {
  double time_s = 0;                     ///< From when the hand is there.
  std::vector<std::uint8_t> mouth_view;  ///< What the network sees of the first mouth camera, square, grey.
  face::OutputFrame truth, held, heard;
};
struct HandPerson {
  std::uint64_t seed = 0;
  std::string voice;
  HandRow held, heard;              ///< Without a microphone, with one.
  std::vector<HandMoment> moments;  ///< Every frame from half a second before the hand to the end.
  Sound sound;                      ///< What is said meanwhile, from the first moment on.
};

/// Wearers, voices and hands that nothing learnt from. A second of neutral, two and a half of speech, the
/// hand, one and a half without it; views are drawn as the network sees them (film_wearer), sound is clean
/// and not retimed. Errors: bad_usage (a rig of other sensors too); the wearer's, the speaker's, the
/// networks'; cancelled.
[[nodiscard]] Result<std::vector<HandPerson>> study_hand(const HandStudyRequest& request,
                                                         const HandScene& scene, const Speaker& speaker,
                                                         const Progress& progress);

}  // namespace mien::study
