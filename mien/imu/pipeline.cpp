#include "mien/imu/pipeline.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "mien/imu/heading.h"
#include "mien/imu/orientation_track.h"
#include "mien/imu/prologue.h"
#include "mien/imu/skin_turns.h"
#include "mien/sensor/clock_model.h"

namespace mien::imu {
namespace {

using sensor::Sample;
using sensor::SampleKind;

/// A device time this far behind the newest is a board that began anew; less is a sample out of order.
constexpr Duration kRestart = std::chrono::seconds(1);

/// What is unsure of a tilt for which gravity was asked anew after a long gap, rad^2 (5 deg).
constexpr double kNewTilt_rad2 = 0.0076;
/// Skin is asked of headings this often, s (every third frame): from one frame to the next it says the same.
constexpr double kSkinEvery_s = 0.045;
/// What a board's heading may be off after it began anew with a face that is not at neutral, rad (10 deg).
constexpr double kRejoinedSigma = 0.17;
/// A board that began anew is believed when it has run for so long without another gap: two boards of one
/// number never do.
constexpr Duration kSettles = std::chrono::milliseconds(200);
/// No skin turns so far about the vertical, rad (120 deg): a heading that would have it so, for so long (s,
/// in which a tilt that a gap spoilt is mended), is lost.
constexpr double kNoSkinTurns_rad = 2.1;
constexpr double kAstrayFor_s = 0.25;

/// Newest rotations of one sensor of the lab profile; their times stand on the reference's line already.
class LabTrack {
 public:
  void add(DeviceTime time, const Vec3& rotation_vector) {
    entries_[next_ % kSize] = {time, rotation_vector};
    ++next_;
  }

  /// The rotation at the frame: the nearest sample, since a mean of two would halve the noise that the
  /// profile adds.
  [[nodiscard]] bool at(DeviceTime frame, Duration silence, Quat& out) const {
    const Entry* best = nullptr;
    Duration best_distance{};
    for (std::size_t i = 0; i < std::min(next_, kSize); ++i) {
      const Entry& entry = entries_[i];
      const Duration distance = entry.time > frame ? entry.time - frame : frame - entry.time;
      if (best == nullptr || distance < best_distance) {
        best = &entry;
        best_distance = distance;
      }
    }
    if (best == nullptr || best_distance > silence) return false;
    out = canonical(exp_rotation(best->rotation_vector));
    return true;
  }

 private:
  struct Entry {
    DeviceTime time;
    Vec3 rotation_vector = Vec3::Zero();
  };
  static constexpr std::size_t kSize = 16;
  std::array<Entry, kSize> entries_;
  std::size_t next_ = 0;
};

/// What gaps have done to an orientation since they were last passed on.
struct Gaps {
  double sigma_rad = 0;
  bool tilt_anew = false;  ///< One was so long that gravity was asked anew.
};

/// One sensor of the rig on its way from samples to orientations.
struct Channel {
  explicit Channel(const FusionSettings& settings) : fusion(settings) {}
  /// What was not taken yet.
  Gaps take_gaps() {
    const double sigma = fusion.gap_sigma_rad();
    const Gaps gaps{std::sqrt(std::max(0.0, sigma * sigma - gap_sigma * gap_sigma)),
                    fusion.restarts() != restarts};
    gap_sigma = sigma;
    restarts = fusion.restarts();
    return gaps;
  }
  [[nodiscard]] bool settled() const { return !began_anew || !newest || *newest - steady_since >= kSettles; }

