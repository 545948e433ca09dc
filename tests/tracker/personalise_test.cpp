#include "mien/tracker/personalise.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>

#include "mien/core/random.h"
#include "mien/core/rotation.h"

namespace mien::tracker {
namespace {

constexpr std::size_t kSensors = 4;
constexpr auto kShapes = static_cast<Eigen::Index>(face::kShapeCount);
const std::vector<std::string> kNames = {"a", "b", "c", "d"};
constexpr double kPrompt_s = 2;
constexpr std::size_t kAsked = 15;  // Shapes, each of them twice.

/// Slopes of which each shape turns two sensors.
Eigen::MatrixXd draw_slopes(Random& random) {
  Eigen::MatrixXd slopes = Eigen::MatrixXd::Zero(3 * kSensors, kShapes);
  for (Eigen::Index k = 0; k < kShapes; ++k)
    for (int i = 0; i < 2; ++i) {
      const auto s = static_cast<Eigen::Index>(random.below(kSensors));
      for (Eigen::Index axis = 0; axis < 3; ++axis) slopes(3 * s + axis, k) = 0.25 * random.normal();
    }
  return slopes;
}

std::vector<float> row_major(const Eigen::MatrixXd& m) {
  std::vector<float> out;
  for (Eigen::Index row = 0; row < m.rows(); ++row)
    for (Eigen::Index k = 0; k < m.cols(); ++k) out.push_back(static_cast<float>(m(row, k)));
  return out;
}

/// A wearer whose skin differs from the standard, asked for fifteen shapes, one after the other, and again.
struct Minute {
  Eigen::MatrixXd standard, wearer;
  std::vector<PromptedExpression> prompts;
  std::vector<model::FeatureFrame> features;

  explicit Minute(std::uint64_t seed, double spread = 0.35) {
    Random random(seed);
    standard = draw_slopes(random);
    wearer = standard;
    for (double& slope : wearer.reshaped()) slope *= 1 + spread * random.normal();
    for (std::size_t p = 0; p < 30; ++p) {
      PromptedExpression& prompt = prompts.emplace_back();
      prompt.begin = DeviceTime(from_seconds(1 + kPrompt_s * static_cast<double>(p)));
      prompt.end = prompt.begin + from_seconds(kPrompt_s);
      prompt.target[p % kAsked] = 1;
      const double gain = random.uniform(0.7, 1.1), late_s = random.uniform(0.2, 0.5);
      for (int f = 0; f < 120; ++f) {
        const double t = f / 60.0 - late_s;
        const double reached = std::clamp(std::min(t, 1.3 - t) / 0.4, 0.0, 1.0);
        model::FeatureFrame& frame = features.emplace_back();
        frame.time = prompt.begin + from_seconds(f / 60.0);
        frame.sensors.resize(kSensors);
        for (std::size_t s = 0; s < kSensors; ++s) {
          Vec3 turn =
              gain * reached *
              wearer.block<3, 1>(3 * static_cast<Eigen::Index>(s), static_cast<Eigen::Index>(p % kAsked));
          for (double& axis : turn) axis += random.normal(0, 0.01);
          const Quat q = canonical(exp_rotation(turn));
          frame.sensors[s].rotation = {static_cast<float>(q.w()), static_cast<float>(q.x()),
                                       static_cast<float>(q.y()), static_cast<float>(q.z())};
          frame.sensors[s].has_rotation = true;
        }
      }
    }
  }

