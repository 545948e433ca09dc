#include "lab/eyewear/marker_capture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "mien/builtin_face/builtin_face.h"
#include "mien/mocap/marker_cleaning.h"
#include "mien/performer/performer.h"
#include "mien/performer/script.h"
#include "mien/performer/style.h"
#include "mien/sensor/rig.h"
#include "tests/project_path.h"

namespace mien::lab::marker_capture_test {
namespace {

const std::vector<Vec3> kPlaces = {Vec3(0, 0, 0.1), Vec3(0.01, 0, 0.1), Vec3(0.05, 0, 0.1)};

Eigen::VectorXd truth() {
  Eigen::VectorXd markers(9);
  for (std::size_t i = 0; i < 3; ++i) markers.segment<3>(3 * static_cast<Eigen::Index>(i)) = kPlaces[i];
  return markers;
}

TEST(MarkerCapture, PerfectCaptureIsTheTruth) {
  MarkerCapture capture(virt::EyewearFaults{}, kPlaces, Random(1));
  for (int i = 0; i < 100; ++i) EXPECT_EQ(capture.capture(i, truth()), truth());
}

TEST(MarkerCapture, JittersByWhatIsAsked) {
  virt::EyewearFaults faults;
  faults.marker_jitter_mm = 0.2;
  MarkerCapture capture(faults, kPlaces, Random(1));
  double squares = 0;
  for (int i = 0; i < 1000; ++i) squares += (capture.capture(i, truth()) - truth()).squaredNorm();
  EXPECT_NEAR(std::sqrt(squares / 9000), 0.0002, 1e-5);
}

TEST(MarkerCapture, NeighboursChangeNames) {
  virt::EyewearFaults faults;
  faults.mislabel_per_min = 30;
  faults.mislabel_s = 1;
  MarkerCapture capture(faults, kPlaces, Random(1));
  int swapped = 0;
  for (int i = 0; i < 3000; ++i) {
    const Eigen::VectorXd seen = capture.capture(0.1 * i, truth());
    if (seen == truth()) continue;
    ++swapped;
    // Marker 2's nearest is 1: marker 0 never takes 2's name.
    EXPECT_NE(Vec3(seen.head<3>()), kPlaces[2]);
    EXPECT_NEAR(seen.sum(), truth().sum(), 1e-12);
  }
  EXPECT_NEAR(swapped / 3000.0, 1.0 / 3, 0.08);
}

TEST(MarkerCapture, CoveredMarkersAreFoundElsewhere) {
  virt::EyewearFaults faults;
  faults.lost_per_min = 20;
  faults.lost_s = 0.5;
  faults.lost_mm = 30;
  MarkerCapture capture(faults, kPlaces, Random(1));
  int lost = 0;
  for (int i = 0; i < 3000; ++i)
    if (capture.capture(0.1 * i, truth()) != truth()) ++lost;
  EXPECT_NEAR(lost / 3000.0, 1.0 / 7, 0.05);
}

// What the cleaning of recordings makes of the published study's capture, on a head that moves:
// docs/method/markers.md.
TEST(MarkerCapture, ItsMistakesAreFoundAndNoOthers) {
  const auto rig = sensor::read_rig(project_path("rigs/eyewear.toml"));
  const auto set = builtin_face::read_markers(project_path("rigs/markers.toml"));
  ASSERT_TRUE(rig && set);
  const auto faults = virt::parse_eyewear_faults(rig->faults_toml, "rig");
  const auto placed = builtin_face::PlacedMarkers::place(builtin_face::make_builtin(), *set);
  ASSERT_TRUE(faults && placed);
  virt::EyewearFaults exact_faults = *faults;  // The same mistakes without the jitter: what was done to whom.
  exact_faults.marker_jitter_mm = 0;
  performer::Script script;
  for (const performer::Block block : {performer::Block::expressions, performer::Block::reading})
    for (performer::Segment& segment : performer::default_script(block, 60).segments)
      script.segments.push_back(std::move(segment));
  Random person(2);
  const face::MotionCurve curve(performer::perform(script, performer::draw_style(person), Random(3)));

  constexpr double kRateHz = 100;
  MarkerCapture capture(*faults, placed->neutral_m(), Random(4));
  MarkerCapture exact(exact_faults, placed->neutral_m(), Random(4));
  mocap::MatchedTrack seen;
  for (const builtin_face::Marker& marker : set->markers) seen.face.markers.push_back(marker.name);
  std::vector<Eigen::VectorXd> truth;
  std::vector<bool> mistaken;
  for (double t = 0; t < curve.duration_s(); t += 1 / kRateHz) {
    truth.push_back(placed->at(curve.at(t).weights));
    const Eigen::VectorXd noisy = capture.capture(t, truth.back());
    const Eigen::VectorXd wrong = exact.capture(t, truth.back()) - truth.back();
    Eigen::Isometry3d head = Eigen::Isometry3d::Identity();
    head.linear() = (Eigen::AngleAxisd(0.35 * std::sin(1.1 * t), Vec3::UnitY()) *
                     Eigen::AngleAxisd(0.2 * std::sin(0.7 * t), Vec3::UnitX()))
                        .toRotationMatrix();
    head.translation() = Vec3(1 + 0.05 * std::sin(t), 1.2, 0.3);
    seen.face.time_s.push_back(t);
    for (Eigen::Index i = 0; i < noisy.size(); i += 3) {
      seen.face.position_m.emplace_back((head * Vec3(noisy.segment<3>(i))).cast<float>());
      mistaken.push_back(!wrong.segment<3>(i).isZero(0));
    }
  }
  const auto clean = mocap::clean_markers(seen, *placed);
  ASSERT_TRUE(clean) << clean.error().message();
  EXPECT_GT(clean->report.swaps, 2u);
  EXPECT_EQ(clean->report.not_mended, 0u);
  EXPECT_EQ(clean->report.without_head, 0u);
  const std::size_t mistakes = static_cast<std::size_t>(std::ranges::count(mistaken, true));
  EXPECT_GT(mistakes, 500u);
  EXPECT_LE(clean->report.mended + clean->report.strayed, mistakes);
  double squares = 0, worst_m = 0;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < mistaken.size(); ++i) {
    const Vec3f& position = clean->track.position_m[i];
    if (!mocap::is_seen(position)) continue;
    const auto count = set->markers.size();
    const Vec3 at = truth[i / count].segment<3>(3 * static_cast<Eigen::Index>(i % count));
    const double off_m = (position.cast<double>() - at).norm();
    worst_m = std::max(worst_m, off_m);
    squares += off_m * off_m;
    ++kept;
  }
  EXPECT_GT(kept, mistaken.size() * 95 / 100);
  // Of mistakes nothing is left; what the expressions do to the head's pose and the cameras' jitter are.
  EXPECT_LT(std::sqrt(squares / static_cast<double>(kept)), 0.0012);
  EXPECT_LT(worst_m, 0.008);
}

}  // namespace
}  // namespace mien::lab::marker_capture_test
