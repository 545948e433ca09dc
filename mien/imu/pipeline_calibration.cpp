#include <algorithm>
#include <optional>

#include "mien/imu/pipeline_state.h"

namespace mien::imu {
namespace {

using tracker::Step;

}  // namespace

void Pipeline::State::put_in_force(const Calibration& made) {
  calibration = made;
  change.emplace();
  changed_by_marks = true;
  watched = false;
  rest.reset();
  drift.start();
  for (std::size_t i = 0; i < face.size(); ++i)
    move_heading(i, made.sensors[i].heading_rad, made.sensors[i].heading_sigma_rad);
  std::ranges::fill(tilt_rad2, 0.0);
  std::ranges::fill(implausible_s, 0.0);
  for (Channel& channel : channels) {
    channel.integration.fusion.set_on_skin(true);
    channel.restarted = false;
    channel.take_gaps();
  }
}

void Pipeline::State::judge(const Calibration& made) {
  calibration.scores = made.scores;
  if (!change) change.emplace().kind = tracker::CalibrationEvent::Kind::judged;
  changed_by_marks = true;
}

void Pipeline::State::fill_prologue_frame(DeviceTime frame, const FusedSample& ear, bool only_fresh) {
  prologue_frame.time = frame;
  prologue_frame.ear_fresh = fresh(*head, frame);
  prologue_frame.q_world_ear = ear.orientation;
  prologue_frame.ear_rate_rad_s = ear.rate_rad_s;
  prologue_frame.ear_force_world_m_s2 = ear.force_world_m_s2;
  for (std::size_t i = 0; i < face.size(); ++i) {
    const auto sensor = pose(face[i], frame);
    prologue_frame.face[i].fresh = sensor.has_value() && fresh(face[i], frame);
    prologue_frame.face[i].present = sensor.has_value() && (!only_fresh || prologue_frame.face[i].fresh);
    if (!prologue_frame.face[i].present) continue;
    prologue_frame.face[i].q_world_face = sensor->orientation;
    prologue_frame.face[i].force_world_m_s2 = sensor->force_world_m_s2;
    prologue_frame.face[i].rate_rad_s = sensor->rate_rad_s;
  }
}

void Pipeline::State::watch_for_calibration(DeviceTime frame, const std::optional<FusedSample>& ear) {
  if (ear && fresh(*head, frame)) {
    fill_prologue_frame(frame, *ear, true);
    switch (watch.add(frame, prologue_frame)) {
      case SelfCalibration::Outcome::nothing:
        break;
      case SelfCalibration::Outcome::calibrated:
        put_in_force(watch.solution());
        watched = true;
        change->found.assign(watch.steps().begin(), watch.steps().begin() + 2);
        break;
      case SelfCalibration::Outcome::judged:
        judge(watch.solution());
        change->found.push_back(watch.steps().back());
        break;
    }
  }
  for (Channel& channel : channels) channel.integration.fusion.expect_rest(watch.expects_rest());
}

void Pipeline::State::run_prologue(DeviceTime frame, const std::optional<FusedSample>& ear) {
  bool resting = false;
  for (StepWindow& window : windows) {
    if (frame < window.begin) continue;
    if (frame >= window.end) {
      if (!window.begun) continue;
      // A shake only adds its score: the tracked headings stay.
      const Calibration made = prologue.solve();
      if (window.step == Step::shake && calibration.complete) {
        judge(made);
      } else if (window.step == Step::nod || !calibration.complete) {
        put_in_force(made);
      }
      continue;
    }
    if (!window.begun) {
      window.begun = true;
      if (window.step == Step::neutral) prologue.begin_neutral();
      if (window.step == Step::nod) prologue.begin_nod();
      if (window.step == Step::shake) prologue.begin_shake();
    }
    resting = resting || window.step == Step::neutral;
    if (!ear) continue;
    // In the first half of the hold the gyroscopes' biases are still being estimated.
    if (window.step == Step::neutral && frame < window.begin + (window.end - window.begin) / 2) continue;
    fill_prologue_frame(frame, *ear, false);
    if (window.step == Step::neutral) prologue.add_neutral(prologue_frame);
    if (window.step == Step::nod) prologue.add_nod(prologue_frame);
    if (window.step == Step::shake) prologue.add_shake(prologue_frame);
  }
  std::erase_if(windows, [frame](const StepWindow& window) { return frame >= window.end; });
  for (Channel& channel : channels) channel.integration.fusion.expect_rest(resting);
}

void Pipeline::mark(Step step, DeviceTime begin, DeviceTime end) {
  State& s = *state_;
  if (end <= begin || step == Step::none) return;
  if (s.windows.empty()) {
    s.before_marks = calibration_now();
    s.changed_by_marks = false;
  }
  s.windows.push_back({step, begin, end});
}

void Pipeline::cancel_marks() {
  State& s = *state_;
  s.windows.clear();
  if (s.changed_by_marks) s.put_in_force(s.before_marks);
  s.changed_by_marks = false;
  for (Channel& channel : s.channels) channel.integration.fusion.expect_rest(false);
}

Step Pipeline::step() const {
  const State& s = *state_;
  for (const StepWindow& window : s.windows)
    if (window.begun) return window.step;
  return s.self_calibrating() ? s.watch.step() : Step::none;
}

std::string_view Pipeline::hint() const {
  return state_->self_calibrating() ? state_->watch.hint() : std::string_view();
}

Result<void> Pipeline::restore(const Calibration& calibration) {
  if (calibration.sensors.size() != state_->face.size())
    return fail(ErrorCode::mismatch, "the calibration is of another number of sensors");
  state_->put_in_force(calibration);
  return {};
}

}  // namespace mien::imu
