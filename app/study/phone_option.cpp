#include "app/study/phone_option.h"

#include <fmt/format.h>

#include <vector>

#include "mien/core/excerpt.h"
#include "mien/modalities/modalities.h"

namespace mien::app {

Result<void> check_aligns(const take::Take& take) {
  if (modalities::has_window_models(take.rig())) return {};
  return fail(ErrorCode::unsupported, "its sensors do not sit on the skin, whose turns tell a phone's time",
              take.path().string(), "use a take of IMUs");
}

Result<study::PhoneTrack> open_phone_track(const take::Take& take,
                                           std::span<const model::FeatureFrame> features,
                                           const std::string& file) {
  if (file.empty()) {
    MIEN_TRY_ASSIGN(const std::vector<take::StoredSample> samples, take.samples());
    auto own = study::phone_track(take.rig(), samples, features.front().time);
    if (!own) own.error().where = take.path().string();
    return own;
  }
  std::vector<std::string> warnings;
  MIEN_TRY_ASSIGN(study::PhoneTrack track, study::phone_track(file, &warnings));
  for (const std::string& warning : warnings)
    fmt::print(stderr, "mien: {}: {}\n", without_controls(file), without_controls(warning));
  return track;
}

}  // namespace mien::app
