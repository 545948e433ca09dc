// Takes of sensors that only their tracker knows: smart eyewear.
#include <gtest/gtest.h>

#include "mien/builtin_face/builtin_face.h"
#include "mien/eyewear/eyewear_protocol.h"
#include "mien/eyewear/eyewear_tracker.h"
#include "mien/solve/solve.h"
#include "mien/virtual/perform_take.h"
#include "tests/eyewear/glasses.h"
#include "tests/project_path.h"
#include "tests/solve/performed_take.h"

namespace mien::solve::solve_tracked_test {
namespace {

const std::size_t kJaw = face::shape("jawOpen");

/// A second of a talking wearer after a short prologue, as mien perform writes it.
const take::Take& worn_take() {
  static const mien::test::Folder folder;
  static const take::Take take = [] {
    virt::PerformRequest request;
    request.rig = project_path("rigs/eyewear.toml");
    request.motion = virt::test::talking(60);
    request.take = folder / "worn.mien";
    request.seed = 5;
    request.software = "mien test";
    const auto done = virt::perform_take(request, no_progress);
    EXPECT_TRUE(done) << (done ? "" : done.error().message());
    return take::Take::open(request.take).value();
  }();
  return take;
}

/// The jaw opens as the hooks' light falls.
std::unique_ptr<tracker::Tracker> tracker_of(const sensor::Rig& rig) {
  const builtin_face::MarkerSet markers = eyewear::test::mouth_markers();
  const auto placed = builtin_face::PlacedMarkers::place(builtin_face::make_builtin(), markers).value();
  face::BlendshapeWeights open;
  open[kJaw] = 1;
  Eigen::MatrixXd gain_m = Eigen::MatrixXd::Zero(placed.at({}).size(), std::ssize(rig.sensors));
  for (std::size_t s = 0; s < rig.sensors.size(); ++s)
    if (rig.sensors[s].site == "lower_jaw")
      gain_m.col(static_cast<Eigen::Index>(s)) = 0.5 * (placed.at(open) - placed.at({}));
  return eyewear::EyewearTracker::create(rig, eyewear::test::marked_mouth(),
                                         std::make_unique<eyewear::test::LinearRegressor>(std::move(gain_m)))
      .value();
}

Result<Solution> solved(const Progress& progress = no_progress) {
  const auto tracker = tracker_of(worn_take().rig());
  return solve_take(worn_take(), *tracker, progress);
}

TEST(SolveTracked, GivesTheSameBitsEachTime) {
  const auto solution = solved();
  ASSERT_TRUE(solution) << solution.error().message();
  EXPECT_EQ(solution->frames.size(), worn_take().ticks()->size());
  EXPECT_TRUE(solution->ridge.empty());
  EXPECT_EQ(solved()->hash, solution->hash);
}

TEST(SolveTracked, PutsTheTakesCalibrationsInForce) {
  const auto versions = worn_take().calibrations().value();
  ASSERT_EQ(versions.size(), 1U);
  EXPECT_EQ(versions[0].modality, "eyewear");
  const Solution solution = solved().value();
  EXPECT_GT(solution.observed, 0.99);
  for (const face::OutputFrame& frame : solution.frames)
    if (frame.time >= versions[0].made) {
      EXPECT_EQ(frame.provenance[kJaw], face::Provenance::measured);
    }
  const auto truth = own_truth(worn_take());
  ASSERT_TRUE(truth) << truth.error().message();
  EXPECT_EQ(with_truth("worn", solution, *truth).model.size(), solution.frames.size());
}

/// One sensor that tells the jaw and no other shape, as a microphone's tracker does; or one that waits to be
/// calibrated.
class JawAlone final : public tracker::Tracker {
 public:
  explicit JawAlone(bool waits) : waits_(waits) {}
  [[nodiscard]] std::string_view modality() const override { return "jaw"; }
  void add(HostTime, const sensor::Sample&) override {}
  void forget(std::uint16_t) override {}
  tracker::TickResult tick(DeviceTime frame, const sensor::TimeLines&, face::OutputFrame& out) override {
    out = {};
    out.time = frame;
    out.provenance.fill(face::Provenance::neutral);
    if (!waits_) out.provenance[kJaw] = face::Provenance::audio;
    return {.sensors_present = 1};
  }
  [[nodiscard]] tracker::CalibrationState calibration_state() const override {
    using Phase = tracker::CalibrationState::Phase;
    return {.phase = waits_ ? Phase::watching : Phase::done};
  }

 private:
  bool waits_;
};

TEST(SolveTracked, SensorsThatNeverTellAWholeFaceAreUsedAllTheSame) {
  JawAlone jaw(false);
  const auto heard = solve_take(worn_take(), jaw, no_progress);
  ASSERT_TRUE(heard) << heard.error().message();
  EXPECT_DOUBLE_EQ(heard->observed, 1.0 / static_cast<double>(worn_take().rig().sensors.size()));
  EXPECT_FALSE(heard->uncalibrated);

  JawAlone waiting(true);
  const auto waited = solve_take(worn_take(), waiting, no_progress);
  ASSERT_TRUE(waited) << waited.error().message();
  EXPECT_EQ(waited->observed, 0) << "what is told before a calibration is no answer";
  EXPECT_TRUE(waited->uncalibrated);
  EXPECT_FALSE(solved()->uncalibrated);
}

TEST(SolveTracked, IsStopped) {
  const auto stopped = solved([](double, std::string_view) { return false; });
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace mien::solve::solve_tracked_test
