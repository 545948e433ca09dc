#include "mien/study/speech/lag_study.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mien/measure/metrics.h"
#include "mien/study/performance.h"
#include "mien/study/performers.h"
#include "mien/study/speech/speech_dataset.h"

namespace mien::study {
namespace {

/// Retiming moves by 5 ms a second: by then 120 ms are compensated of a lag that was believed in after half a
/// minute.
constexpr double kLosses_s = 60;
constexpr double kPeriod_s = 8, kLoss_s = 2;
/// From a loss until mouth and jaw are heard without what was shown before.
constexpr double kChange_s = 0.3;

/// Since a loss last began, s; of times from the first one on.
double since_loss_s(double reading_s) {
  return std::fmod(reading_s - kLosses_s, kPeriod_s);
}

/// Weights in the frames in which sensors are lost, loss by loss.
struct Losses {
  std::vector<std::vector<face::BlendshapeWeights>> truth, shown;
};

double reading_s(const SpokenSession& session, DeviceTime time) {
  return to_seconds(time - session.felt.motion_start);
}

MouthScore score(const SpokenSession& session, const ShownSession& shown, const measure::Meter& meter) {
  Losses losses;
  bool within = false;
  for (std::size_t f = 0; f < std::min(shown.frames.size(), session.felt.truth.size()); ++f) {
    const double at_s = reading_s(session, shown.frames[f].time);
    const bool counts = is_lost_in_reading(at_s) && since_loss_s(at_s) >= kChange_s;
    if (counts && !within) {
      losses.truth.emplace_back();
      losses.shown.emplace_back();
    }
    within = counts;
    if (!counts) continue;
    losses.truth.back().push_back(session.felt.truth[f].weights);
    losses.shown.back().push_back(shown.frames[f].weights);
  }
  std::vector<measure::Stretch> stretches;
  for (std::size_t l = 0; l < losses.truth.size(); ++l)
    stretches.push_back({losses.truth[l], losses.shown[l]});
  return score_mouth(meter, stretches);
}

LagFollowed follow_lag(const SpokenSession& session, const ShownSession& shown) {
  const auto begin = static_cast<std::size_t>(
      std::ranges::lower_bound(shown.frames, session.felt.motion_start, {}, &face::OutputFrame::time) -
      shown.frames.begin());
  return study::follow_lag(
      {shown.believed.begin() + static_cast<std::ptrdiff_t>(begin), shown.believed.end()},
      std::span(shown.offset).subspan(begin));
}

}  // namespace

bool is_lost_in_reading(double reading_s) {
  return reading_s >= kLosses_s && reading_s < kLagReading_s && since_loss_s(reading_s) < kLoss_s;
}

LagFollowed follow_lag(const std::vector<bool>& believed, std::span<const Duration> offset) {
  LagFollowed followed;
  if (believed.empty()) return followed;
  const auto first = std::ranges::find(believed, true);
  if (first != believed.end())
    followed.believed_s = static_cast<double>(first - believed.begin()) / kFrameRateHz;
  followed.believed_share =
      static_cast<double>(std::ranges::count(believed, true)) / static_cast<double>(believed.size());
  followed.offset_s = to_seconds(offset.back());
  return followed;
}

Result<std::vector<LagPerson>> study_lag(const LagRequest& request, const SpokenScene& scene,
                                         const Speaker& speaker, const Progress& progress) {
  MIEN_TRY(check_scene(scene));
  const std::vector<Voice> voices = voices_for(VoiceUse::test);
  std::vector<LagPerson> people(static_cast<std::size_t>(request.people));
  MIEN_TRY(for_each_performer(people.size(), request.threads, progress, [&](std::size_t p) -> Result<void> {
    LagPerson& out = people[p];
    out.seed = request.seed + p;
    const Random root = Random(out.seed).fork("lag");
    const Voice& voice = voices[p % voices.size()];
    out.voice = voice.name;
    const VirtualPerson person = draw_person(root);
    MIEN_TRY_ASSIGN(const SpokenPassage reading,
                    speak_passage(speaker, voice.name, voice.language, root, kLagReading_s));
    MIEN_TRY_ASSIGN(const virt::VirtualSession felt, feel(scene.rig, person.face, reading.face, root));
    const measure::Meter meter(person.face);
    SpokenSession session{.scene = scene, .passage = reading, .felt = felt};
    session.is_lost = [&](DeviceTime time) { return is_lost_in_reading(reading_s(session, time)); };
    MIEN_TRY_ASSIGN(const ShownSession held, show(session, Hearing::off));
    const MouthScore held_score = score(session, held, meter);
    for (const double lag_s : {-request.by_s, 0.0, request.by_s}) {
      session.lag = from_seconds(lag_s);
      MIEN_TRY_ASSIGN(const ShownSession heard, show(session, Hearing::as_it_comes));
      MIEN_TRY_ASSIGN(const ShownSession retimed, show(session, Hearing::retimed));
      out.rows.push_back({.lag_s = lag_s,
                          .followed = follow_lag(session, retimed),
                          .held = held_score,
                          .heard = score(session, heard, meter),
                          .retimed = score(session, retimed, meter)});
    }
    return {};
  }));
  return people;
}

}  // namespace mien::study
