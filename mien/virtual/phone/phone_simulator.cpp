#include "mien/virtual/phone/phone_simulator.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include "mien/face/profile_map.h"
#include "mien/shaping/eyes.h"
#include "mien/sink/arkit_frame.h"
#include "mien/virtual/node.h"

namespace mien::virt {
namespace {

/// What its user called it; its id follows from that.
constexpr std::string_view kSubject = "virtual phone";
constexpr double kSixtieths = 60;
/// Moments each way of one that is smoothed, half a sigma apart: three sigmas.
constexpr int kSmoothedEachWay = 6;

/// Where the eyes look there is nothing to rest at.
bool rests(std::size_t shape) {
  return !face::kShapeNames[shape].starts_with("eyeLook");
}

float drawn_gain(double sigma, Random& random) {
  return static_cast<float>(std::max(0.0, random.normal(1, sigma)));
}

}  // namespace

// Each fault has a stream of its own: changing one leaves the others as they were.
PhoneSimulator::PhoneSimulator(const PhoneFaults& faults, double motion_start_s, const Random& random)
    : faults_(faults),
      motion_start_s_(motion_start_s),
      clock_(VirtualClock::drawn(faults.clock_offset_s, faults.clock_drift_ppm, random.fork("clock"))),
      lag_s_(1e-3 * random.fork("lag").uniform(faults.lag_ms[0], faults.lag_ms[1])),
      // A counter begins at zero.
      next_(std::max(std::int64_t{0},
                     static_cast<std::int64_t>(std::ceil(
                         to_seconds(clock_.device(-kDeviceMarginS).time_since_epoch()) * faults.rate_hz)))),
      noises_(random.fork("noise")),
      delays_(random.fork("delay")),
      drops_(random.fork("drop")),
      losses_(random.fork("loss")),
      lost_until_s_(-std::numeric_limits<double>::infinity()),
      source_(sink::live_link_source(kSubject)) {
  Random rests_at = random.fork("rest"), gains = random.fork("gain");
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    const double rest = std::min(1.0, std::abs(rests_at.normal(0, faults.resting_offset)));
    rest_[k] = rests(k) ? static_cast<float>(rest) : 0.0F;
    gain_[k] = drawn_gain(faults.gain_error, gains);
    noise_[k] = static_cast<float>(noises_.normal(0, faults.noise));
  }
}

double PhoneSimulator::filmed_s() const {
  return clock_.true_s(DeviceTime(from_seconds(static_cast<double>(next_) / faults_.rate_hz)));
}

void PhoneSimulator::film(const Performed& performed, std::vector<Datagram>& sent) {
  const double frame_s = filmed_s();
  const double count_hz = faults_.counts_sixtieths ? kSixtieths : faults_.rate_hz;
  sink::LiveLinkFrame frame{.number = next_++ * std::llround(count_hz / faults_.rate_hz),
                            .rate_hz = static_cast<std::int32_t>(count_hz)};
  let_noise_go_on();
  // Drawn for what is dropped too, so that this does not change what becomes of the others.
  const double delay_s = 1e-3 * delays_.uniform(faults_.delay_ms[0], faults_.delay_ms[1]);
  newest_ = std::max(newest_, HostTime(from_seconds(frame_s + delay_s)));
  if (losses_.chance(faults_.face_loss_per_hour / 3600 / faults_.rate_hz))
    lost_until_s_ =
        std::max(lost_until_s_, frame_s + losses_.uniform(faults_.face_loss_s[0], faults_.face_loss_s[1]));
  if (drops_.chance(faults_.frames_dropped)) return;
  if (sees_face(frame_s))
    frame.values = sink::live_link_values(sink::arkit_frame(told(performed, frame_s - lag_s_)));
  packet_.clear();
  sink::encode_live_link(frame, source_, packet_);
  sent.push_back({newest_, 0, {packet_[0].begin(), packet_[0].end()}});
}

bool PhoneSimulator::sees_face(double frame_s) const {
  const double motion_s = frame_s - motion_start_s_;
  const bool told_to_lose =
      motion_s >= faults_.face_lost_between_s[0] && motion_s < faults_.face_lost_between_s[1];
  return !told_to_lose && frame_s >= lost_until_s_;
}

face::OutputFrame PhoneSimulator::told(const Performed& performed, double shown_s) const {
  face::OutputFrame out;
  out.head = performed(shown_s).head;
  // Symmetrical in time, so that it adds no lag.
  std::array<double, face::kInnerCount> sum{};
  double all = 0;
  const int each_way = faults_.smoothing_ms > 0 ? kSmoothedEachWay : 0;
  for (int i = -each_way; i <= each_way; ++i) {
    const double share = std::exp(-0.125 * i * i);
    const face::MotionFrame moment = performed(shown_s + 0.5e-3 * i * faults_.smoothing_ms);
    for (std::size_t k = 0; k < face::kShapeCount; ++k) sum[k] += share * double{moment.weights[k]};
    sum[face::kShapeCount] += share * double{moment.tongue_out};
    all += share;
  }
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    const auto weight = static_cast<float>(sum[k] / all);
    out.weights[k] = std::clamp(rest_[k] + (1 - rest_[k]) * gain_[k] * weight + noise_[k], 0.0F, 1.0F);
  }
  out.tongue_out = static_cast<float>(sum[face::kShapeCount] / all);
  shaping::eyes_from_weights(out);
  return out;
}

void PhoneSimulator::let_noise_go_on() {
  const double kept =
      faults_.noise_time_s > 0 ? std::exp(-1 / (faults_.rate_hz * faults_.noise_time_s)) : 0.0;
  const double added = faults_.noise * std::sqrt(1 - kept * kept);
  for (float& noise : noise_) noise = static_cast<float>(kept * double{noise} + noises_.normal(0, added));
}

}  // namespace mien::virt