  Fusion fusion;
  OrientationTrack track;
  LabTrack lab;
  std::optional<DeviceTime> newest;
  DeviceTime steady_since;        // It began anew, or its last long gap ended.
  Duration step{};                // Between the last two samples that followed each other.
  double gap_sigma = 0;           // As the fusion had it when its growth was last passed on, ...
  std::uint64_t restarts = 0;     // ... and how often it had begun its tilt anew.
  bool began_anew = false;        // Its heading has nothing to do with the calibrated one.
  bool may_be_unchanged = false;  // Sends nothing while nothing changes.
  std::uint64_t dropped = 0;
  std::uint64_t lost = 0;
};

struct PhaseWindow {
  Phase phase;
  DeviceTime begin;
  DeviceTime end;
  bool begun = false;
};

Vec3 vec3(const Sample& sample, std::size_t at) {
  return Vec3(sample.values[at], sample.values[at + 1], sample.values[at + 2]);
}

void put_rotation(const Quat& q, model::SensorFeature& feature) {
  const Quat unit = canonical(q);
  feature.rotation = {static_cast<float>(unit.w()), static_cast<float>(unit.x()),
                      static_cast<float>(unit.y()), static_cast<float>(unit.z())};
  feature.has_rotation = true;
}

}  // namespace

std::optional<Phase> phase_of(std::string_view event_kind) {
  if (event_kind == "neutral") return Phase::neutral;
  if (event_kind == "nod") return Phase::nod;
  if (event_kind == "shake") return Phase::shake;
  return std::nullopt;
}

struct Pipeline::State {
  State(const sensor::Rig& rig, const PipelineSettings& s)
      : settings(s),
        face(rig.face_sensors()),
        head(rig.head_sensor()),
        channels(rig.sensors.size(), Channel(s.fusion)),
        prologue(rig),
        watch(rig),
        trackers(face.size(), HeadingTracker(s.heading)),
        tilt_rad2(face.size()),
        astray_s(face.size()),
        lever_m(face.size()) {
    if (rig.skin) skin.emplace(*rig.skin, rig.face_sensor_names());
    calibration.sensors.resize(face.size());
    prologue_frame.face.resize(face.size());
    if (!head || !rig.sensors[*head].position_m) return;
    for (std::size_t i = 0; i < face.size(); ++i)
      if (rig.sensors[face[i]].position_m)
        lever_m[i] = *rig.sensors[face[i]].position_m - *rig.sensors[*head].position_m;
  }

  void add_raw(Channel& channel, const Sample& sample);
  void add_fused(Channel& channel, const Sample& sample);
  /// False when the sample is out of order. Sets the step, nothing when the board began anew.
  bool order(Channel& channel, const Sample& sample, double& dt_s);
  /// At the frame that runs; none where nothing was received lately.
  [[nodiscard]] std::optional<FusedSample> pose(std::uint16_t sensor, DeviceTime frame) const;
  void run_prologue(DeviceTime frame, const std::optional<FusedSample>& ear);
  void watch_for_calibration(DeviceTime frame, const std::optional<FusedSample>& ear);
  /// `only_fresh`: a rotation that is held over a gap counts as missing.
  void see_prologue_frame(DeviceTime frame, const FusedSample& ear, bool only_fresh);
  [[nodiscard]] bool fresh(std::uint16_t sensor, DeviceTime frame) const;
  void put_in_force(const Calibration& made);
  /// A shake scores the calibration in force, and changes nothing else.
  void judge(const Calibration& made);
  /// Tells of a phase that watching found.
  void add_found(Phase phase);
  /// What its skin says of every heading, now that all poses of the frame are known.
  void recentre(double dt_s, const Quat& q_world_ear);
  /// P_i of the frame, whose pose is there.
  [[nodiscard]] Quat relative(std::size_t i, const Quat& q_world_ear) const;
  /// N_i with what its sensor has crept since the calibration.
  [[nodiscard]] Quat neutral(std::size_t i) const {
    const Quat& c = calibration.q_head_ear;
    return c.conjugate() * exp_rotation(trackers[i].slip_rad()) * c * calibration.sensors[i].neutral;
  }
  [[nodiscard]] bool watches() const {
    return settings.calibrates_itself && windows.empty() &&
           (!calibration.complete || (watched && !watch.finished()));
  }
  void rejoin_head(DeviceTime frame, const FusedSample& ear);
  void rejoin_face(std::size_t i, const FusedSample& ear, const FusedSample& sensor);
  /// Whether a face sensor's heading is lost: no skin turns as it says. It rejoins when it has been for a
  /// while.
  bool astray(std::size_t i, double dt_s, const FusedSample& ear, const FusedSample& sensor);
  [[nodiscard]] double nearest_neutral(std::size_t i, const FusedSample& ear,
                                       const FusedSample& sensor) const;
  /// Of a sensor's rotation, by its heading and its tilt.
  [[nodiscard]] double unsure_rad(std::size_t i) const {
    return std::hypot(trackers[i].sigma_rad(), std::sqrt(tilt_rad2[i]));
  }
  [[nodiscard]] Quat turn_of(std::size_t i) const {
    return settings.magnetometer ? Quat::Identity() : heading_turn(trackers[i].heading_rad());
  }

