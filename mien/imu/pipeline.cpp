#include "mien/imu/pipeline.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mien/imu/pipeline_state.h"

namespace mien::imu {
namespace {

/// Variance of a tilt whose inclination was begun anew after a long gap, rad^2 (5 deg).
constexpr double kNewTilt_rad2 = 0.0076;

void put_rotation(const Quat& q, model::SensorFeature& feature) {
  feature.rotation = wxyz_of(canonical(q));
  feature.has_rotation = true;
}

}  // namespace

Pipeline::Pipeline(const sensor::Rig& rig, const PipelineSettings& settings)
    : state_(std::make_unique<State>(rig, settings)) {}
Pipeline::Pipeline(Pipeline&&) noexcept = default;
Pipeline& Pipeline::operator=(Pipeline&&) noexcept = default;
Pipeline::~Pipeline() = default;

void Pipeline::forget(std::uint16_t sensor) {
  State& s = *state_;
  if (sensor >= s.channels.size()) return;
  s.channels[sensor] = Channel(s.settings.fusion);
  if (sensor == s.head) {
    s.calibration.complete = s.before_marks.complete = false;
    s.watched = false;
  }
  for (std::size_t i = 0; i < s.face.size(); ++i) {
    if (s.face[i] != sensor) continue;
    s.calibration.sensors[i].valid = false;
    s.tilt_rad2[i] = 0;
    s.implausible_s[i] = 0;
    s.rest_measurement.forget(i);
    if (i < s.before_marks.sensors.size()) s.before_marks.sensors[i].valid = false;
  }
  if (!s.calibration.complete) s.watch.forget();  // A hold across the exchange is invalid.
}

std::optional<tracker::CalibrationEvent> Pipeline::tick(DeviceTime frame, const sensor::TimeLines& lines,
                                                        model::FeatureFrame& out) {
  State& s = *state_;
  s.lines = &lines;
  s.change.reset();
  for (Channel& channel : s.channels) s.catch_up(channel);
  out.time = frame;
  out.head = Quat::Identity();
  out.has_head = false;
  out.sensors.assign(s.face.size(), model::SensorFeature{});
  const double dt_s = s.last_frame ? std::clamp(to_seconds(frame - *s.last_frame), 0.0, 1.0) : 0.0;
  s.last_frame = frame;

  std::optional<FusedSample> ear;
  if (s.head) ear = s.pose(*s.head, frame);
  const bool resting = s.follow_rest(frame);
  if (!s.windows.empty()) s.run_prologue(frame, ear);
  if (s.self_calibrating()) s.watch_for_calibration(frame, ear);
  const bool bridged = s.head && !ear;
  if (bridged) ear = s.bridged_ear(frame);

  const Calibration& calibration = s.calibration;
  if (ear && calibration.complete && s.channels[*s.head].restarted) s.realign_head(frame, *ear);
  const bool head_known = ear && calibration.complete && !s.channels[*s.head].restarted;
  const Quat c = s.q_head_ear();
  Vec3 head_rate = Vec3::Zero();
  std::optional<Vec3> head_turn;  // Angular acceleration, frame H; from the second frame on.
  if (head_known) {
    out.head = canonical(heading_turn(-calibration.neutral_heading_rad) * ear->orientation * c.conjugate());
    out.has_head = true;
    s.last_head = out.head;
    head_rate = c * ear->rate_rad_s;
    if (s.last_head_rate && dt_s > 0 && !bridged) head_turn = (head_rate - *s.last_head_rate) / dt_s;
  }
  s.last_head_rate = head_known && !bridged ? std::optional<Vec3>(head_rate) : std::nullopt;

  const Gaps ear_gaps = s.head ? s.take_gaps(*s.head, frame) : Gaps();
  const bool followed = s.settings.track_heading && !s.settings.magnetometer;
  if (ear_gaps.sigma_rad > 0) s.drift.turn_all(0, ear_gaps.sigma_rad);
  s.poses.assign(s.face.size(), std::nullopt);
  if (followed && calibration.complete) s.drift.predict(dt_s);
  for (std::size_t i = 0; i < s.face.size(); ++i) {
    Channel& channel = s.channels[s.face[i]];
    if (!calibration.complete || !calibration.sensors[i].valid) continue;
    const Gaps gaps = s.take_gaps(s.face[i], frame);
    if (gaps.sigma_rad > 0) s.drift.inflate(i, gaps.sigma_rad);
    double& tilt_rad2 = s.tilt_rad2[i];
    tilt_rad2 *= std::exp(-2 * dt_s / s.settings.fusion.tau_accel_s);
    if (gaps.tilt_restarted)
      tilt_rad2 = kNewTilt_rad2;
    else
      tilt_rad2 += gaps.sigma_rad * gaps.sigma_rad;
    tilt_rad2 += ear_gaps.tilt_restarted ? kNewTilt_rad2 : ear_gaps.sigma_rad * ear_gaps.sigma_rad;

    if (head_known && channel.settled()) s.poses[i] = s.pose(s.face[i], frame);
    const std::optional<FusedSample>& pose = s.poses[i];
    if (!pose) {
      s.nods[i].interrupt();
      s.implausible_s[i] = 0;
      continue;
    }
    if (channel.restarted) s.realign_face(i, *ear, *pose);
    if (!followed) continue;
    if (bridged) {
      // Where the head is was told by the skin: nothing is learnt from where skin is to it.
      s.nods[i].interrupt();
      continue;
    }
    if (s.implausible(i, dt_s, *ear, *pose)) {
      s.nods[i].interrupt();
      s.poses[i].reset();
      continue;
    }
    const Quat relative = s.relative(i, ear->orientation);
    if (const auto nod = s.nods[i].add(dt_s, relative, ear->orientation,
                                       relative * pose->rate_rad_s - ear->rate_rad_s, ear->rate_rad_s))
      if (!resting) s.drift.add_nod(i, *nod);
  }
  if (head_known && followed && !bridged) s.measure_turns(ear->orientation);
  if (resting && head_known && !bridged)
    s.rest_measurement.add(s.turns_rad, s.last_up);
  else if (resting)
    s.rest_measurement.pass();
  else if (head_known && followed && !bridged)
    s.drift.add_skin(dt_s, s.turns_rad, s.tilt_rad2, s.last_up);

  for (std::size_t i = 0; i < s.face.size(); ++i) {
    const std::optional<FusedSample>& pose = s.poses[i];
    if (!pose || s.is_unsure(i)) continue;
    model::SensorFeature& feature = out.sensors[i];
    const Quat relative = s.relative(i, ear->orientation);
    put_rotation(c * relative * s.neutral(i).conjugate() * c.conjugate(), feature);

    // Without the lever arm the head's own acceleration would remain in it.
    if (!s.lever_m[i] || !head_turn) continue;
    Vec3 accel =
        c * (ear->orientation.conjugate() * (s.turn_of(i) * pose->force_world_m_s2 - ear->force_world_m_s2));
    accel -= head_turn->cross(*s.lever_m[i]) + head_rate.cross(head_rate.cross(*s.lever_m[i]));
    feature.accel_m_s2 = (accel - calibration.sensors[i].neutral_accel_m_s2).cast<float>();
    feature.has_accel = true;
  }
  s.lines = nullptr;
  return std::exchange(s.change, std::nullopt);
}

void Pipeline::rest(DeviceTime begin, DeviceTime end) {
  state_->rest.reset();
  if (end > begin && state_->follows_drift()) state_->rest = RestWindow{begin, end};
}

bool Pipeline::follows_drift() const {
  return state_->follows_drift();
}

const std::optional<tracker::RestOutcome>& Pipeline::rested() const {
  return state_->rested;
}

const Calibration& Pipeline::calibration() const {
  return state_->calibration;
}

Calibration Pipeline::calibration_now() const {
  Calibration now = state_->calibration;
  now.q_head_ear = state_->q_head_ear();
  for (std::size_t i = 0; i < now.sensors.size(); ++i) {
    if (!now.sensors[i].valid) continue;
    now.sensors[i].heading_rad = state_->drift.heading_rad(i);
    now.sensors[i].heading_sigma_rad = state_->drift.heading_sigma_rad(i);
    now.sensors[i].neutral = state_->neutral(i);
  }
  return now;
}

SensorStatus Pipeline::status(std::uint16_t sensor) const {
  const State& s = *state_;
  SensorStatus status;
  if (sensor >= s.channels.size()) return status;
  status.dropped = s.channels[sensor].dropped;
  status.lost = s.channels[sensor].integration.lost;
  for (std::size_t i = 0; i < s.face.size(); ++i) {
    if (s.face[i] != sensor || s.settings.magnetometer) continue;
    status.heading_rad = s.drift.heading_rad(i);
    status.heading_sigma_rad = s.drift.heading_sigma_rad(i);
    status.tilt_sigma_rad = std::sqrt(s.tilt_rad2[i]);
    status.drift_rad2 = s.drift.rotation_covariance(i, s.last_up);
    status.present = i < s.poses.size() && s.poses[i].has_value();
    status.left_out = status.present && s.is_unsure(i);
    status.faults = s.drift.faults();
  }
  return status;
}

}  // namespace mien::imu
