#include <algorithm>
#include <array>

#include "mien/session/session.h"

namespace mien::session {

void Session::report_prompts(Report::Prompts& out) const {
  static constexpr std::array<std::string_view, 6> kStates = {"none",   "ready", "running",
                                                              "paused", "over",  "block"};
  static const Prompt kNone{};
  const Prompter::Place place = prompter_.place(newest_frame_);
  out.state = kStates.at(static_cast<std::size_t>(place.state));
  out.prompt = place.prompt != nullptr ? *place.prompt : kNone;
  out.next = place.next != nullptr ? *place.next : kNone;
  out.poor = poor_;
  out.again = place.again;
  out.number = place.number;
  out.of = place.of;
  out.progress = place.progress;
  out.remaining_s = to_seconds(place.remaining);
  out.left_s = to_seconds(place.left);
}

void Session::report_certainty(Report::Calibration& out) const {
  out.age_s.reset();
  out.recentred_s.reset();
  // A re-centring is of the calibration before it.
  for (auto id = static_cast<std::size_t>(in_force_); id > 0; --id) {
    const CalibrationVersion& version = versions_[id - 1];
    const double age_s = to_seconds(newest_frame_ - version.made);
    if (version.origin != "recentre") {
      out.age_s = age_s;
      break;
    }
    if (!out.recentred_s) out.recentred_s = age_s;
  }
  out.sigma_rad = drift_watch_.sigma_rad();
  out.advises_recentring = drift_watch_.advises();
  out.faults = faults_;
}

void Session::report(HostTime now, Report& out) const {
  out.time = newest_frame_;
  out.frames = frames_;
  receiver_->report(now, out);
  for (std::uint16_t i = 0; i < out.links.size(); ++i) {
    out.links[i].heading_sigma_rad = trackers_.heading_sigma_rad(i);
    out.links[i].certainty = certainties_[i];
  }
  out.shaping = shaping::write_settings(shaper_.settings());
  out.hearing.reset();
  if (has_microphone_)
    out.hearing = Report::Hearing{.on = shaper_.settings().merge.audio,
                                  .speaks = hearing_.speaks,
                                  .share = static_cast<double>(audio_frames_) /
                                           static_cast<double>(std::max<std::uint64_t>(1, frames_)),
                                  .later = hearing_.later};
  out.resting = shaping::write_resting_face(shaper_.resting().present());

  report_prompts(out.prompts);
  Report::Calibration& calibration = out.calibration;
  const tracker::CalibrationState state = trackers_.calibration_state();
  calibration.in_force = in_force_;
  report_certainty(calibration);
  calibration.target.reset();
  calibration.look_rad.reset();
  calibration.progress = calibration.remaining_s = 0;
  calibration.step_number = calibration.steps = 0;
  if (guide_.running()) {
    calibration.state = "running";
    const Guide::Place place = guide_.place(newest_frame_);
    calibration.step_number = place.number;
    calibration.steps = guide_.parts().size();
    calibration.progress = place.progress;
    calibration.remaining_s = to_seconds(place.remaining);
    calibration.step = place.part == nullptr           ? ""
                       : place.part->target != nullptr ? "anchor"
                       : place.part->look != nullptr   ? "gaze"
                                                       : place.part->name;
    calibration.prompt = place.part == nullptr ? std::string_view() : place.part->prompt;
    if (place.part != nullptr && place.part->target != nullptr) calibration.target = *place.part->target;
    if (place.part != nullptr && place.part->look != nullptr)
      calibration.look_rad = place.part->look->direction_rad;
  } else if (!failure_.empty()) {
    calibration.state = "failed";
    calibration.step.clear();
    calibration.prompt = failure_;
  } else if (state.phase == tracker::CalibrationState::Phase::watching) {
    calibration.state = "watching";
    calibration.step = step_name(state.step);
    calibration.prompt = !state.hint.empty() ? state.hint
                         : state.step == tracker::Step::neutral
                             ? "Look ahead, relax your face and hold still"
                             : "Keep your face still and nod twice, down first";
  } else {
    calibration.state = "done";
    calibration.step.clear();
    calibration.prompt.clear();
  }
  calibration.versions.resize(versions_.size());
  for (std::size_t i = 0; i < versions_.size(); ++i) {
    CalibrationVersion& version = calibration.versions[i];
    version.id = versions_[i].id;
    version.made = versions_[i].made;
    version.origin = versions_[i].origin;
    version.scores = versions_[i].scores;
  }
}

}  // namespace mien::session
