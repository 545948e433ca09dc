// What a headset's tracker learns from targets that its wearer looks at.
#include <gtest/gtest.h>

#include <algorithm>

#include "mien/headset/headset_tracker.h"
#include "tests/headset/worn_headset.h"

namespace mien::headset::tracker_gaze_test {
namespace {

using namespace test;
using tracker::Step;
using Phase = tracker::CalibrationState::Phase;

/// Of an output layer, the rows of the eyes' directions as they were drawn, but small; all others answer what
/// a face at rest does, whatever is seen.
void leave_gaze(std::vector<model::Tensor>& network, float scale) {
  std::vector<float>& weight = network[network.size() - 2].values;
  std::vector<float>& bias = network.back().values;
  const std::size_t inputs = weight.size() / bias.size();
  for (std::size_t row = 0; row < bias.size(); ++row)
    for (float& value : std::span(weight).subspan(row * inputs, inputs))
      value *= row >= kGazeOutput && row < kGazeOutput + 4 ? scale : 0;
  std::ranges::fill(bias, 2.0F);  // Judgements: sure.
  std::array<float, kAnswerOutputs> outputs{};
  encode_answer({}, outputs);
  std::ranges::copy(outputs, bias.begin());
}
/// Networks of which only the eyes' directions follow the pictures.
std::shared_ptr<const HeadsetModel> looking_model() {
  ViewsFile file = small_views_file();
  leave_gaze(file.network, 0.01F);
  return HeadsetModel::create(file).value();
}
std::shared_ptr<const HeadsetModel> looking_model_with_memory() {
  ViewsFile file = small_views_file();
  file.memory = small_memory();
  file.memory->judgements.fill({.offset = 0, .slope = 1});
  leave_gaze(file.network, 0);
  leave_gaze(file.memory->network, 0.1F);
  // It adds nothing but directions.
  std::ranges::fill(std::span(file.memory->network.back().values).first(kAnswerOutputs), 0.0F);
  return HeadsetModel::create(file).value();
}

constexpr int kTarget = 60;  // Frames of a target.

/// Targets whose directions an affine map tells of what the left eye is found
/// at while the cameras see one eighth of the pictures after the other.
class Looks {
 public:
  static constexpr std::size_t kTargets = 5;

  /// A neutral of the first eighth, then nothing asked for: what is found at
  /// the others.
  explicit Looks(const std::shared_ptr<const HeadsetModel>& model) : model_(model) {
    Worn worn = calibrated();
    for (std::size_t t = 0; t < kTargets; ++t) {
      Eigen::Vector2f sum = Eigen::Vector2f::Zero();
      worn.first_picture = first(t);
      for (int i = 0; i < kTarget; ++i) {
        worn.step();
        if (i >= kSettles) sum += worn.frame.eyes_rad[0];
      }
      found_[t] = sum / static_cast<float>(kTarget - kSettles);
      known_[t] = 1.5F * found_[t] + Eigen::Vector2f(0.125F, -0.0625F);
    }
  }
  [[nodiscard]] Worn calibrated() const {
    Worn worn(model_);
    worn.pictures = 8;
    worn.run(0.2);
    worn.tracker->guide(Step::neutral, worn.now(), worn.now() + HeadsetTracker::kNeutral);
    worn.run(3 + 1 / 60.0);
    return worn;
  }
  /// From the frame that comes next on.
  void ask(Worn& worn) const {
    for (std::size_t t = 0; t < kTargets; ++t) {
      const DeviceTime shown = worn.now() + frame_offset(static_cast<std::int64_t>(t) * kTarget);
      const face::GazeTarget target{.name = "there", .prompt = {}, .direction_rad = known_[t]};
      worn.tracker->guide_gaze(target, shown + frame_offset(kSettles), shown + frame_offset(kTarget));
    }
  }
  /// Looks at all of them; over at the last frame.
  void look(Worn& worn) const {
    for (std::size_t t = 0; t < kTargets; ++t) {
      worn.first_picture = first(t);
      worn.run(kTarget / 60.0);
    }
    worn.step();
  }
  [[nodiscard]] Eigen::Vector2f known(std::size_t t) const { return known_[t]; }
  [[nodiscard]] Eigen::Vector2f found(std::size_t t) const { return found_[t]; }
  static int first(std::size_t t) { return static_cast<int>(8 * ((t + 1) % kTargets)); }

