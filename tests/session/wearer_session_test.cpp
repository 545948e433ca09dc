#include <gtest/gtest.h>

#include "mien/face/anchors.h"
#include "mien/session/session.h"
#include "tests/session/session_run.h"

// A calibration that learns its wearer, from packets to a version that can be put in force again.
namespace mien::session::wearer_session_test {
namespace {

using face::kShapeCount;
using face::shape;
using test::Played;

const std::string kCalibrate = R"({"command": "calibrate", "kind": "wearer"})";
constexpr std::size_t kChinsJaw = 0 * kShapeCount, kCheeksSmile = 3 * kShapeCount;

/// Two shapes by a skin that can be learnt; the standard one turns as far again as the wearer's.
class LearntShapes final : public tracker::FrameModel {
 public:
  LearntShapes() {
    file_.features.sensors = {"mentalis", "buccinator_L"};
    file_.shapes.assign(face::kShapeNames.begin(), face::kShapeNames.end());
    file_.skin.emplace();
    file_.skin->standard.assign(6 * kShapeCount, 0);
    file_.skin->standard[kChinsJaw + shape("jawOpen")] = 0.6F;
    file_.skin->standard[kCheeksSmile + shape("mouthSmile_L")] = 1.0F;
    slopes_ = file_.skin->standard;
  }
  void step(const model::FeatureFrame& features, face::OutputFrame& out) override {
    plain_.step(features, out);
    out.weights[shape("jawOpen")] *= 0.3F / slopes_[kChinsJaw + shape("jawOpen")];
    out.weights[shape("mouthSmile_L")] *= 0.5F / slopes_[kCheeksSmile + shape("mouthSmile_L")];
  }
  void reset() override {}
  [[nodiscard]] const model::ModelFile* personal() const override { return &file_; }
  void use_wearer(const std::vector<float>& slopes) override {
    slopes_ = slopes.empty() ? file_.skin->standard : slopes;
  }

