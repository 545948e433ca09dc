#include "lab/speech/sound_conditions.h"

#include "mien/synthetic/speech/other_sounds.h"

namespace mien::lab {

std::vector<float> disturbed(std::span<const float> sound, std::size_t condition, const Random& random) {
  std::vector<float> out(sound.begin(), sound.end());
  Random drawn = random.fork("condition", condition);
  const auto noise = [&](double snr_db) {
    const auto kind =
        static_cast<synthetic::OtherSound>(drawn.below(5));  // Breath and cough are for those who speak.
    synthetic::mix_at(snr_db, synthetic::make_other_sound(kind, out.size(), drawn.fork("noise")), out);
  };
  switch (condition) {
    case 1:
      noise(20);
      break;
    case 2:
      noise(10);
      break;
    case 3:
      noise(5);
      break;
    case 4:
      synthetic::put_in_room(0.4, 3, drawn.fork("room"), out);
      break;
    case 5:
      for (float& s : out) s *= 0.1F;
      break;
    case 6:
      synthetic::limit_band(300, 3400, out);
      break;
    default:
      break;
  }
  return out;
}

}  // namespace mien::lab
