#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <span>

#include "mien/imu/pipeline_state.h"

namespace mien::imu {
namespace {

using sensor::Sample;
using sensor::SampleKind;

/// A device time this far behind the newest is a restarted board; less is a sample that was overtaken.
constexpr Duration kRestart = std::chrono::seconds(1);
/// Face sensors that bridge the ear sensor's gap: without a sample for this long at most, ...
constexpr Duration kBridgeSilence = std::chrono::milliseconds(30);
/// ... that many at least, since the median of fewer is skin's own turn, and at most.
constexpr std::size_t kLeastToBridge = 4, kMostToBridge = 32;

Vec3 vec3(const FusionInput& in, std::size_t at) {
  return Vec3(in.values[at], in.values[at + 1], in.values[at + 2]);
}

FusionInput input(const Sample& sample, bool fused) {
  FusionInput in{.time = sample.time,
                 .sequence = sample.sequence,
                 .fused = fused,
                 .has_mag = !fused && sample.count >= 9,
                 .time_estimated = sample.time_estimated};
  std::copy_n(sample.values.begin(), in.values.size(), in.values.begin());
  return in;
}

}  // namespace

void Pipeline::State::add(Channel& channel, const FusionInput& in) {
  Integration& done = channel.integration;
  const std::optional<DeviceTime> newest = channel.history.newest();
  if (newest && in.time - *newest < -kRestart) {
    catch_up(channel);
    done.fusion.restart();
    done.newest.reset();
    done.steady_since = in.time;
    done.step = {};
    channel.history.clear();
    channel.track.clear();
    channel.overtaken.reset();
    channel.gap_sigma = 0;  // As the fusion's sum.
    channel.gaps_until.reset();
    channel.restarted = true;
  }
  // No tick has come for long: what waits must not leave the history.
  if (channel.behind &&
      channel.history.size() - channel.history.first_after(*done.newest) >= SampleHistory::kSize / 2)
    catch_up(channel);
  switch (channel.history.insert(in)) {
    case SampleHistory::Place::newest:
      if (!channel.behind) integrate(channel, in);
      return;
    case SampleHistory::Place::late:
      channel.overtaken = channel.history.newest();
      channel.behind = true;
      if (in.time > *done.newest) return;
      {
        const bool rest_expected = done.fusion.rest_expected();
        const bool on_skin = done.fusion.on_skin();
        done = channel.history.before(in.time);
        done.fusion.expect_rest(rest_expected);
        done.fusion.set_on_skin(on_skin);
        channel.track.drop_after(*done.newest);
      }
      return;
    case SampleHistory::Place::rejected:
      ++channel.dropped;
      return;
  }
}

void Pipeline::State::catch_up(Channel& channel) {
  if (!channel.behind) return;
  const std::size_t first = channel.history.first_after(*channel.integration.newest);
  for (std::size_t i = first; i < channel.history.size(); ++i) integrate(channel, channel.history[i]);
  channel.behind = false;
}

void Pipeline::State::integrate(Channel& channel, const FusionInput& in) {
  Integration& done = channel.integration;
  double dt_s = 0;  // 0 for the first and after a restart.
  if (done.newest) {
    const Duration since = in.time - *done.newest;
    dt_s = to_seconds(since);
    if (dt_s > settings.fusion.max_gap_s) done.steady_since = in.time;
    if (done.step > Duration::zero() && since > done.step * 3 / 2)
      done.lost += static_cast<std::uint64_t>((since + done.step / 2) / done.step - 1);
    else
      done.step = since;
  }
  done.newest = in.time;
  if (in.fused)
    integrate_fused(channel, in, dt_s);
  else
    integrate_raw(channel, in, dt_s);
  channel.history.integrated(done);
}

void Pipeline::State::integrate_raw(Channel& channel, const FusionInput& in, double dt_s) {
  Fusion& fusion = channel.integration.fusion;
  const Vec3 accel = vec3(in, 3);
  fusion.add(dt_s, vec3(in, 0), accel);
  if (settings.magnetometer && in.has_mag) fusion.fuse_mag(vec3(in, 6));
  const Quat q = fusion.orientation();
  channel.track.add({in.time, q, q * accel, fusion.rate_rad_s(), fusion.gap_sigma_rad(), fusion.restarts()});
}

void Pipeline::State::integrate_fused(Channel& channel, const FusionInput& in, double dt_s) {
  Quat q(in.values[0], in.values[1], in.values[2], in.values[3]);
  if (q.norm() < 0.5) return;
  q.normalize();
  Vec3 rate = Vec3::Zero();
  if (dt_s > 0 && !channel.track.empty())
    rate = log_rotation(channel.track.newest().orientation.conjugate() * q) / dt_s;
  const Fusion& fusion = channel.integration.fusion;
  channel.track.add({in.time, q, q * vec3(in, 4), rate, fusion.gap_sigma_rad(), fusion.restarts()});
  channel.may_be_unchanged = in.time_estimated;
}

Gaps Pipeline::State::take_gaps(std::uint16_t sensor, DeviceTime frame) {
  Channel& channel = channels[sensor];
  if (!channel.disordered() || channel.track.empty() || !lines->has_samples(sensor))
    return channel.take_gaps();
  const FusedSample& then = channel.track.reached(lines->from_line(sensor, frame) - kFilledWithin);
  return channel.take_gaps(then.gap_sigma_rad, then.restarts, then.time);
}

std::optional<FusedSample> Pipeline::State::pose(std::uint16_t sensor, DeviceTime frame) const {
  const Channel& channel = channels[sensor];
  if (channel.track.empty() || !lines->ready() || !lines->has_samples(sensor)) return std::nullopt;
  return channel.track.at(lines->from_line(sensor, frame),
                          channel.may_be_unchanged ? settings.unchanged : settings.silence,
                          settings.prediction);
}

// What the ear sensor turns while nothing of it is received is the head's turn, which every face sensor felt
// beside its own skin's: the median of each axis.
std::optional<FusedSample> Pipeline::State::bridged_ear(DeviceTime frame) const {
  const Channel& ear = channels[*head];
  if (ear.track.empty() || !calibration.complete || !lines->ready() || !lines->has_samples(*head))
    return std::nullopt;
  FusedSample out = ear.track.newest();
  const DeviceTime now = lines->from_line(*head, frame);
  if (now <= out.time || now - out.time > settings.bridge) return std::nullopt;
  const DeviceTime last = lines->to_line(*head, out.time);
  std::array<std::array<double, kMostToBridge>, 3> turns;
  std::size_t count = 0;
  for (std::size_t i = 0; i < face.size() && count < kMostToBridge; ++i) {
    if (!calibration.sensors[i].valid || !lines->has_samples(face[i])) continue;
    const OrientationTrack& track = channels[face[i]].track;
    const auto at = [&](DeviceTime line) {
      return track.at(lines->from_line(face[i], line), kBridgeSilence, settings.prediction);
    };
    const std::optional<FusedSample> before = at(last), after = at(frame);
    if (!before || !after) continue;
    const Vec3 turn = neutral(i) * log_rotation(before->orientation.conjugate() * after->orientation);
    for (std::size_t c = 0; c < 3; ++c) turns[c][count] = turn[static_cast<int>(c)];
    ++count;
  }
  if (count < kLeastToBridge) return std::nullopt;
  Vec3 median;
  for (std::size_t c = 0; c < 3; ++c) {
    const std::span<double> axis = std::span(turns[c]).first(count);
    std::ranges::sort(axis);
    median[static_cast<int>(c)] = 0.5 * (axis[(count - 1) / 2] + axis[count / 2]);
  }
  out.orientation = out.orientation * exp_rotation(median);
  out.time = now;
  return out;
}

bool Pipeline::State::fresh(std::uint16_t sensor, DeviceTime frame) const {
  const Channel& channel = channels[sensor];
  return channel.may_be_unchanged ||
         lines->from_line(sensor, frame) - channel.track.newest().time <= settings.prediction;
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
      s.add(channel, input(sample, false));
      return;
    case SampleKind::imu_fused:
      if (sample.count < 7) return;
      s.add(channel, input(sample, true));
      return;
    default:  // Another modality's, or ReadyRotations'.
      return;
  }
}

}  // namespace mien::imu
