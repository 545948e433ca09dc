#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "mien/core/time.h"

namespace mien::sensor {

/// Periods and times of EstimatedClock; all above 0.
struct EstimatedClockSettings {
  /// Taken for the sample period until arrivals show another one: SlimeVR's boards send 100 a second. One
  /// that is longer or shorter than the board's own makes its times wrong until then, for about two seconds
  /// of steady motion.
  Duration first_period = std::chrono::milliseconds(10);
  /// The learned period is held within these. Lowering min_period and raising max_period admit faster and
  /// slower boards, and more wrong periods, learned from bursts and pauses; the other way round a board
  /// outside them never gets its own period.
  Duration min_period = std::chrono::milliseconds(2);
  Duration max_period = std::chrono::milliseconds(50);
  /// After a longer gap the grid's phase is found anew, from the arrival alone. Raising keeps the phase
  /// through longer pauses and trusts the period's last digits more: in ten seconds 100 ppm are 1 ms.
  /// Lowering forgets it in shorter ones, after which the radio's delay is uncertain again.
  Duration keep_phase = std::chrono::seconds(10);
};

/// When the samples of one sensor were taken, where its packets carry no time, come late by a random delay,
/// get lost, and are left away by the board while nothing changes. Known are their arrivals and numbers. A
/// sample stands on the grid of the board's period, before its arrival, and as many periods after the one
/// before as packets were sent between, or more; short delays are likelier than long ones. A histogram filter
/// over the delay holds what follows from that: it keeps the grid's phase through pauses, and the answer is
/// its mean. Period, mean delay and how often samples are left away are learned on the way. Times are on the
/// host's clock, but for the least delay, which nobody can tell, and rise strictly. A pure function of the
/// calls. No allocation. About 2 us a sample. Method, and how well it does: docs/method/clocks.md.
class EstimatedClock {
 public:
  EstimatedClock() : EstimatedClock(EstimatedClockSettings()) {}
  explicit EstimatedClock(const EstimatedClockSettings& settings);

  /// A sample came with the packet of this number, which counts the board's packets of all kinds and rises,
  /// or is 0 where the packet is not counted. Arrivals do not run back; one that does is taken for the last.
  DeviceTime add(HostTime arrival, std::uint64_t number);
  /// A counted packet came that has nothing to do with the sensors' sampling (a temperature).
  void pass() { ++passed_; }
  /// The board began anew, its numbers too; its sampling has another phase, and the same period.
  void restart();

  /// What the samples' period is taken for.
  [[nodiscard]] Duration period() const { return from_seconds(period_s_); }

 private:
  static constexpr std::size_t kBinsPerPeriod = 16;
  static constexpr std::size_t kBins = 20 * kBinsPerPeriod;  // Delays of up to 20 periods.
  using Histogram = std::array<double, kBins>;

  /// A straight line through arrivals over periods.
  struct Block {
    std::size_t size = 0;
    double periods = 0;
    double begin_s = 0;
    double x = 0, y = 0, xx = 0, xy = 0, yy = 0;  // Sums.
  };
  /// What a step of the filter says beside the estimate.
  struct Step {
    double straight = 0;  // Probability that no sample was left away.
    double moved_s = 0;   // In that case: by how much the arrival corrected the prediction.
  };

  void anchor(double arrival_s);
  std::int64_t periods_since(std::uint64_t number);
  void spread();
  Step follow(double arrival_s, std::int64_t periods);
  void learn(const Step& step, std::int64_t periods);
  void add_to_block(double arrival_s, std::int64_t periods);
  void close_block();
  void learn_period(double slope_s);
  [[nodiscard]] double bin_s() const { return period_s_ / kBinsPerPeriod; }

  EstimatedClockSettings settings_;
  double period_s_;
  double mean_delay_s_ = 0.005;
  double extra_ = 0;  // Mean of the periods between two samples beyond those that the numbers tell.
  int straight_run_ = 0;
  std::int64_t straight_ = 0;  // Samples that confirmed the period.
  bool delay_known_ = false;

  bool begun_ = false;
  bool anchored_ = false;
  std::int64_t base_ns_ = 0;  // What the seconds here count from.
  double arrival_s_ = 0;      // Of the newest sample.
  double top_s_ = 0;  // Time of bin 0, the latest that the newest sample can be; bins go back in time.
  double estimate_s_ = 0;
  DeviceTime newest_;
  Histogram weight_{};  // That the newest sample stands in the bin; sums to one.
  Histogram before_{};  // The same of the sample before it, a little spread.
  Histogram comb_{};    // Of before_, summed over the bins whole periods older.
  Histogram fading_{};  // The same, each period older counting less.

  std::uint64_t number_ = 0;
  std::uint64_t passed_ = 0;
  std::array<double, 33> rises_{};  // How often the numbers rose by so many; fades.

  Block block_;
  std::array<double, 5> slopes_s_{};
  std::size_t slope_count_ = 0;
};

}  // namespace mien::sensor
