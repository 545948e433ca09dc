#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "lab/bench/attacked_session.h"
#include "mien/core/median.h"

namespace mien::lab {
namespace {

constexpr double kMostPveShare = 0.02;
constexpr double kMostUnheardShare = 0.01;
constexpr double kMostP99_ms = 1;
constexpr double kMostP99Keyed_ms = 0.2;
/// Frames at the window's ends come or stay out by a hair.
constexpr double kMostAdded = 1;
/// A tenth of a second: pictures that a busy machine sends late, or not at all. Of the frames, ...
constexpr double kMostFewer = 6;
/// ... and of the two good cameras together.
constexpr double kMostPicturesUnheard = 2 * kMostFewer;
/// Ten seconds of frames, for a percentile of one in a hundred.
constexpr double kLeastTimed = 600;
/// What a session may need for strangers: its queues are of fixed size, and what strangers send that is well
/// formed fills those of the recording (the ring of 8 MB, the 16 that a take's writer has under way, a slice
/// of 4), with what the allocator keeps beside them.
constexpr double kMostMemory_mb = 40;

double median_of(const std::vector<AttackFigures>& runs, double AttackFigures::*figure) {
  std::vector<double> values;
  for (const AttackFigures& run : runs) values.push_back(run.*figure);
  return values.empty() ? 0 : upper_median(std::move(values));
}

double largest_of(const std::vector<AttackFigures>& runs, double AttackFigures::*figure) {
  double largest = 0;
  for (const AttackFigures& run : runs) largest = std::max(largest, run.*figure);
  return largest;
}

std::vector<double> errors_of(const std::vector<AttackFigures>& runs) {
  std::vector<double> values;
  for (const AttackFigures& run : runs)
    if (run.pve_mm) values.push_back(*run.pve_mm);
  return values;
}

}  // namespace

AttackFigures median(const std::vector<AttackFigures>& runs) {
  AttackFigures out;
  using F = AttackFigures;
  for (double F::*figure : {&F::frames, &F::missed, &F::added, &F::p50_ms, &F::p99_ms, &F::peak_memory_mb,
                            &F::dropped, &F::evicted, &F::malformed, &F::heard, &F::strangers, &F::sent})
    out.*figure = median_of(runs, figure);
  if (auto errors = errors_of(runs); !errors.empty()) out.pve_mm = upper_median(std::move(errors));
  out.same_bits = !runs.empty() && std::ranges::all_of(runs, &F::same_bits);
  return out;
}

std::vector<std::string> breaches(const Attack& attack, bool keyed,
                                  const std::vector<AttackFigures>& attacked,
                                  const std::vector<AttackFigures>& quiet) {
  std::vector<std::string> out;
  const AttackFigures with = median(attacked), without = median(quiet);
  if (keyed || !attack.behaves) {
    if (with.strangers > 0) out.push_back(fmt::format("{:.0f} readings of his accepted", with.strangers));
    const double most_unheard =
        std::max(kMostUnheardShare * without.heard, attack.camera != nullptr ? kMostPicturesUnheard : 0);
    if (with.heard < without.heard - most_unheard)
      out.push_back(
          fmt::format("{:.1f} % of the devices' readings accepted", 100 * with.heard / without.heard));
    if (without.pve_mm) {
      const double spread = std::ranges::max(errors_of(quiet)) - *without.pve_mm;
      const double most = *without.pve_mm + std::max(kMostPveShare * *without.pve_mm, spread);
      if (!with.pve_mm || *with.pve_mm > most) out.push_back("the face moved");
    }
  }
  // A busy machine drops frames of a quiet session too: none is added by a session that drops none.
  const double expected = std::max(without.added, 0.0);
  if (with.added > expected + kMostAdded)
    out.push_back(fmt::format("{:.0f} frames added", with.added - expected));
  if (attack.camera != nullptr && with.added < without.added - kMostFewer)
    out.push_back(fmt::format("{:.0f} frames fewer", without.added - with.added));
  // A session that is too short for a face's comparison is too short for a percentile.
  const bool timed = attack.camera != nullptr ? without.frames >= kLeastTimed : without.pve_mm.has_value();
  if (timed && with.missed > largest_of(quiet, &AttackFigures::missed))
    out.push_back(fmt::format("{:.0f} frames missed", with.missed));
  const double spread_ms = largest_of(quiet, &AttackFigures::p99_ms) - without.p99_ms;
  if (timed && with.p99_ms - without.p99_ms > (keyed ? std::max(kMostP99Keyed_ms, spread_ms) : kMostP99_ms))
    out.push_back(fmt::format("p99 {:+.2f} ms", with.p99_ms - without.p99_ms));
  if (with.peak_memory_mb - without.peak_memory_mb > kMostMemory_mb)
    out.push_back(fmt::format("memory {:+.1f} MB", with.peak_memory_mb - without.peak_memory_mb));
  if (!with.same_bits) out.push_back("its take replays to other bits");
  return out;
}

}  // namespace mien::lab
