#include "mien/virtual/speech/microphone_simulator.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mien/speech/sound_block.h"
#include "mien/virtual/node.h"

namespace mien::virt {
namespace {

constexpr double kBlockS = to_seconds(speech::kBlockDuration);

}  // namespace

MicrophoneSimulator::MicrophoneSimulator(const SoundInAir& sound, const MicrophoneFaults& faults,
                                         std::uint64_t device, const Random& random)
    : MicrophoneSimulator(
          sound, faults, device, random,
          VirtualClock::drawn(faults.clock_offset_s, faults.clock_drift_ppm, random.fork("clock"))) {}

// Each fault has a stream of its own: changing one leaves the others as they were.
MicrophoneSimulator::MicrophoneSimulator(const SoundInAir& sound, const MicrophoneFaults& faults,
                                         std::uint64_t device, const Random& random,
                                         const VirtualClock& clock)
    : sound_(sound),
      faults_(faults),
      device_(device),
      clock_(clock),
      // A clock never shows less than zero.
      next_(static_cast<std::uint64_t>(
          std::ceil(std::max(0.0, to_seconds(clock.device(-kDeviceMarginS).time_since_epoch())) / kBlockS))),
      noise_(random.fork("noise")),
      delay_(random.fork("delay")),
      loss_(random.fork("loss")),
      silent_until_s_(-std::numeric_limits<double>::infinity()) {}

double MicrophoneSimulator::heard_s() const {
  return clock_.true_s(speech::BlockHeader{device_, next_}.time());
}

Result<void> MicrophoneSimulator::hear(const std::function<double(double)>& motion_s,
                                       std::vector<Datagram>& sent) {
  constexpr double kSilentLeastS = 1, kSilentMostS = 10;
  const double begin_s = heard_s();
  const double step_s = 1 / (speech::kRateHz * clock_.rate);
  speech::Block block{};
  for (std::size_t i = 0; i < block.size(); ++i) {
    double sample = faults_.level * sound_.at(motion_s(begin_s + static_cast<double>(i) * step_s));
    sample += faults_.offset;
    if (faults_.noise > 0) sample += noise_.normal(0, faults_.noise);
    sample *= double{speech::kFullScale};
    block[i] = static_cast<std::int16_t>(std::lround(std::clamp(sample, -32'768.0, 32'767.0)));
  }
  const speech::BlockHeader header{device_, next_++};
  const double end_s = heard_s();
  const double delay_s = 1e-3 * (faults_.radio_delay_min_ms + delay_.exponential(faults_.radio_delay_ms));
  // Drawn for what is lost too, so that loss does not change what becomes of the others.
  newest_ = std::max(newest_, HostTime(from_seconds(end_s + delay_s)));
  const bool lost = loss_.chance(faults_.packet_loss);
  if (loss_.chance(faults_.sensor_loss_per_hour / 3600.0 * kBlockS))
    silent_until_s_ = end_s + loss_.uniform(kSilentLeastS, kSilentMostS);
  if (lost || end_s <= silent_until_s_) return {};
  MIEN_TRY_ASSIGN(std::vector<std::byte> bytes, speech::encode_packet(header, block));
  sent.push_back({newest_, 0, std::move(bytes)});
  return {};
}

}  // namespace mien::virt