 private:
  model::ModelFile file_;
  std::vector<float> slopes_;
  test::TwoShapes plain_;
};

std::unique_ptr<Session> session() {
  const sensor::Rig rig = virt::test::three_sensors();
  Session::Parts parts;
  parts.rig = rig;
  parts.trackers.push_back(std::make_unique<imu::ImuTracker>(rig, std::make_unique<LearntShapes>()));
  parts.protocols.push_back(std::make_unique<imu::NodeProtocol>(imu::NodeProtocol::create().value()));
  return Session::create(std::move(parts)).value();
}

/// Somebody who does what the session asks for, a tenth of a second late, and then talks.
virt::VirtualSession performed(const performer::PrologueNeeds& needs = {}) {
  const performer::PrologueMotion motion = performer::with_prologue(
      virt::test::talking(15 * 60), performer::PrologueKind::guided, Random(3), needs);
  virt::DeviceFaults faults = virt::test::mild_faults();
  faults.packet_loss = 0;
  return virt::play_devices(motion, virt::test::three_sites(), virt::test::three_sensors(), faults,
                            Random(11))
      .value();
}

/// How far the jaw is off in the last ten seconds, RMS.
double jaw_error(const Played& run, const virt::VirtualSession& performance) {
  double square = 0, count = 0;
  for (const Played::Frame& f : run.frames) {
    if (f.tick.frame < run.frames.back().tick.frame - std::chrono::seconds(10)) continue;
    const auto truth = std::ranges::find(performance.truth, f.tick.frame, &take::TruthFrame::time);
    if (truth == performance.truth.end()) continue;
    square += std::pow(f.frame.weights[shape("jawOpen")] - truth->weights[shape("jawOpen")], 2);
    ++count;
  }
  return std::sqrt(square / count);
}

TEST(WearerSession, LearnsTheWearerAndCanGoBack) {
  const virt::VirtualSession performance = performed();
  const auto one = session(), other = session(), standard = session();
  const Played run = test::run(*one, performance.entries, {{0, kCalibrate}});
  test::expect_sound(run);
  ASSERT_FALSE(one->versions().empty());
  const CalibrationVersion& made = one->versions().back();
  EXPECT_EQ(made.origin, "guided");
  const auto score = std::ranges::find(made.scores, "wearer", &sensor::Score::name);
  ASSERT_NE(score, made.scores.end());
  EXPECT_TRUE(score->pass) << score->sentence;
  EXPECT_GT(score->value, 0) << score->sentence;

  const Played again = test::run(*other, performance.entries, {{0, kCalibrate}});
  EXPECT_EQ(run.hash, again.hash) << "the same bits";

  EXPECT_EQ(run.count("nod"), 1u);
  EXPECT_EQ(run.count("prompt"), face::anchors().size() + face::range_of_motion().size())
      << "so that mien personalise can learn from the take too";

  const Played without = test::run(*standard, performance.entries);
  const double learnt = jaw_error(run, performance), unlearnt = jaw_error(without, performance);
  std::cout << "jawOpen off by " << learnt << " RMS, " << unlearnt << " on the standard skin\n";
  EXPECT_LT(learnt, 0.8 * unlearnt);

  // Another session of the same wearer: what was learnt comes with the calibration.
  const auto later = session();
  const std::string restore = write_command(RestoreCalibration{made.json});
  const Played restored = test::run(*later, performance.entries, {{100, restore}});
  EXPECT_LT(jaw_error(restored, performance), 0.8 * unlearnt);
}

TEST(WearerSession, CancelledItLeavesEverythingAsItWas) {
  const virt::VirtualSession performance = performed();
  const std::string cancel = R"({"command": "cancel_calibration"})";
  // While it holds still, makes faces, is being learnt, and in the half second in which what was learnt is
  // shown: 13.5 s of steps, 86.4 s of expressions, 6.5 s.
  for (const double at_s : {4.0, 40.0, 103.0, 106.3}) {
    const auto one = session();
    const Played run = test::run(*one, performance.entries, {{0, kCalibrate}, {at_s, cancel}});
    for (const CalibrationVersion& version : one->versions()) {
      EXPECT_EQ(version.origin, "self") << at_s;
      EXPECT_EQ(version.json.find("\"wearer\""), std::string::npos) << at_s;
    }
    EXPECT_EQ(run.count("prompt"), 0u) << at_s;
    EXPECT_EQ(run.count("calibration_failed"), 1u) << at_s;
  }
}

TEST(WearerSession, IsRefusedWhereNothingLearnsAWearer) {
  const auto plain = test::session();
  const auto refused = plain->command(HostTime{}, kCalibrate);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::unsupported);
}

TEST(WearerSession, ACalibrationOfAnotherModelsWearerKeepsTheRest) {
  const virt::VirtualSession performance = performed();
  const auto one = session();
  const Played run = test::run(*one, performance.entries, {{0, kCalibrate}});
  ASSERT_FALSE(one->versions().empty());
  const auto plain = test::session();  // Its model knows no skin.
  const Played restored = test::run(*plain, performance.entries,
                                    {{100, write_command(RestoreCalibration{one->versions().back().json})}});
  ASSERT_FALSE(plain->versions().empty());
  const CalibrationVersion& version = plain->versions().back();
  EXPECT_EQ(version.origin, "restored");
  const auto score = std::ranges::find(version.scores, "wearer", &sensor::Score::name);
  ASSERT_NE(score, version.scores.end());
  EXPECT_FALSE(score->pass);
}

TEST(WearerSession, EndsAtOnceWhenItsStepsMadeNoCalibration) {
  const auto one = session();
  const Played run =
      test::run(*one, performed({.neutral_s = 30, .gestures = false}).entries, {{0, kCalibrate}});
  EXPECT_EQ(run.report.calibration.state, "failed");
  const auto failed = std::ranges::find(run.events, "calibration_failed", &take::Event::kind);
  ASSERT_NE(failed, run.events.end());
  EXPECT_LT(to_seconds(failed->begin - run.frames.front().tick.frame), 15) << "before the first expression";
}

}  // namespace
}  // namespace mien::session::wearer_session_test