  PipelineSettings settings;
  std::vector<std::uint16_t> face;  // Numbers in the rig.
  std::optional<std::uint16_t> head;
  const sensor::TimeLines* lines = nullptr;  // During a tick.
  std::vector<Channel> channels;             // One a sensor of the rig.
  Prologue prologue;
  Prologue::Frame prologue_frame;
  std::vector<PhaseWindow> windows;
  SelfCalibration watch;
  bool watched = false;  // The calibration in force was made by watching.
  Calibration calibration;
  CalibrationChange change;              // At the frame that runs.
  Calibration before_marks;              // In force when the first mark was given, ...
  bool changed_by_marks = false;         // ... and whether it is in force no more.
  Quat last_head = Quat::Identity();     // Of the last frame that had one.
  std::vector<HeadingTracker> trackers;  // One a face sensor.
  // By face sensor: what gaps left unsure of its tilt, and gravity has not mended.
  std::vector<double> tilt_rad2;
  std::vector<double> astray_s;                   // By face sensor: for how long no skin turns as it says.
  std::optional<SkinTurns> skin;                  // Where it is known how it turns.
  double skin_due_s = 0;                          // Since it was last asked.
  std::vector<std::optional<FusedSample>> poses;  // Of the frame, by face sensor.
  std::vector<std::optional<Vec3>> lever_m;       // From the ear sensor, frame H.
  std::optional<DeviceTime> last_frame;
  std::optional<Vec3> last_head_rate;  // Frame H, at last_frame.
};

bool Pipeline::State::order(Channel& channel, const Sample& sample, double& dt_s) {
  dt_s = 0;
  if (channel.newest) {
    const Duration since = sample.time - *channel.newest;
    if (since < -kRestart) {
      channel.fusion.restart();
      channel.track.clear();
      channel.began_anew = true;
      channel.steady_since = sample.time;
      channel.step = {};
    } else if (since <= Duration::zero()) {
      ++channel.dropped;
      return false;
    } else {
      dt_s = to_seconds(since);
      if (dt_s > settings.fusion.max_gap_s) channel.steady_since = sample.time;
      if (channel.step > Duration::zero() && since > channel.step * 3 / 2)
        channel.lost += static_cast<std::uint64_t>((since + channel.step / 2) / channel.step - 1);
      else
        channel.step = since;
    }
  }
  channel.newest = sample.time;
  return true;
}

void Pipeline::State::add_raw(Channel& channel, const Sample& sample) {
  double dt_s = 0;
  if (!order(channel, sample, dt_s)) return;
  const Vec3 accel = vec3(sample, 3);
  channel.fusion.add(dt_s, vec3(sample, 0), accel);
  if (settings.magnetometer && sample.count >= 9) channel.fusion.fuse_mag(vec3(sample, 6));
  const Quat q = channel.fusion.orientation();
  channel.track.add({sample.time, q, q * accel, channel.fusion.rate_rad_s()});
}

void Pipeline::State::add_fused(Channel& channel, const Sample& sample) {
  double dt_s = 0;
  if (!order(channel, sample, dt_s)) return;
  Quat q(sample.values[0], sample.values[1], sample.values[2], sample.values[3]);
  if (q.norm() < 0.5) return;
  q.normalize();
  Vec3 rate = Vec3::Zero();
  if (dt_s > 0 && !channel.track.empty())
    rate = log_rotation(channel.track.newest().orientation.conjugate() * q) / dt_s;
  channel.track.add({sample.time, q, q * vec3(sample, 4), rate});
  channel.may_be_unchanged = sample.time_estimated;
}

std::optional<FusedSample> Pipeline::State::pose(std::uint16_t sensor, DeviceTime frame) const {
  const Channel& channel = channels[sensor];
  if (channel.track.empty() || !lines->ready() || !lines->has_samples(sensor)) return std::nullopt;
  return channel.track.at(lines->from_line(sensor, frame),
                          channel.may_be_unchanged ? settings.unchanged : settings.silence,
                          settings.prediction);
}

void Pipeline::State::put_in_force(const Calibration& made) {
  calibration = made;
  change.kind = CalibrationChange::Kind::calibrated;
  changed_by_marks = true;
  watched = false;
  for (std::size_t i = 0; i < face.size(); ++i)
    trackers[i].start(made.sensors[i].heading_rad, made.sensors[i].heading_sigma_rad,
                      skin ? std::optional(skin->usual_strays_rad2(i)) : std::nullopt);
  std::ranges::fill(tilt_rad2, 0.0);
  std::ranges::fill(astray_s, 0.0);
  for (Channel& channel : channels) {
    channel.began_anew = false;
    channel.take_gaps();
  }
}

void Pipeline::State::judge(const Calibration& made) {
  calibration.scores = made.scores;
  if (change.kind == CalibrationChange::Kind::none) change.kind = CalibrationChange::Kind::judged;
  changed_by_marks = true;
}

void Pipeline::State::add_found(Phase phase) {
  const SelfCalibration::Span& span = watch.spans()[static_cast<std::size_t>(phase)];
  if (span.end > span.begin) change.found.push_back({phase, span.begin, span.end});
}

Quat Pipeline::State::relative(std::size_t i, const Quat& q_world_ear) const {
  return q_world_ear.conjugate() * turn_of(i) * poses[i]->orientation;
}

void Pipeline::State::recentre(double dt_s, const Quat& q_world_ear) {
  const Vec3 up = q_world_ear.conjugate() * Vec3::UnitY();
  const auto turn = [&](std::size_t i) {
    return log_rotation(relative(i, q_world_ear) * neutral(i).conjugate());
  };
  if (!skin) {
    for (std::size_t i = 0; i < face.size(); ++i) {
      if (!poses[i]) continue;
      const Vec3 turned = turn(i);
      trackers[i].add_turn_from_neutral(dt_s, turned.dot(up), turned.cross(up).norm());
    }
    return;
  }
  skin_due_s += dt_s;
  if (skin_due_s < kSkinEvery_s) return;
  skin->clear();
  for (std::size_t i = 0; i < face.size(); ++i)
    if (poses[i]) skin->see(i, calibration.q_head_ear * turn(i), std::sqrt(tilt_rad2[i]));
  skin->solve(calibration.q_head_ear * up);
  for (std::size_t i = 0; i < face.size(); ++i)
    if (poses[i]) trackers[i].add_skin(skin_due_s, (*skin)[i]);
  skin_due_s = 0;
}

bool Pipeline::State::fresh(std::uint16_t sensor, DeviceTime frame) const {
  const Channel& channel = channels[sensor];
  return channel.may_be_unchanged ||
         lines->from_line(sensor, frame) - channel.track.newest().time <= settings.prediction;
}

void Pipeline::State::see_prologue_frame(DeviceTime frame, const FusedSample& ear, bool only_fresh) {
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
    see_prologue_frame(frame, *ear, true);
    switch (watch.add(frame, prologue_frame)) {
      case SelfCalibration::Outcome::nothing:
        break;
      case SelfCalibration::Outcome::calibrated:
        put_in_force(watch.solution());
        watched = true;
        add_found(Phase::neutral);
        add_found(Phase::nod);
        break;
      case SelfCalibration::Outcome::judged:
        judge(watch.solution());
        add_found(Phase::shake);
        break;
    }
  }
  for (Channel& channel : channels) channel.fusion.expect_rest(watch.expects_rest());
}