  [[nodiscard]] model::ModelFile model() const {
    model::ModelFile file;
    file.features.sensors = kNames;
    file.shapes.assign(face::kShapeNames.begin(), face::kShapeNames.end());
    file.skin = model::Skin{.standard = row_major(standard),
                            .covariance = row_major(0.02 * Eigen::MatrixXd::Identity(kShapes, kShapes)),
                            .wearer = {}};
    return file;
  }
  /// How far slopes of the prompted shapes are from the wearer's, over how far the standard's are.
  [[nodiscard]] double left(const std::vector<float>& slopes) const {
    double is = 0, was = 0;
    for (Eigen::Index row = 0; row < wearer.rows(); ++row)
      for (Eigen::Index k = 0; k < static_cast<Eigen::Index>(kAsked); ++k) {
        is += std::pow(slopes[static_cast<std::size_t>(row * kShapes + k)] - wearer(row, k), 2);
        was += std::pow(standard(row, k) - wearer(row, k), 2);
      }
    return std::sqrt(is / was);
  }
};

TEST(Personalise, LearnsTheWearersSkin) {
  const Minute minute(1);
  model::ModelFile file = minute.model();
  const auto learnt = personalise(minute.features, minute.prompts, kNames, file);
  ASSERT_TRUE(learnt) << learnt.error().message();
  EXPECT_TRUE(learnt->taken);
  EXPECT_EQ(learnt->prompts, 30u);
  EXPECT_LT(learnt->surprise_after, learnt->surprise_before);
  EXPECT_LT(minute.left(file.skin->wearer), 0.8) << "how strongly it was done is not known";
}

TEST(Personalise, FindsSensorsByNameAndDoesWithoutTheMissing) {
  Minute minute(2);
  model::ModelFile whole = minute.model(), partly = minute.model();
  ASSERT_TRUE(personalise(minute.features, minute.prompts, kNames, whole));
  // Another order, and one sensor is away for the first half.
  std::vector<std::string> names = kNames;
  std::ranges::reverse(names);
  for (std::size_t f = 0; f < minute.features.size(); ++f) {
    std::ranges::reverse(minute.features[f].sensors);
    if (f < minute.features.size() / 2) minute.features[f].sensors[0].has_rotation = false;
  }
  ASSERT_TRUE(personalise(minute.features, minute.prompts, names, partly));
  EXPECT_LT(minute.left(partly.skin->wearer), 0.9);
  EXPECT_LT(minute.left(whole.skin->wearer), minute.left(partly.skin->wearer));
}

TEST(Personalise, KeepsTheModelWhenNothingIsForetoldBetter) {
  // The first time each shape is asked for somebody else answers: what is learnt of them is wrong of the
  // wearer, who is the standard.
  const Minute other(5, 1.5);
  Minute minute(3, 0);
  model::ModelFile file = minute.model();
  const std::size_t half = minute.features.size() / 2;
  for (std::size_t f = half; f < minute.features.size(); ++f) minute.features[f] = other.features[f];
  // Held out are prompts of the first half, learnt from mostly those of the second.
  const auto learnt = personalise(minute.features, minute.prompts, kNames, file);
  ASSERT_TRUE(learnt) << learnt.error().message();
  EXPECT_FALSE(learnt->taken);
  EXPECT_GT(learnt->surprise_after, learnt->surprise_before);
  EXPECT_TRUE(file.skin->wearer.empty());
}

TEST(Personalise, AnswersThatAreHeldUntilTheNextPromptAreUnderstood) {
  Minute minute(6);
  for (std::size_t p = 0; p < minute.prompts.size(); ++p) {
    minute.prompts[p].held = true;
    // Once it is reached it is held.
    for (std::size_t f = 120 * p + 70; f < 120 * (p + 1); ++f)
      minute.features[f].sensors = minute.features[120 * p + 69].sensors;
  }
  model::ModelFile held = minute.model();
  ASSERT_TRUE(personalise(minute.features, minute.prompts, kNames, held).value().taken);
  EXPECT_LT(minute.left(held.skin->wearer), 0.8);
}

TEST(Personalise, SaysWhatItMisses) {
  Minute minute(1);
  model::ModelFile file = minute.model();
  auto refused = personalise(minute.features, std::span(minute.prompts).first(5), kNames, file);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::not_found);
  refused = personalise(minute.features, std::span(minute.prompts).first(kAsked), kNames, file);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::not_found) << "nothing twice";
  refused = personalise(minute.features, minute.prompts, {"x", "y", "z", "w"}, file);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::mismatch);
  std::swap(file.shapes[3], file.shapes[4]);
  refused = personalise(minute.features, minute.prompts, kNames, file);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::mismatch) << "shapes in another order";
  file.skin.reset();
  refused = personalise(minute.features, minute.prompts, kNames, file);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::unsupported);
}

}  // namespace
}  // namespace mien::tracker
