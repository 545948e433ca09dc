#include "lab/bench/benchmarks.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "app/json_output.h"
#include "lab/bench/clock.h"
#include "lab/commands/output.h"
#include "mien/core/random.h"
#include "mien/core/time.h"
#include "mien/face/frame_hash.h"
#include "mien/face/profile_map.h"
#include "mien/shaping/merge.h"
#include "mien/shaping/shaper.h"

namespace mien::lab {
namespace {

using face::OutputFrame;
using face::Provenance;
using shaping::ChainStep;

constexpr std::size_t kTrackers = 3;
constexpr std::size_t kRounds = 5;
constexpr std::size_t kCycle = 600;  ///< Frames that are prepared: ten seconds, over and over.

struct ShapingBench {
  int frames = 20'000;
  Output to;
};

/// Ten seconds of three trackers, IMUs, glasses and gaze: every shape its own wave with noise on it, with a
/// confidence that wanders, so that shapes are learnt at rest and change hands. (One IMU is lost now and
/// then.)
std::vector<std::array<OutputFrame, kTrackers>> prepared_frames() {
  Random random(1);
  std::vector<std::array<OutputFrame, kTrackers>> cycle(kCycle);
  for (std::size_t f = 0; f < kCycle; ++f)
    for (std::size_t t = 0; t < kTrackers; ++t) {
      OutputFrame& frame = cycle[f][t];
      const double time = static_cast<double>(f) / kFrameRateHz;
      frame.provenance.fill(t == 0 ? Provenance::measured : Provenance::predicted);
      for (std::size_t k = 0; k < face::kShapeCount; ++k) {
        const double phase = static_cast<double>(k) + 0.2 * static_cast<double>(t);
        frame.weights[k] = static_cast<float>(std::clamp(
            0.35 + 0.3 * std::sin(6.283185307 * 0.2 * time * static_cast<double>(1 + k % 5) + phase) +
                random.normal(0, 0.02),
            0.0, 1.0));
        frame.confidence[k] = static_cast<float>(random.uniform(0.3, 1));
      }
      frame.head = exp_rotation({0.1 * std::sin(time), 0.2 * std::cos(time), 0});
      frame.head_confidence = t == 0 ? 1.0F : 0.0F;
      frame.head_provenance = t == 0 ? Provenance::measured : Provenance::neutral;
      if (t != kTrackers - 1) continue;
      frame.eyes_rad.fill({0.2F * static_cast<float>(std::sin(3 * time)), 0.1F});
      frame.eyes_confidence = 1;
      frame.eyes_provenance = Provenance::measured;
    }
  return cycle;
}

/// Every step at work.
shaping::ShaperSettings all_steps() {
  shaping::ShaperSettings settings;
  settings.smoothing = 0.5;
  settings.smooth_head = true;
  settings.resting = true;
  settings.constraints = true;
  for (shaping::ShapeLimits& shape : settings.limits.shapes) shape = {.gain = 1.2F, .low = 0, .high = 0.95F};
  return settings;
}

struct Took {
  double p50_us = 0, p99_us = 0, largest_us = 0;
  std::string hash;
};

/// The chain from three trackers' frames to a profile of 70: each frame's time.
Took measure_chain(const std::vector<std::array<OutputFrame, kTrackers>>& cycle,
                   const shaping::ShaperSettings& settings, std::size_t frames) {
  shaping::Merge merge({"imu", "eyewear", "gaze"});
  merge.set(settings.merge, settings.fallback, settings.runs(ChainStep::merge));
  shaping::Shaper shaper(settings);
  const face::ProfileMap& profile = face::profile_map(face::OutsideProfile::openxr_fb_70);
  std::vector<float> outside(profile.shapes.size());
  std::vector<double> took;
  took.reserve(frames);
  face::FrameHash hash;
  OutputFrame out;
  // A minute and a half first: the face at rest is learnt, the centre in force.
  const std::size_t warm_up = 9 * kCycle;
  for (std::size_t f = 0; f < warm_up + frames; ++f) {
    std::array<OutputFrame, kTrackers> trackers = cycle[f % kCycle];
    for (OutputFrame& frame : trackers)
      frame.time = DeviceTime(frame_offset(static_cast<std::int64_t>(f) + 1));
    if (f == kCycle) shaper.recentre();
    const auto from = Clock::now();
    const std::array<shaping::Merge::Source, kTrackers> sources = {
        {{&trackers[0], f % 300 < 50 ? 11U : 12U, nullptr},
         {&trackers[1], 16, nullptr},
         {&trackers[2], 1, nullptr}}};
    const std::size_t present = merge.apply(sources, out);
    shaper.apply(out, present);
    profile.from_ict(out.weights, out.tongue_out, outside);
    const double seconds = seconds_since(from);
    if (f < warm_up) continue;
    took.push_back(seconds);
    if (f < warm_up + kCycle) hash.add(out);
  }
  const Spread spread = spread_of(std::move(took));
  return {1e6 * spread.p50_s, 1e6 * spread.p99_s, 1e6 * spread.worst_s, hash.hex()};
}

/// A chain, and what it took.
struct ShapingRow {
  std::string what;
  shaping::ShaperSettings settings;
  Took took;
};

const Columns<ShapingRow>& shaping_columns() {
  using Row = ShapingRow;
  static const Columns<Row> columns = {
      {"", "", "{}", &Row::what},
      {"p50_us", "p50, us", "{:.2f}", [](const Row& row) { return row.took.p50_us; }},
      {"p99_us", "p99", "{:.2f}", [](const Row& row) { return row.took.p99_us; }},
      {"max_us", "max", "{:.2f}", [](const Row& row) { return row.took.largest_us; }},
      {"hash", "", "", [](const Row& row) { return row.took.hash; }}};
  return columns;
}

Result<void> run_shaping_bench(const ShapingBench& options) {
  const auto cycle = prepared_frames();
  const auto frames = static_cast<std::size_t>(options.frames);
  const Progress progress = app::terminal_progress("bench shaping");
  const shaping::ShaperSettings everything = all_steps();
  shaping::ShaperSettings nothing = everything;
  nothing.off.set();

  std::vector<ShapingRow> rows = {{"the whole chain", everything, {}}, {"every step off", nothing, {}}};
  for (std::size_t step = 0; step < shaping::kChainStepCount; ++step) {
    rows.push_back({std::string(shaping::kChainStepNames[step]), everything, {}});
    rows.back().settings.off.set(step);
  }
  // In rounds, and of each row that with the smallest median: a neighbour's work falls on all alike.
  for (std::size_t round = 0; round < kRounds; ++round)
    for (std::size_t r = 0; r < rows.size(); ++r) {
      const Took took = measure_chain(cycle, rows[r].settings, frames);
      if (round == 0 || took.p50_us < rows[r].took.p50_us) rows[r].took = took;
      if (!progress(
              static_cast<double>(round * rows.size() + r + 1) / static_cast<double>(kRounds * rows.size()),
              "the chain of shaping"))
        return fail(ErrorCode::cancelled, "stopped before it was done", "bench shaping");
    }
  const Took &all = rows[0].took, &none = rows[1].took;
  const double frame_us = 1e6 / kFrameRateHz;
  app::Json json = json_of(rows[0], shaping_columns());
  json["frames"] = frames;
  json["trackers"] = kTrackers;
  json["profile"] = "openxr_fb_70";
  json["every_step_off"] = json_of(rows[1], shaping_columns());
  json["vs_every_step_off"] = all.p50_us / none.p50_us;
  json["share_of_a_frame"] = all.p50_us / frame_us;
  measure::Report report("The chain of shaping",
                         fmt::format("{} frames of three trackers, out to openxr_fb_70", frames));
  measure::Table table = table_of("", rows, shaping_columns());
  for (std::size_t r = 2; r < rows.size(); ++r) {
    app::Json& step = json["without"][rows[r].what] = json_of(rows[r], shaping_columns());
    step["costs_us"] = all.p50_us - rows[r].took.p50_us;
    table.rows[r].front() = "without " + rows[r].what;
  }
  report.table(table);
  report.text(
      fmt::format("p50 {:.1f} times that with every step off, {:.2f} % of a frame at 60 a second; "
                  "hash {}",
                  all.p50_us / none.p50_us, 100 * all.p50_us / frame_us, all.hash));
  return put_out(options.to, report, json);
}

}  // namespace

void add_shaping_bench(app::Commands& commands, app::Command bench) {
  auto options = std::make_shared<ShapingBench>();
  const app::Command command =
      commands.add_under(bench, "shaping",
                         "The whole chain between trackers and sinks, with every step at work: three "
                         "trackers merged, shaped, and "
                         "out to a profile of 70 shapes; beside it the chain without each step",
                         "mien bench shaping --json", [options] { return run_shaping_bench(*options); });
  command.add_option("--frames", options->frames, "How many frames are measured, five times a row")
      .in_range(600, 10'000'000)
      .show_default();
  app::add_json_flag(command, options->to.json);
}

}  // namespace mien::lab