// A board that began anew has a heading of its own, but sits where it sat: of all headings the one that
// brings its skin nearest to neutral is within what faces do, and the trackers find the rest.
double Pipeline::State::nearest_neutral(std::size_t i, const FusedSample& ear,
                                        const FusedSample& sensor) const {
  // trace(N^T R_h^T Z R_i) = a + b cos + c sin.
  const Mat3 to = (ear.orientation * neutral(i)).toRotationMatrix();
  const Mat3 from = sensor.orientation.toRotationMatrix();
  const double cosine = to.row(0).dot(from.row(0)) + to.row(2).dot(from.row(2));
  const double sine = to.row(0).dot(from.row(2)) - to.row(2).dot(from.row(0));
  return std::atan2(sine, cosine);
}

void Pipeline::State::rejoin_face(std::size_t i, const FusedSample& ear, const FusedSample& sensor) {
  trackers[i].move_to(nearest_neutral(i, ear, sensor), kRejoinedSigma);
  channels[face[i]].began_anew = false;
}

bool Pipeline::State::astray(std::size_t i, double dt_s, const FusedSample& ear, const FusedSample& sensor) {
  const double off =
      std::remainder(nearest_neutral(i, ear, sensor) - trackers[i].heading_rad(), 2 * std::numbers::pi);
  astray_s[i] = std::abs(off) > kNoSkinTurns_rad ? astray_s[i] + dt_s : 0;
  if (astray_s[i] <= kAstrayFor_s) return astray_s[i] > 0;
  rejoin_face(i, ear, sensor);
  astray_s[i] = 0;
  return false;
}

