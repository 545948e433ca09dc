#include "lab/imu/hours_summary.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace mien::lab {
namespace {

HoursErrors mean_of(std::span<const HoursRun> runs, const HoursPiece& (*piece)(const HoursRun&)) {
  HoursErrors sum;
  for (const HoursRun& run : runs) {
    const HoursErrors& mse = piece(run).mse;
    sum.device += mse.device;
    sum.lab += mse.lab;
    sum.known += mse.known;
    sum.frozen += mse.frozen;
  }
  const auto count = static_cast<double>(runs.size());
  return {sum.device / count, sum.lab / count, sum.known / count, sum.frozen / count};
}

/// The one that begins ten minutes after what happens to a sensor, within a minute; the last one if none
/// does.
const HoursPiece& piece_after(const HoursRun& run) {
  for (const HoursPiece& piece : run.pieces)
    if (piece.begin_s >= run.event_end_s + performer::kPieceS - 60) return piece;
  return run.pieces.back();
}

HoursSummary summary_of(std::span<const HoursRun> runs) {
  HoursSummary out{.script = runs.front().script, .scenario = runs.front().scenario, .runs = runs.size()};
  out.first_mse = mean_of(runs, [](const HoursRun& run) -> const HoursPiece& { return run.pieces.front(); });
  out.last_mse = mean_of(runs, [](const HoursRun& run) -> const HoursPiece& { return run.pieces.back(); });
  out.within_most = share_within(runs, kRatioOfMost);
  out.within_all = share_within(runs, kRatioOfAll);
  for (std::size_t p = 0; p < runs.front().pieces.size(); ++p) {
    double rotation_deg = 0, nees = 0;
    for (const HoursRun& run : runs) {
      const HoursPiece& piece = run.pieces[p];
      rotation_deg += piece.rotation_rms_deg / static_cast<double>(runs.size());
      nees += piece.nees / static_cast<double>(runs.size());
      if (p == 0) out.first_missing += piece.missing / static_cast<double>(runs.size());
      out.worst_ratio = std::max(out.worst_ratio, piece.ratio);
      out.worst_missing = std::max(out.worst_missing, piece.missing);
      if (piece.worst_bias > out.worst_bias) {
        out.worst_bias = piece.worst_bias;
        out.worst_shape = piece.worst_shape;
      }
    }
    if (p == 0) out.first_rotation_deg = rotation_deg;
    out.worst_rotation_deg = std::max(out.worst_rotation_deg, rotation_deg);
    out.least_nees = p == 0 ? nees : std::min(out.least_nees, nees);
    out.most_nees = std::max(out.most_nees, nees);
  }
  for (const HoursRun& run : runs) {
    const HoursPiece& piece = piece_after(run);
    const auto count = static_cast<double>(runs.size());
    out.sensor_deg += piece.sensor_rms_deg * piece.sensor_rms_deg / count;
    out.frozen_sensor_deg += piece.frozen_sensor_rms_deg * piece.frozen_sensor_rms_deg / count;
  }
  out.sensor_deg = std::sqrt(out.sensor_deg);
  out.frozen_sensor_deg = std::sqrt(out.frozen_sensor_deg);
  return out;
}

}  // namespace

std::vector<HoursSummary> summarise(std::span<const HoursRun> runs) {
  std::vector<HoursSummary> out;
  for (const HoursRun& run : runs) {
    const auto same = [&run](const auto& other) {
      return other.script == run.script && other.scenario == run.scenario;
    };
    if (std::ranges::any_of(out, same)) continue;
    std::vector<HoursRun> alike;
    std::ranges::copy_if(runs, std::back_inserter(alike), same);
    out.push_back(summary_of(alike));
  }
  return out;
}

double share_within(std::span<const HoursRun> runs, double limit) {
  const auto within = std::ranges::count_if(runs, [limit](const HoursRun& run) {
    return std::ranges::all_of(run.pieces, [limit](const HoursPiece& piece) { return piece.ratio <= limit; });
  });
  return runs.empty() ? 0 : static_cast<double>(within) / static_cast<double>(runs.size());
}

}  // namespace mien::lab
