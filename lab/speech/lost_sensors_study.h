#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "lab/speech/hand_over.h"
#include "lab/speech/spoken_session.h"
#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/face/motion.h"
#include "mien/performer/speaker.h"

namespace mien::lab {

struct LostSensorsRequest {
  int people = 5;     ///< Seeds from `seed` on: another person, voice and moment each.
  double lost_s = 2;  ///< How long nothing comes from any sensor.
  std::uint64_t seed = 1;
  unsigned threads = 0;  ///< 0: one a core.
};

/// Sensors that are lost in the middle of a sentence and come back: what is shown with a microphone, and
/// without.
struct LostSensorsRow {
  bool audio = false;
  HandOver over;
};
struct LostSensorsPerson {
  std::uint64_t seed = 0;
  std::string voice;
  LostSensorsRow held, heard;  ///< Hold and neutral; sound.
  /// The performance around the loss, 60 Hz from a second before it to a second after it, for a film: as it
  /// was, and both.
  face::Motion truth, shown_held, shown_heard;
  Sound sound;  ///< What is heard meanwhile.
};

/// Lets people speak with sensors that are lost for a while. Voices are those for tests, sound is clean and
/// not retimed: in so short a passage no lag is found. Errors: check_scene()'s; the speaker's, the devices',
/// the model's; cancelled.
[[nodiscard]] Result<std::vector<LostSensorsPerson>> study_lost_sensors(const LostSensorsRequest& request,
                                                                        const SpokenScene& scene,
                                                                        const performer::Speaker& speaker,
                                                                        const Progress& progress);

}  // namespace mien::lab