void Pipeline::State::rejoin_head(DeviceTime frame, const FusedSample& ear) {
  // All the face's headings against the head have turned alike.
  double cosine = 0, sine = 0;
  bool anew = false;
  for (std::size_t i = 0; i < face.size(); ++i) {
    if (!calibration.sensors[i].valid) continue;
    const auto sensor = pose(face[i], frame);
    if (!sensor) continue;
    if (channels[face[i]].began_anew) {
      anew = true;
      continue;
    }
    const double turned = nearest_neutral(i, ear, *sensor) - trackers[i].heading_rad();
    cosine += std::cos(turned);
    sine += std::sin(turned);
  }
  if (cosine == 0 && sine == 0) {
    if (!anew) return;  // Nobody there to ask yet.
    // All that are there began anew with it, as a mask that was switched off: each is placed by its neutral.
    for (const std::uint16_t s : face) channels[s].began_anew = true;
  }
  const double turned = std::atan2(sine, cosine);
  for (std::size_t i = 0; i < face.size(); ++i)
    trackers[i].move_to(std::remainder(trackers[i].heading_rad() + turned, 2 * std::numbers::pi),
                        std::hypot(trackers[i].sigma_rad(), kRejoinedSigma));
  // The head faces where it last did.
  const Vec3 ahead = ear.orientation * (calibration.q_head_ear.conjugate() * Vec3::UnitZ());
  const Vec3 faced = last_head * Vec3::UnitZ();
  calibration.neutral_heading_rad = std::remainder(
      std::atan2(ahead.x(), ahead.z()) - std::atan2(faced.x(), faced.z()), 2 * std::numbers::pi);
  channels[*head].began_anew = false;
}

void Pipeline::State::run_prologue(DeviceTime frame, const std::optional<FusedSample>& ear) {
  bool resting = false;
  for (PhaseWindow& window : windows) {
    if (frame < window.begin) continue;
    if (frame >= window.end) {
      if (!window.begun) continue;
      // The headings that the trackers found since stay: a shake only adds its score.
      const Calibration made = prologue.solve();
      if (window.phase == Phase::shake && calibration.complete) {
        judge(made);
      } else if (window.phase == Phase::nod || !calibration.complete) {
        put_in_force(made);
      }
      continue;
    }
    if (!window.begun) {
      window.begun = true;
      if (window.phase == Phase::neutral) prologue.begin_neutral();
      if (window.phase == Phase::nod) prologue.begin_nod();
      if (window.phase == Phase::shake) prologue.begin_shake();
    }
    resting = resting || window.phase == Phase::neutral;
    if (!ear) continue;
    // In the first half of the hold the gyroscopes' biases are still being found.
    if (window.phase == Phase::neutral && frame < window.begin + (window.end - window.begin) / 2) continue;
    see_prologue_frame(frame, *ear, false);
    if (window.phase == Phase::neutral) prologue.add_neutral(prologue_frame);
    if (window.phase == Phase::nod) prologue.add_nod(prologue_frame);
    if (window.phase == Phase::shake) prologue.add_shake(prologue_frame);
  }
  std::erase_if(windows, [frame](const PhaseWindow& window) { return frame >= window.end; });
  for (Channel& channel : channels) channel.fusion.expect_rest(resting);
}

Pipeline::Pipeline(const sensor::Rig& rig, const PipelineSettings& settings)
    : state_(std::make_unique<State>(rig, settings)) {}
Pipeline::Pipeline(Pipeline&&) noexcept = default;
Pipeline& Pipeline::operator=(Pipeline&&) noexcept = default;
Pipeline::~Pipeline() = default;