 private:
  static constexpr int kSettles = 12;
  std::shared_ptr<const HeadsetModel> model_;
  std::array<Eigen::Vector2f, kTargets> found_, known_;
};

std::vector<std::string> names(const std::vector<sensor::Score>& scores) {
  std::vector<std::string> out;
  for (const sensor::Score& score : scores) out.push_back(score.name);
  return out;
}

TEST(TrackerGaze, TargetsTeachItWhereItsWearerLooks) {
  for (const auto& model : {looking_model(), looking_model_with_memory()}) {
    const Looks looks(model);
    Worn worn = looks.calibrated(), plain = looks.calibrated();
    EXPECT_TRUE(worn.tracker->guidance().learns_gaze);
    worn.events.clear();
    looks.ask(worn);
    EXPECT_EQ(worn.tracker->calibration_state().phase, Phase::guided);
    looks.look(worn);
    looks.look(plain);
    ASSERT_EQ(worn.events.size(), 1U);
    EXPECT_EQ(worn.events[0].kind, tracker::CalibrationEvent::Kind::calibrated);
    EXPECT_EQ(worn.tracker->calibration_state().phase, Phase::done);
    const auto calibration = parse_wearer_calibration(worn.tracker->calibration(), "calibration");
    ASSERT_TRUE(calibration) << calibration.error().message();
    ASSERT_TRUE(calibration->gaze);
    EXPECT_NE(calibration->gaze->eyes[0], GazeMap::Affine(GazeMap::Affine::Identity()));
    const auto scored = names(worn.tracker->scores());
    EXPECT_NE(std::ranges::find(scored, "gaze targets"), scored.end());
    EXPECT_NE(std::ranges::find(scored, "gaze left"), scored.end());

    // What is found, less the neutral's, through the map.
    double before = 0, after = 0;
    for (std::size_t t = 0; t < Looks::kTargets; ++t) {
      worn.first_picture = plain.first_picture = Looks::first(t);
      for (int i = 0; i < kTarget; ++i) {
        worn.step();
        plain.step();
        for (std::size_t e = 0; e < 2; ++e)
          ASSERT_EQ(worn.frame.eyes_rad[e], calibration->gaze->apply(e, plain.frame.eyes_rad[e]));
        ASSERT_EQ(worn.frame.weights, plain.frame.weights);
      }
      before += static_cast<double>((plain.frame.eyes_rad[0] - looks.known(t)).norm());
      after += static_cast<double>((worn.frame.eyes_rad[0] - looks.known(t)).norm());
    }
    EXPECT_LT(after, before / 2);

    // Another session of the same wearer, or the calibration from before
    // targets were asked for.
    Worn next(model);
    ASSERT_TRUE(next.tracker->restore(worn.tracker->calibration()));
    EXPECT_EQ(next.tracker->calibration(), worn.tracker->calibration());
    ASSERT_TRUE(next.tracker->restore(plain.tracker->calibration()));
    EXPECT_EQ(next.tracker->calibration(), plain.tracker->calibration());
  }
}

TEST(TrackerGaze, ALaterNeutralKeepsTheGainsThatTargetsTaught) {
  const Looks looks(looking_model());
  Worn worn = looks.calibrated();
  looks.ask(worn);
  looks.look(worn);
  const auto taught = parse_wearer_calibration(worn.tracker->calibration(), "calibration");
  ASSERT_TRUE(taught && taught->gaze);
  EXPECT_GT(taught->gaze->eyes[0].col(2).norm(), 0.01F);
  worn.tracker->guide(Step::neutral, worn.now(), worn.now() + HeadsetTracker::kNeutral);
  worn.run(3.1);
  const auto later = parse_wearer_calibration(worn.tracker->calibration(), "calibration");
  ASSERT_TRUE(later && later->gaze);
  EXPECT_EQ(*later->gaze, taught->gaze->gains()) << "its offset was of the neutral before";
}

TEST(TrackerGaze, ATargetThatIsNotLookedAtIsLeftOutAndTooFewChangeNothing) {
  const Looks looks(looking_model());
  const auto lost_at = [&](std::size_t first_lost) {
    Worn worn = looks.calibrated();
    looks.ask(worn);
    for (std::size_t t = 0; t < Looks::kTargets; ++t) {
      worn.sends.fill(t < first_lost);
      worn.first_picture = Looks::first(t);
      worn.run(kTarget / 60.0);
    }
    worn.step();
    return worn;
  };
  const auto score = [](const Worn& worn) {
    for (const sensor::Score& one : worn.tracker->scores())
      if (one.name == "gaze targets") return one;
    return sensor::Score{};
  };
  const Worn four = lost_at(4), three = lost_at(3);
  EXPECT_NEAR(score(four).value, 0.8, 1e-9);
  EXPECT_FALSE(score(four).pass);
  EXPECT_TRUE(parse_wearer_calibration(four.tracker->calibration(), "calibration")->gaze);
  EXPECT_NEAR(score(three).value, 0.6, 1e-9);
  EXPECT_FALSE(parse_wearer_calibration(three.tracker->calibration(), "calibration")->gaze);
  EXPECT_TRUE(three.tracker->calibration_state().hint.empty()) << "its neutral is in force";
}

TEST(TrackerGaze, LidsThatAreShutShowNoDirection) {
  Answer shut = telling_answer();
  shut.openness = {0.05F, 0.05F};
  for (const bool closed : {true, false}) {
    Worn worn(HeadsetModel::create(constant_file(closed ? shut : telling_answer())).value());
    worn.run(0.2);
    worn.tracker->guide(Step::neutral, worn.now(), worn.now() + HeadsetTracker::kNeutral);
    for (const face::GazeTarget& target : face::gaze_targets())
      worn.tracker->guide_gaze(target, worn.now() + HeadsetTracker::kNeutral,
                               worn.now() + HeadsetTracker::kNeutral + std::chrono::seconds(1));
    worn.run(4.1);
    const auto calibration = parse_wearer_calibration(worn.tracker->calibration(), "calibration");
    ASSERT_TRUE(calibration) << calibration.error().message();
    EXPECT_EQ(calibration->gaze.has_value(), !closed);
  }
}

TEST(TrackerGaze, TargetsThatAreCancelledOrComeWithoutANeutralTeachNothing) {
  const Looks looks(looking_model());
  Worn worn = looks.calibrated();
  const std::string before = worn.tracker->calibration();
  looks.ask(worn);
  worn.run(2);
  worn.tracker->cancel_guidance();
  EXPECT_EQ(worn.tracker->calibration_state().phase, Phase::done);
  worn.run(4);
  EXPECT_EQ(worn.tracker->calibration(), before);

  Worn bare(looking_model());
  bare.pictures = 8;
  bare.run(0.2);
  looks.ask(bare);
  looks.look(bare);
  ASSERT_EQ(bare.events.size(), 1U);
  EXPECT_EQ(bare.events[0].kind, tracker::CalibrationEvent::Kind::withdrawn);
  EXPECT_TRUE(bare.tracker->calibration().empty());
  EXPECT_TRUE(bare.tracker->calibration_state().hint.starts_with("nothing is known of the face at rest"));

  // Another camera at an eye: what was gathered of the one before is none.
  Worn changed = looks.calibrated();
  looks.ask(changed);
  changed.run(3);
  changed.tracker->forget(0);
  changed.run(3);
  EXPECT_TRUE(changed.tracker->calibration().empty());
}

TEST(TrackerGaze, CamerasThatSeeNoEyeLearnNoGaze) {
  sensor::Rig rig = headset_rig();
  std::erase_if(rig.sensors, [](const sensor::Mount& sensor) { return sensor.site == "eye"; });
  rig.reference = rig.sensors.front().name;
  const auto tracker = HeadsetTracker::create(rig, small_model());
  ASSERT_TRUE(tracker) << tracker.error().message();
  EXPECT_FALSE((*tracker)->guidance().learns_gaze);
}

}  // namespace
}  // namespace mien::headset::tracker_gaze_test
