#include "mien/face/weight_solver.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "mien/builtin_face/builtin_face.h"
#include "mien/core/random.h"
#include "mien/core/time.h"

namespace mien::face::weight_solver_test {
namespace {

/// The built-in face's landmarks as points: 68 of them, on lids, brows, nose, lips and jaw.
struct Points {
  Eigen::VectorXd neutral_m = Eigen::VectorXd::Zero(3 * 68);
  Eigen::MatrixXd shapes_m = Eigen::MatrixXd::Zero(3 * 68, static_cast<Eigen::Index>(kShapeCount));

  Points() {
    const Face face = builtin_face::make_builtin({});
    std::vector<Vec3f> moved(face.neutral_m.size());
    for (std::size_t k = 0; k < kShapeCount; ++k) {
      BlendshapeWeights one;
      one[k] = 1;
      evaluate(face, one, 0, moved);
      for (std::size_t i = 0; i < 68; ++i) {
        const auto at = static_cast<Eigen::Index>(3 * i);
        const std::uint32_t v = face.landmarks[i];
        neutral_m.segment<3>(at) = face.neutral_m[v].cast<double>();
        shapes_m.col(static_cast<Eigen::Index>(k)).segment<3>(at) =
            (moved[v] - face.neutral_m[v]).cast<double>();
      }
    }
  }
  [[nodiscard]] Eigen::VectorXd at(const BlendshapeWeights& weights) const {
    Eigen::VectorXd points = neutral_m;
    for (std::size_t k = 0; k < kShapeCount; ++k)
      points += static_cast<double>(weights[k]) * shapes_m.col(static_cast<Eigen::Index>(k));
    return points;
  }
  /// RMS distance of the points at two sets of weights, mm.
  [[nodiscard]] double apart_mm(const BlendshapeWeights& a, const BlendshapeWeights& b) const {
    return 1000 * (at(a) - at(b)).norm() / std::sqrt(68.0);
  }
};

const Points& points() {
  static const Points made;
  return made;
}

WeightSolver solver(const WeightSolverSettings& settings = {}) {
  return WeightSolver::create(points().neutral_m, points().shapes_m, natural_constraints(), settings).value();
}

BlendshapeWeights speaking(double t) {
  BlendshapeWeights w;
  const auto swing = [&](double hz, double phase) {
    return static_cast<float>(0.5 + 0.5 * std::sin(6.28 * hz * t + phase));
  };
  w[shape("jawOpen")] = 0.6F * swing(1.5, 0);
  w[shape("mouthSmile_L")] = 0.7F * swing(0.3, 1);
  w[shape("mouthSmile_R")] = 0.5F * swing(0.3, 1);
  w[shape("browInnerUp_L")] = w[shape("browInnerUp_R")] = 0.8F * swing(0.5, 2);
  w[shape("eyeBlink_L")] = w[shape("eyeBlink_R")] = swing(0.4, 4) > 0.95F ? 1.0F : 0.0F;
  return w;
}

TEST(WeightSolver, FindsTheFaceThatMovedThePoints) {
  WeightSolver solver = weight_solver_test::solver();
  double worst_mm = 0, error = 0;
  int frames = 0;
  for (int i = 0; i < 300; ++i) {
    const BlendshapeWeights truth = speaking(i / 60.0);
    BlendshapeWeights found;
    solver.solve(points().at(truth), {}, 1 / 60.0, found);
    if (i < 10) continue;
    worst_mm = std::max(worst_mm, points().apart_mm(truth, found));
    error += std::abs(truth[shape("jawOpen")] - found[shape("jawOpen")]);
    ++frames;
  }
  EXPECT_LT(worst_mm, 0.7);
  EXPECT_LT(error / frames, 0.05);
}

TEST(WeightSolver, KeepsBoundsAndTheRulesOfTheFaceWhateverItIsGiven) {
  WeightSolver solver = weight_solver_test::solver();
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    Eigen::VectorXd wild = points().neutral_m;
    for (double& x : wild) x += random.normal(0, 0.02);
    BlendshapeWeights w;
    solver.solve(wild, {}, 1 / 60.0, w);
    for (const float x : w.values) ASSERT_TRUE(x >= 0 && x <= 1);
    ASSERT_LE(w[shape("mouthClose")], w[shape("jawOpen")]);
  }
}

TEST(WeightSolver, AnExclusivePairIsNotBoth) {
  // Both jaws at once: a face that no jaw makes.
  BlendshapeWeights both;
  both[shape("mouthSmile_L")] = both[shape("mouthFrown_L")] = 0.6F;
  BlendshapeWeights with, without;
  solver().solve(points().at(both), {}, 10, with);
  WeightSolverSettings free;
  free.exclusive = 0;
  solver(free).solve(points().at(both), {}, 10, without);
  const auto lesser = [](const BlendshapeWeights& w) {
    return std::min(w[shape("mouthSmile_L")], w[shape("mouthFrown_L")]);
  };
  EXPECT_GT(lesser(without), 0.1F);
  EXPECT_LT(lesser(with), 0.3F * lesser(without));
}

TEST(WeightSolver, IsCalmWhereThePointsShake) {
  const auto jitter = [](double smooth) {
    WeightSolverSettings settings;
    settings.smooth = smooth;
    WeightSolver solver = weight_solver_test::solver(settings);
    Random random(5);
    BlendshapeWeights truth, last;
    truth[shape("jawOpen")] = 0.3F;
    double sum = 0;
    for (int i = 0; i < 200; ++i) {
      Eigen::VectorXd shaking = points().at(truth);
      for (double& x : shaking) x += random.normal(0, 0.0005);
      BlendshapeWeights w;
      solver.solve(shaking, {}, 1 / 60.0, w);
      for (std::size_t k = 0; k < kShapeCount && i > 20; ++k) sum += std::abs(w[k] - last[k]);
      last = w;
    }
    return sum;
  };
  EXPECT_LT(jitter(40), 0.5 * jitter(0));
}

TEST(WeightSolver, LeavesOutWhatIsNotTrustedOrNotThere) {
  const BlendshapeWeights truth = speaking(0.2);
  Eigen::VectorXd seen = points().at(truth);
  std::vector<double> trust(68, 1.0);
  for (const std::size_t i : {3U, 40U, 55U}) {
    trust[i] = 0;
    seen.segment<3>(static_cast<Eigen::Index>(3 * i)).setConstant(5);
  }
  seen[3 * 60] = std::numeric_limits<double>::quiet_NaN();
  WeightSolver solver = weight_solver_test::solver();
  BlendshapeWeights found;
  for (int i = 0; i < 20; ++i) solver.solve(seen, trust, 1 / 60.0, found);
  EXPECT_LT(points().apart_mm(truth, found), 1.0);
  // And comes back to all of them.
  for (int i = 0; i < 20; ++i) solver.solve(points().at(truth), {}, 1 / 60.0, found);
  EXPECT_LT(points().apart_mm(truth, found), 0.7);
}

WeightSolver solver_with(const std::string& rules, const WeightSolverSettings& settings = {}) {
  return WeightSolver::create(points().neutral_m, points().shapes_m,
                              RigConstraints::parse(rules, "test").value(), settings)
      .value();
}

TEST(WeightSolver, ConditionsAreBoundsThroughChains) {
  WeightSolver solver = solver_with(
      "[[conditional]]\na = \"mouthFunnel\"\nb = \"mouthClose\"\nat_most = [[0, 0.1], [1, 0.6]]\n"
      "[[conditional]]\na = \"mouthClose\"\nb = \"jawOpen\"\nat_most = [[0, 0], [0.5, 0.2], [1, 1]]\n"
      "in = [\"solve\"]\n");
  Random random(3);
  float funnel = 0;
  for (int i = 0; i < 200; ++i) {
    Eigen::VectorXd wild = points().neutral_m;
    for (double& x : wild) x += random.normal(0, 0.02);
    BlendshapeWeights w;
    solver.solve(wild, {}, 1 / 60.0, w);
    const float jaw = w[shape("jawOpen")];
    const float most = jaw < 0.5F ? 0.4F * jaw : 0.2F + 1.6F * (jaw - 0.5F);
    ASSERT_LE(w[shape("mouthClose")], most + 1e-6F);
    ASSERT_LE(w[shape("mouthFunnel")], 0.1F + 0.5F * w[shape("mouthClose")] + 1e-6F);
    funnel = std::max(funnel, w[shape("mouthFunnel")]);
  }
  EXPECT_GT(funnel, 0.05F);
}

TEST(WeightSolver, LeavesOutRulesThatAreNotForIt) {
  BlendshapeWeights both;
  both[shape("mouthSmile_L")] = both[shape("mouthFrown_L")] = 0.6F;
  const std::string pair = "[[exclusive]]\na = \"mouthSmile_L\"\nb = \"mouthFrown_L\"\n";
  BlendshapeWeights none, live, all;
  solver_with("").solve(points().at(both), {}, 10, none);
  solver_with(pair + "in = [\"live\"]\n").solve(points().at(both), {}, 10, live);
  solver_with(pair).solve(points().at(both), {}, 10, all);
  EXPECT_EQ(live, none);
  EXPECT_NE(all, none);
}

TEST(WeightSolver, AGroupIsDrawnTogetherBeyondItsBandAlone) {
  BlendshapeWeights one;
  one[shape("mouthSmile_L")] = 0.8F;
  const auto apart = [&](double within, double cost) {
    BlendshapeWeights found;
    solver_with(fmt::format("[[together]]\nshapes = [\"mouthSmile_L\", \"mouthSmile_R\", \"cheekPuff_L\"]\n"
                            "within = {}\n",
                            within),
                {.together = cost})
        .solve(points().at(one), {}, 10, found);
    return found[shape("mouthSmile_L")] - found[shape("mouthSmile_R")];
  };
  const float free = apart(0, 0);
  EXPECT_GT(free, 0.7F);
  EXPECT_LT(apart(0, 1e4), 0.1F);
  EXPECT_NEAR(apart(0.1, 1e4), 0.2F, 0.06F);
  EXPECT_NEAR(apart(0.5, 1e4), free, 1e-3F);
}

TEST(WeightSolver, IsAPureFunctionOfItsCalls) {
  WeightSolver a = solver(), b = solver();
  BlendshapeWeights x, y;
  for (int i = 0; i < 60; ++i) {
    a.solve(points().at(speaking(i / 60.0)), {}, 1 / 60.0, x);
    b.solve(points().at(speaking(i / 60.0)), {}, 1 / 60.0, y);
    ASSERT_EQ(x, y);
  }
  b.reset();
  a = solver();
  a.solve(points().at(speaking(1)), {}, 1 / 60.0, x);
  b.solve(points().at(speaking(1)), {}, 1 / 60.0, y);
  EXPECT_EQ(x, y);
}

TEST(WeightSolver, RefusesWhatDoesNotFit) {
  const auto made = [](Eigen::VectorXd neutral, Eigen::MatrixXd shapes, WeightSolverSettings settings = {}) {
    return WeightSolver::create(std::move(neutral), std::move(shapes), natural_constraints(), settings)
        .has_value();
  };
  const Eigen::VectorXd neutral = points().neutral_m;
  const Eigen::MatrixXd shapes = points().shapes_m;
  EXPECT_TRUE(made(neutral, shapes));
  EXPECT_FALSE(made(neutral.head(200), shapes));
  EXPECT_FALSE(made(Eigen::VectorXd(), Eigen::MatrixXd()));
  EXPECT_FALSE(made(neutral, shapes.leftCols(52)));
  Eigen::VectorXd nan = neutral;
  nan[4] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(made(nan, shapes));
  WeightSolverSettings below;
  below.rest = -1;
  EXPECT_FALSE(made(neutral, shapes, below));
}

}  // namespace
}  // namespace mien::face::weight_solver_test