void Pipeline::mark(Phase phase, DeviceTime begin, DeviceTime end) {
  State& s = *state_;
  if (end <= begin) return;
  if (s.windows.empty()) {
    s.before_marks = calibration_now();
    s.changed_by_marks = false;
  }
  s.windows.push_back({phase, begin, end, false});
}

void Pipeline::cancel_marks() {
  State& s = *state_;
  s.windows.clear();
  if (s.changed_by_marks) s.put_in_force(s.before_marks);
  s.changed_by_marks = false;
  for (Channel& channel : s.channels) channel.fusion.expect_rest(false);
}

void Pipeline::add(const Sample& sample) {
  State& s = *state_;
  if (sample.sensor >= s.channels.size()) return;
  for (const float value : sample.used())
    if (!std::isfinite(value)) return;
  Channel& channel = s.channels[sample.sensor];
  switch (sample.kind) {
    case SampleKind::imu_raw:
      if (sample.count < 6) return;
      s.add_raw(channel, sample);
      return;
    case SampleKind::imu_fused:
      if (sample.count < 7) return;
      s.add_fused(channel, sample);
      return;
    case SampleKind::imu_head_relative:
      if (sample.count < 3) return;
      channel.lab.add(sample.time, vec3(sample, 0));
      return;
    default:  // Another modality's.
      return;
  }
}

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
    s.astray_s[i] = 0;
    if (i < s.before_marks.sensors.size()) s.before_marks.sensors[i].valid = false;
  }
  if (!s.calibration.complete) s.watch.forget();  // A hold that it saw half of is none.
}

CalibrationChange Pipeline::tick(DeviceTime frame, const sensor::TimeLines& lines, model::FeatureFrame& out) {
  State& s = *state_;
  s.lines = &lines;
  s.change = {};
  out.time = frame;
  out.head = Quat::Identity();
  out.has_head = false;
  out.sensors.assign(s.face.size(), model::SensorFeature{});
  const double dt_s = s.last_frame ? std::clamp(to_seconds(frame - *s.last_frame), 0.0, 1.0) : 0.0;
  s.last_frame = frame;

  std::optional<FusedSample> ear;
  if (s.head) ear = s.pose(*s.head, frame);
  if (!s.windows.empty()) s.run_prologue(frame, ear);
  if (s.watches()) s.watch_for_calibration(frame, ear);

  const Calibration& calibration = s.calibration;
  if (ear && calibration.complete && s.channels[*s.head].began_anew) s.rejoin_head(frame, *ear);
  const bool head_known = ear && calibration.complete && !s.channels[*s.head].began_anew;
  const Quat& c = calibration.q_head_ear;
  Vec3 head_rate = Vec3::Zero();
  std::optional<Vec3> head_turn;  // Angular acceleration, frame H; known from the second frame on.
  if (head_known) {
    out.head = canonical(heading_turn(-calibration.neutral_heading_rad) * ear->orientation * c.conjugate());
    out.has_head = true;
    s.last_head = out.head;
    head_rate = c * ear->rate_rad_s;
    if (s.last_head_rate && dt_s > 0) head_turn = (head_rate - *s.last_head_rate) / dt_s;
  }
  s.last_head_rate = head_known ? std::optional<Vec3>(head_rate) : std::nullopt;

  const Gaps ear_gaps = s.head ? s.channels[*s.head].take_gaps() : Gaps();
  const bool followed = s.settings.track_heading && !s.settings.magnetometer;
  s.poses.assign(s.face.size(), std::nullopt);
  for (std::size_t i = 0; i < s.face.size(); ++i) {
    Channel& channel = s.channels[s.face[i]];
    Quat lab;
    if (channel.lab.at(frame, s.settings.silence, lab)) {
      put_rotation(lab, out.sensors[i]);
      continue;
    }
    if (!calibration.complete || !calibration.sensors[i].valid) continue;
    const Gaps gaps = channel.take_gaps();
    if (gaps.sigma_rad > 0 || ear_gaps.sigma_rad > 0)
      s.trackers[i].inflate(std::hypot(gaps.sigma_rad, ear_gaps.sigma_rad));
    double& tilt_rad2 = s.tilt_rad2[i];
    tilt_rad2 *= std::exp(-2 * dt_s / s.settings.fusion.tau_accel_s);
    if (gaps.tilt_anew)
      tilt_rad2 = kNewTilt_rad2;
    else
      tilt_rad2 += gaps.sigma_rad * gaps.sigma_rad;
    tilt_rad2 += ear_gaps.tilt_anew ? kNewTilt_rad2 : ear_gaps.sigma_rad * ear_gaps.sigma_rad;

    if (head_known && channel.settled()) s.poses[i] = s.pose(s.face[i], frame);
    const std::optional<FusedSample>& pose = s.poses[i];
    if (!pose) {
      s.trackers[i].skip(dt_s);
      s.astray_s[i] = 0;
      continue;
    }
    if (channel.began_anew) s.rejoin_face(i, *ear, *pose);
    if (!followed) continue;
    if (s.astray(i, dt_s, *ear, *pose)) {
      s.trackers[i].skip(dt_s);
      s.poses[i].reset();
      continue;
    }
    const Quat relative = s.relative(i, ear->orientation);
    s.trackers[i].add(dt_s, relative, ear->orientation, relative * pose->rate_rad_s - ear->rate_rad_s,
                      ear->rate_rad_s);
  }
  if (head_known && followed) s.recentre(dt_s, ear->orientation);

  for (std::size_t i = 0; i < s.face.size(); ++i) {
    const std::optional<FusedSample>& pose = s.poses[i];
    if (!pose || (followed && s.unsure_rad(i) > s.settings.unsure_rad)) continue;
    model::SensorFeature& feature = out.sensors[i];
    const Quat relative = s.relative(i, ear->orientation);
    put_rotation(c * relative * s.neutral(i).conjugate() * c.conjugate(), feature);

    // Without the arm, what is left of the head's own acceleration would be taken for the skin's.
    if (!s.lever_m[i] || !head_turn) continue;
    Vec3 accel =
        c * (ear->orientation.conjugate() * (s.turn_of(i) * pose->force_world_m_s2 - ear->force_world_m_s2));
    accel -= head_turn->cross(*s.lever_m[i]) + head_rate.cross(head_rate.cross(*s.lever_m[i]));
    feature.accel_m_s2 = (accel - calibration.sensors[i].neutral_accel_m_s2).cast<float>();
    feature.has_accel = true;
  }
  s.lines = nullptr;
  return std::exchange(s.change, {});
}

