#include "mien/mocap/marker_retarget.h"

#include <algorithm>
#include <utility>

#include "mien/core/units.h"

namespace mien::mocap {
namespace {

/// Longest time between frames over which weights are smoothed.
constexpr double kLongestStepS = 1;

}  // namespace

Result<Retargeted> retarget_markers(const CleanMarkers& clean, const builtin_face::PlacedMarkers& placed,
                                    const face::WeightSolverSettings& settings) {
  const MarkerTrack& track = clean.track;
  if (track.count() != placed.count() || track.frames() == 0 || clean.head.size() != track.frames())
    return fail(ErrorCode::mismatch, "the recording's markers are not those on the face", "retargeting");
  Eigen::VectorXd neutral_m(3 * static_cast<Eigen::Index>(placed.count()));
  for (std::size_t m = 0; m < placed.count(); ++m)
    neutral_m.segment<3>(3 * static_cast<Eigen::Index>(m)) = placed.neutral_m()[m];
  MIEN_TRY_ASSIGN(face::WeightSolver solver,
                  face::WeightSolver::create(std::move(neutral_m), placed.shapes_m(),
                                             face::natural_constraints(), settings));
  std::vector<bool> ever(placed.count(), false);
  for (std::size_t i = 0; i < track.frames(); ++i)
    for (std::size_t m = 0; m < track.count(); ++m) ever[m] = ever[m] || is_seen(track.frame(i)[m]);
  const auto needed = static_cast<std::size_t>(std::ranges::count(ever, true) + 1) / 2;

  Retargeted result;
  result.motion.name = track.name;
  result.residual_of_mm.assign(placed.count(), 0.0);
  std::vector<std::size_t> seen_of(placed.count(), 0);
  std::optional<double> solved_s;
  std::optional<Eigen::Isometry3d> first;
  Eigen::VectorXd points_m(3 * static_cast<Eigen::Index>(placed.count()));
  for (std::size_t i = 0; i < track.frames(); ++i) {
    face::MotionFrame& frame = result.motion.frames.emplace_back();
    frame.time_s = track.time_s[i] - track.time_s.front();
    if (const auto& head = clean.head[i]) {
      if (!first) first = head;
      frame.head = canonical(Quat(Mat3(first->linear().transpose() * head->linear())));
      frame.head_position_m = first->linear().transpose() * (head->translation() - first->translation());
      result.motion.has_head =
          result.motion.has_head || !frame.head.coeffs().isApprox(Quat::Identity().coeffs());
    }
    std::size_t seen = 0;
    for (std::size_t m = 0; m < track.count(); ++m) {
      points_m.segment<3>(3 * static_cast<Eigen::Index>(m)) = track.frame(i)[m].cast<double>();
      seen += is_seen(track.frame(i)[m]) ? 1 : 0;
    }
    frame.has_face = seen > 0 && seen >= needed;
    if (!frame.has_face) {
      ++result.without_face;
      continue;
    }
    const double step_s = solved_s ? std::min(track.time_s[i] - *solved_s, kLongestStepS) : kLongestStepS;
    solver.solve(points_m, {}, step_s, frame.weights);
    solved_s = track.time_s[i];
    const Eigen::VectorXd reached_m = placed.at(frame.weights);
    for (std::size_t m = 0; m < track.count(); ++m) {
      if (!is_seen(track.frame(i)[m])) continue;
      const auto at = 3 * static_cast<Eigen::Index>(m);
      result.residual_of_mm[m] += kMmPerM * (reached_m.segment<3>(at) - points_m.segment<3>(at)).norm();
      ++seen_of[m];
    }
  }
  std::size_t all = 0;
  for (std::size_t m = 0; m < placed.count(); ++m) {
    result.residual_mm += result.residual_of_mm[m];
    all += seen_of[m];
    if (seen_of[m] > 0) result.residual_of_mm[m] /= static_cast<double>(seen_of[m]);
  }
  if (all > 0) result.residual_mm /= static_cast<double>(all);
  return result;
}

MarkerTrack markers_of_motion(const face::Motion& motion, const builtin_face::PlacedMarkers& placed,
                              const builtin_face::MarkerSet& set) {
  MarkerTrack track;
  track.name = motion.name;
  for (const builtin_face::Marker& marker : set.markers) track.markers.push_back(marker.name);
  for (const face::MotionFrame& frame : motion.frames) {
    track.time_s.push_back(frame.time_s);
    const Eigen::VectorXd positions_m = placed.at(frame.weights);
    for (std::size_t m = 0; m < set.markers.size(); ++m)
      track.position_m.push_back(
          frame.has_face ? Vec3f(positions_m.segment<3>(3 * static_cast<Eigen::Index>(m)).cast<float>())
                         : kLostMarker);
  }
  return track;
}

}  // namespace mien::mocap
