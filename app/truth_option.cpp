#include "app/truth_option.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "mien/core/time.h"
#include "mien/sensor/rig_part.h"
#include "mien/solve/phone_truth.h"
#include "mien/solve/solve.h"
#include "mien/solve/trace_features.h"

namespace mien::app {
namespace {

Result<std::vector<take::TruthFrame>> own_truth(const take::Take& take) {
  auto own = solve::own_truth(take);
  // What a phone told can be asked for where its time can be found.
  if (!own && own.error().code == ErrorCode::not_found && check_aligns(take))
    own.error().fix += sensor::truths_of(take.rig()).empty()
                           ? ", or name what a phone recorded meanwhile (--truth FILE.csv)"
                           : ", or measure against the phone that looked on (--truth phone)";
  return own;
}

}  // namespace

void TruthOption::add_to(const Command& command) {
  phone_.add_to(command, "Measure against what a phone told and not the take's own truth track");
}

Result<void> TruthOption::check(std::size_t takes) const {
  if (phone_.file().empty() || takes == 1) return {};
  return fail(ErrorCode::bad_usage, "a phone's file belongs to one take", "--truth " + phone_.truth(),
              "evaluate the takes apart");
}

Result<TruthOption::Truth> TruthOption::read(const take::Take& take) const {
  if (!phone_.given()) {
    MIEN_TRY_ASSIGN(std::vector<take::TruthFrame> own, own_truth(take));
    return Truth{.frames = std::move(own), .told = {}};
  }
  MIEN_TRY(check_aligns(take));
  MIEN_TRY_ASSIGN(const std::vector<model::FeatureFrame> features, solve::take_features(take));
  MIEN_TRY_ASSIGN(const solve::PhoneTrack track, phone_.open(take, features));
  MIEN_TRY_ASSIGN(const std::vector<take::Event> events, take.events());
  auto truth = solve::phone_truth(events, features, track);
  if (!truth) {
    truth.error().where = take.path().string();
    return std::unexpected(std::move(truth).error());
  }
  const auto known = std::ranges::count_if(truth->frames, &take::TruthFrame::evaluated);
  const phone::TimeAlignment& at = truth->alignment;
  const std::string file = std::filesystem::path(phone_.file()).filename().string();
  return Truth{.frames = std::move(truth->frames),
               .told = measure::ToldTruth{.take = take.path().string(),
                                          .by = file.empty() ? track.motion.name : file,
                                          .agreement = at.agreement,
                                          .offset_ms = 1e3 * at.offset_s,
                                          .offset_sigma_ms = 1e3 * at.offset_sigma_s,
                                          .known_s = static_cast<double>(known) / kFrameRateHz,
                                          .rest_known = truth->rest.has_value()}};
}

}  // namespace mien::app