const Calibration& Pipeline::calibration() const {
  return state_->calibration;
}

Calibration Pipeline::calibration_now() const {
  Calibration now = state_->calibration;
  for (std::size_t i = 0; i < now.sensors.size(); ++i) {
    if (!now.sensors[i].valid) continue;
    now.sensors[i].heading_rad = state_->trackers[i].heading_rad();
    now.sensors[i].heading_sigma_rad = state_->trackers[i].sigma_rad();
    now.sensors[i].neutral = state_->neutral(i);
  }
  return now;
}

std::optional<Phase> Pipeline::phase() const {
  const State& s = *state_;
  for (const PhaseWindow& window : s.windows)
    if (window.begun) return window.phase;
  if (s.watches()) return phase_of(s.watch.step());
  return std::nullopt;
}

std::string_view Pipeline::hint() const {
  return state_->watches() ? state_->watch.hint() : std::string_view();
}

Result<void> Pipeline::restore(const Calibration& calibration) {
  if (calibration.sensors.size() != state_->face.size())
    return fail(ErrorCode::mismatch, "the calibration is of another number of sensors");
  state_->put_in_force(calibration);
  return {};
}

SensorStatus Pipeline::status(std::uint16_t sensor) const {
  const State& s = *state_;
  SensorStatus status;
  if (sensor >= s.channels.size()) return status;
  status.dropped = s.channels[sensor].dropped;
  status.lost = s.channels[sensor].lost;
  for (std::size_t i = 0; i < s.face.size(); ++i) {
    if (s.face[i] != sensor || s.settings.magnetometer) continue;
    status.heading_rad = s.trackers[i].heading_rad();
    status.heading_sigma_rad = s.trackers[i].sigma_rad();
    status.tilt_sigma_rad = std::sqrt(s.tilt_rad2[i]);
  }
  return status;
}

}  // namespace mien::imu
