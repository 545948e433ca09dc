#include "app/study/truth_option.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "app/study/phone_option.h"
#include "mien/core/excerpt.h"
#include "mien/core/time.h"
#include "mien/study/phone_truth.h"
#include "mien/study/solve.h"

namespace mien::app {

void TruthOption::add_to(const Command& command) {
  const Option truth = command.add_option(
      "--truth", by_,
      "Measure against what a phone told: \"phone\" (the one that was recorded in the take), or a Live Link "
      "Face CSV that it recorded meanwhile; its time is found as mien align finds it (default: the take's "
      "own "
      "truth track)");
  command
      .add_flag("--raw", raw_,
                "Read the phone's file as named, even where a calibrated NAME_cal.csv lies beside it")
      .needs(truth);
  add_film_options(command, film_);
  (void)command.option("--film").needs(truth);
}

Result<void> TruthOption::check(std::size_t takes) const {
  if (by_.empty() || by_ == kOwnPhone || takes == 1) return {};
  return fail(ErrorCode::bad_usage, "a phone's file belongs to one take", "--truth " + by_,
              "evaluate the takes apart");
}

Result<TruthOption::Truth> TruthOption::read(const take::Take& take) const {
  if (by_.empty()) {
    MIEN_TRY_ASSIGN(std::vector<take::TruthFrame> own, study::own_truth(take));
    return Truth{.frames = std::move(own), .told = {}};
  }
  MIEN_TRY(check_aligns(take));
  MIEN_TRY_ASSIGN(const std::vector<model::FeatureFrame> features, study::take_features(take));
  const std::string csv = by_ == kOwnPhone ? "" : by_;
  MIEN_TRY_ASSIGN(study::PhoneTrack track, open_phone_track(take, features, csv, raw_));
  MIEN_TRY(add_sound_guess(take, features, csv, film_, track));
  MIEN_TRY_ASSIGN(const std::vector<take::Event> events, take.events());
  auto truth = study::phone_truth(events, features, track);
  if (!truth) {
    truth.error().where = take.path().string();
    return std::unexpected(std::move(truth).error());
  }
  const auto known = std::ranges::count_if(
      truth->frames, [](const take::TruthFrame& frame) { return frame.has_face && frame.evaluated; });
  const phone::TimeAlignment& at = truth->alignment;
  return Truth{.frames = std::move(truth->frames),
               .told = measure::ToldTruth{
                   .take = take.path().string(),
                   .by = csv.empty() ? track.motion.name : std::filesystem::path(csv).filename().string(),
                   .agreement = at.agreement,
                   .offset_ms = 1e3 * at.offset_s,
                   .offset_sigma_ms = 1e3 * at.offset_sigma_s,
                   .known_s = static_cast<double>(known) / kFrameRateHz}};
}

}  // namespace mien::app
