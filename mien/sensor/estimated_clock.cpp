#include "mien/sensor/estimated_clock.h"

#include <algorithm>
#include <cmath>

namespace mien::sensor {
namespace {

// All of these were tuned on tests/sensor/estimated_clock_test.cpp's boards: delays of 3 to 20 ms, in order
// and not, with 10 % loss, pauses, rests in which single samples are left away, and stalls of the radio.

/// Process noise: the share of a bin that diffuses into each neighbour a sample, for the grid is not quite
/// even.
constexpr double kSpread = 0.003;
/// The prior of a delay is exponential about the mean delay; this share of it is a stall's, with so many
/// times the mean.
constexpr double kStallShare = 0.005;
constexpr double kStallTimes = 6;
/// The prior of how many samples in a row a board skipped: this share is uniform, the rest geometric.
constexpr double kAnyNumber = 0.02;
/// Bounds of the probability that a sample is skipped at all, and the least ratio of the geometric prior.
constexpr double kLeastSkips = 0.001;
constexpr double kMostSkips = 0.8;
constexpr double kLeastFading = 0.3;
/// Probability that the packets' numbers count a period too many: a lost packet that carried no sample.
constexpr double kOneFewer = 0.005;
/// Likelihood of an outlier: an arrival that no hypothesis of the filter predicts.
constexpr double kAnywhere = 1e-6;
/// Packets that arrive within this time were queued behind one stall: their delays are not independent.
constexpr double kQueued_s = 0.0005;

/// Gain of the exponential average extra_, its bounds, and the noise band in which delays alone explain it.
constexpr double kExtraGain = 0.02;
constexpr double kExtraMost = 3;
constexpr double kExtraLeast = -8;
constexpr double kExtraNoise = 3 * kExtraGain;
/// Below this many skipped periods a sample, a block's scatter measures the radio's delay.
constexpr double kFewSkips = 0.08;

constexpr double kStraight =
    0.8;  ///< Probability that nothing was skipped, from which a step counts as straight,
constexpr int kStraightRun = 12;  ///< and the steps in a row after which the period adapts.
constexpr double kPeriodGain = 0.0002;
/// Straight samples after which the period is confirmed: it is then replaced only by a very different one,
/// and by no longer one, since boards that skip samples seem slow.
constexpr std::int64_t kConfirmed = 300;

constexpr std::size_t kBlockSamples = 32;
constexpr double kBlockGap = 10;  ///< A pause of so many periods ends a block.
constexpr double kLeastDelay_s = 0.0005;
constexpr double kMostDelay_s = 0.05;

}  // namespace

EstimatedClock::EstimatedClock(const EstimatedClockSettings& settings)
    : settings_(settings), period_s_(to_seconds(settings.first_period)) {}

void EstimatedClock::restart() {
  anchored_ = false;
  number_ = 0;
  passed_ = 0;
}

DeviceTime EstimatedClock::add(HostTime arrival, std::uint64_t number) {
  const std::int64_t arrival_ns = arrival.time_since_epoch().count();
  if (!begun_) base_ns_ = arrival_ns;
  const double arrival_s = std::max(static_cast<double>(arrival_ns - base_ns_) * 1e-9, arrival_s_);
  const std::int64_t periods = periods_since(number);
  if (!anchored_ || arrival_s - arrival_s_ > to_seconds(settings_.keep_phase)) {
    anchor(arrival_s);
  } else {
    add_to_block(arrival_s, periods);
    learn(follow(arrival_s, periods), periods);
  }
  arrival_s_ = arrival_s;
  const DeviceTime time(Duration(base_ns_) + from_seconds(estimate_s_));
  newest_ = begun_ ? std::max(time, newest_ + from_seconds(bin_s())) : time;
  begun_ = true;
  return newest_;
}

/// How many periods the numbers tell since the last sample, 1 at least.
std::int64_t EstimatedClock::periods_since(std::uint64_t number) {
  const std::uint64_t before = number_;
  const std::uint64_t passed = passed_;
  if (number == 0) return 1;
  number_ = number;
  passed_ = 0;
  if (before == 0 || number <= before || number - before <= passed) return 1;
  const std::uint64_t rise = number - before - passed;
  if (rise < rises_.size()) {
    for (double& often : rises_) often *= 0.99;
    rises_[rise] += 1;
  }
  // A board sends as many packets a period as the numbers rise by most often.
  const auto usual = std::distance(rises_.begin(), std::max_element(rises_.begin(), rises_.end()));
  const double periods = static_cast<double>(rise) / static_cast<double>(std::max<std::ptrdiff_t>(usual, 1));
  return static_cast<std::int64_t>(std::clamp(std::round(periods), 1.0, 1e6));
}

/// Nothing is known but the arrival.
void EstimatedClock::anchor(double arrival_s) {
  anchored_ = true;
  block_ = {};
  top_s_ = arrival_s;
  const double fade = std::exp(-bin_s() / mean_delay_s_);
  double likelihood = 1;
  double sum = 0;
  double mean = 0;
  for (std::size_t b = 0; b < kBins; ++b) {
    weight_[b] = likelihood;
    sum += likelihood;
    mean += likelihood * static_cast<double>(b);
    likelihood *= fade;
  }
  for (double& weight : weight_) weight /= sum;
  estimate_s_ = top_s_ - mean / sum * bin_s();
}

void EstimatedClock::spread() {
  const double skips = std::max(0.0, extra_ - kExtraNoise * mean_delay_s_ / period_s_);
  const double fading = std::max(kLeastFading, std::min(skips / (1 + skips), kMostSkips));
  for (std::size_t b = kBins; b-- > 0;) {
    const double later = weight_[b > 0 ? b - 1 : b];
    const double earlier = weight_[b + 1 < kBins ? b + 1 : b];
    before_[b] = weight_[b] + kSpread * (later + earlier - 2 * weight_[b]);
    const bool has_older = b + kBinsPerPeriod < kBins;
    comb_[b] = before_[b] + (has_older ? comb_[b + kBinsPerPeriod] : 0.0);
    fading_[b] = (1 - fading) * before_[b] + (has_older ? fading * fading_[b + kBinsPerPeriod] : 0.0);
  }
}

/// One step of the filter: where the sample can stand after the one before, and how likely its delay then is.
EstimatedClock::Step EstimatedClock::follow(double arrival_s, std::int64_t periods) {
  constexpr auto kPeriod = static_cast<std::int64_t>(kBinsPerPeriod);
  constexpr auto kAll = static_cast<std::int64_t>(kBins);
  const double extra = (arrival_s - arrival_s_) / period_s_ - static_cast<double>(periods);
  extra_ += kExtraGain * (std::clamp(extra, kExtraLeast, kExtraMost) - extra_);
  extra_ = std::clamp(extra_, -0.2, 4.0);
  const double skips = std::max(0.0, extra_ - kExtraNoise * mean_delay_s_ / period_s_);
  const double skip_share = std::clamp(skips / (1 + skips), kLeastSkips, kMostSkips);
  spread();

  // Bins keep their places on the grid: they move by whole ones.
  const auto shift = static_cast<std::int64_t>(std::floor((arrival_s - top_s_) / bin_s()));
  top_s_ += static_cast<double>(shift) * bin_s();
  const bool queued = arrival_s - arrival_s_ < kQueued_s;
  const double fade = queued ? 1.0 : std::exp(-bin_s() / mean_delay_s_);
  const double stall_fade = queued ? 1.0 : std::exp(-bin_s() / (kStallTimes * mean_delay_s_));
  double prompt = 1 - kStallShare;
  double stalled = kStallShare;
  double sum = 0;
  double mean = 0;
  double straight = 0;
  double corrected = 0;
  for (std::int64_t b = 0; b < kAll; ++b) {
    const auto at = [&](const Histogram& histogram, std::int64_t bin) {
      return bin >= 0 && bin < kAll ? histogram[static_cast<std::size_t>(bin)] : 0.0;
    };
    const std::int64_t same =
        b - shift + periods * kPeriod;          // The bin of the sample before, nothing left away.
    const std::int64_t later = same + kPeriod;  // The first bin from where something was.
    const std::int64_t first = later >= 0 ? later : (later % kPeriod + kPeriod) % kPeriod;
    const double skipped = at(fading_, later) + kAnyNumber * at(comb_, first);
    const double fewer = periods > 1 ? kOneFewer * at(before_, same - kPeriod) : 0.0;
    const double likelihood = prompt + stalled;
    const double stay = (1 - skip_share) * at(before_, same) * likelihood;
    const double weight = stay + (skip_share * skipped + fewer + kAnywhere) * likelihood;
    weight_[static_cast<std::size_t>(b)] = weight;
    sum += weight;
    mean += weight * static_cast<double>(b);
    straight += stay;
    corrected += stay * static_cast<double>(same);
    prompt *= fade;
    stalled *= stall_fade;
  }
  for (double& weight : weight_) weight /= sum;
  estimate_s_ = top_s_ - mean / sum * bin_s();
  double predicted = 0;
  double total = 0;
  for (std::size_t b = 0; b < kBins; ++b) {
    predicted += before_[b] * static_cast<double>(b);
    total += before_[b];
  }
  return {straight / sum, straight > 0 ? (predicted / total - corrected / straight) * bin_s() : 0.0};
}

/// Where steps go straight on, what corrects them is the period's error.
void EstimatedClock::learn(const Step& step, std::int64_t periods) {
  straight_run_ = step.straight > kStraight ? straight_run_ + 1 : 0;
  if (straight_run_ < kStraightRun) return;
  ++straight_;
  period_s_ = std::clamp(period_s_ + kPeriodGain * step.moved_s / static_cast<double>(periods),
                         to_seconds(settings_.min_period), to_seconds(settings_.max_period));
}

void EstimatedClock::add_to_block(double arrival_s, std::int64_t periods) {
  if (block_.size == 0 || arrival_s - arrival_s_ > kBlockGap * period_s_) {
    block_ = {.size = 1, .begin_s = arrival_s};
    return;
  }
  block_.periods += static_cast<double>(periods);
  const double x = block_.periods;
  const double y = arrival_s - block_.begin_s;
  block_.x += x;
  block_.y += y;
  block_.xx += x * x;
  block_.xy += x * y;
  block_.yy += y * y;
  if (++block_.size == kBlockSamples) close_block();
}

/// The scatter of arrivals about their line is the delay's, and of exponential delays as large as their mean.
void EstimatedClock::close_block() {
  const auto count = static_cast<double>(block_.size);
  const double xx = block_.xx - block_.x * block_.x / count;
  const double xy = block_.xy - block_.x * block_.y / count;
  const double yy = block_.yy - block_.y * block_.y / count;
  block_ = {};
  const double slope_s = xy / xx;  // Periods rise with every sample: xx is not 0.
  if (!delay_known_ || extra_ < kFewSkips) {
    const double scatter_s = std::sqrt(std::max(0.0, yy - slope_s * xy) / (count - 2));
    const double gain = !delay_known_ ? 1.0 : scatter_s < mean_delay_s_ ? 0.3 : 0.1;
    // Not below a bin and a half: there the histogram has no more to say, and its numbers get absurdly small.
    mean_delay_s_ = std::clamp(mean_delay_s_ + gain * (scatter_s - mean_delay_s_),
                               std::max(kLeastDelay_s, bin_s() / 1.5), kMostDelay_s);
    delay_known_ = extra_ < kFewSkips;
  }
  learn_period(slope_s);
}

/// Blocks in a row that agree on another period are believed.
void EstimatedClock::learn_period(double slope_s) {
  slopes_s_[slope_count_++ % slopes_s_.size()] = slope_s;
  if (slope_count_ < slopes_s_.size()) return;
  auto sorted = slopes_s_;
  std::sort(sorted.begin(), sorted.end());
  const double middle_s = sorted[sorted.size() / 2];
  const bool confirmed = straight_ > kConfirmed;
  // Three deviations of a slope: that of evenly spaced samples is sqrt(12 / n^3) of the delay's.
  const double noise_s = 3 * mean_delay_s_ *
                         std::sqrt(12.0 / static_cast<double>(kBlockSamples * kBlockSamples * kBlockSamples));
  if (std::abs(middle_s - period_s_) < (confirmed ? 0.1 : 0.03) * period_s_ + noise_s) return;
  if (confirmed && middle_s > period_s_) return;
  if (sorted.back() - sorted.front() > 0.03 * middle_s + noise_s) return;
  period_s_ = std::clamp(middle_s, to_seconds(settings_.min_period), to_seconds(settings_.max_period));
  straight_ = 0;
  slope_count_ = 0;
  extra_ = 0;
}

}  // namespace mien::sensor
