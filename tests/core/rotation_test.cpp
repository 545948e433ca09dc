#include "mien/core/rotation.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "mien/core/random.h"

namespace mien::rotation_test {
namespace {

constexpr double kPi = M_PI;

void expect_same_rotation(const Quat& a, const Quat& b, double tolerance_rad) {
  EXPECT_LT(angle_between(a, b), tolerance_rad)
      << a.coeffs().transpose() << " against " << b.coeffs().transpose();
}

TEST(Rotation, ExpTurnsByTheRightHand) {
  const Vec3 turned = exp_rotation({0, 0, kPi / 2}) * Vec3::UnitX();
  EXPECT_LT((turned - Vec3::UnitY()).norm(), 1e-15);
  EXPECT_LT((exp_rotation({kPi / 2, 0, 0}) * Vec3::UnitY() - Vec3::UnitZ()).norm(), 1e-15);
}

TEST(Rotation, LogUndoesExp) {
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 v = random.direction() * random.uniform(0, kPi - 1e-6);
    EXPECT_LT((log_rotation(exp_rotation(v)) - v).norm(), 1e-9);
  }
}

TEST(Rotation, LogUndoesExpWhereItIsTiny) {
  for (const double angle : {0.0, 1e-12, 1e-9, 9.9e-7, 1.01e-6, 1e-5}) {
    const Vec3 v(0, angle, 0);
    EXPECT_NEAR((log_rotation(exp_rotation(v)) - v).norm(), 0, 1e-16 + 1e-10 * angle) << angle;
    EXPECT_NEAR(exp_rotation(v).norm(), 1, 1e-15);
  }
}

TEST(Rotation, LogTakesTheShortWay) {
  EXPECT_NEAR(log_rotation(exp_rotation({0, 1.5 * kPi, 0})).y(), -0.5 * kPi, 1e-12);
  EXPECT_NEAR(log_rotation(exp_rotation({kPi, 0, 0})).norm(), kPi, 1e-12);
  const Quat q = exp_rotation({0.1, 0.2, 0.3});
  Quat other = q;
  other.coeffs() = -q.coeffs();
  EXPECT_LT((log_rotation(q) - log_rotation(other)).norm(), 1e-15);
}

TEST(Rotation, CanonicalKeepsTheRotation) {
  Random random(2);
  for (int i = 0; i < 100; ++i) {
    Quat q = random.rotation();
    const Vec3 before = q * Vec3(1, 2, 3);
    q.coeffs() *= random.chance(0.5) ? -3.0 : 0.5;
    const Quat unit = canonical(q);
    EXPECT_GE(unit.w(), 0);
    EXPECT_NEAR(unit.norm(), 1, 1e-15);
    EXPECT_LT((unit * Vec3(1, 2, 3) - before).norm(), 1e-12);
  }
}

TEST(Rotation, AngleBetween) {
  const Quat a = exp_rotation({0.3, -0.2, 0.9});
  EXPECT_NEAR(angle_between(a, a), 0, 1e-12);
  EXPECT_NEAR(angle_between(a, a * exp_rotation({0, 0.25, 0})), 0.25, 1e-12);
  EXPECT_NEAR(angle_between(a, exp_rotation({0, 0, kPi}) * a), kPi, 1e-7);
}

TEST(Rotation, TwistIsTheTurnAboutTheAxis) {
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    const Vec3 axis = random.direction();
    const double angle = random.uniform(-3, 3);
    // The swing turns about an axis across the twist's.
    const Vec3 across = axis.cross(random.direction()).normalized();
    const Quat swing = exp_rotation(across * random.uniform(-2.5, 2.5));
    expect_same_rotation(twist_about(swing * exp_rotation(angle * axis), axis), exp_rotation(angle * axis),
                         1e-9);
  }
  // A half turn across the axis has no twist that is its own.
  expect_same_rotation(twist_about(exp_rotation({kPi, 0, 0}), Vec3::UnitY()), Quat::Identity(), 1e-6);
}

TEST(Rotation, InterpolationMeetsItsSamplesWithoutSteps) {
  const auto at = [](double t) { return exp_rotation({0.1 * t, 0.2 * std::sin(t), 0.05 * t * t}); };
  const std::array<Quat, 5> q = {at(0), at(0.1), at(0.2), at(0.3), at(0.4)};
  expect_same_rotation(interpolate_rotation(q[0], q[1], q[2], q[3], 0), q[1], 1e-12);
  expect_same_rotation(interpolate_rotation(q[0], q[1], q[2], q[3], 1), q[2], 1e-12);
  expect_same_rotation(interpolate_rotation(q[0], q[1], q[2], q[3], 0.5), at(0.15), 1e-4);
  // The angular velocity just before and just after a sample agree, where slerp's would not.
  const double e = 1e-4;
  const Vec3 before =
      log_rotation(interpolate_rotation(q[0], q[1], q[2], q[3], 1 - e).conjugate() * q[2]) / e;
  const Vec3 after = log_rotation(q[2].conjugate() * interpolate_rotation(q[1], q[2], q[3], q[4], e)) / e;
  EXPECT_LT((before - after).norm(), 0.01 * before.norm());
}

TEST(Rotation, InterpolationOfPointsIsExactOnAParabola) {
  const auto at = [](double t) { return Vec3(t, t * t, 1 - t); };
  EXPECT_LT((interpolate_point(at(-1), at(0), at(1), at(2), 0.3) - at(0.3)).norm(), 1e-12);
}

TEST(Rotation, InterpolationBetweenUnevenSamplesHasNoStepsInItsSpeed) {
  const auto at = [](double t) { return Vec3(t, t * t, 1 - t); };
  EXPECT_LT((interpolate_point(at(-3), at(0), at(1), at(1.4), 0.3, {3, 0.4}) - at(0.3)).norm(), 1e-12);
  // Speed before and after the third of five samples whose intervals are 0.1, 0.5, 0.02 and 0.1 s.
  const auto turn = [](double t) { return exp_rotation({0.1 * t, 0.2 * std::sin(t), 0.05 * t * t}); };
  const std::array<double, 5> t = {0, 0.1, 0.6, 0.62, 0.72};
  const double e = 1e-4;
  const Quat before = interpolate_rotation(turn(t[0]), turn(t[1]), turn(t[2]), turn(t[3]), 1 - e / 0.5,
                                           {.before = 0.1 / 0.5, .after = 0.02 / 0.5});
  const Quat after = interpolate_rotation(turn(t[1]), turn(t[2]), turn(t[3]), turn(t[4]), e / 0.02,
                                          {.before = 0.5 / 0.02, .after = 0.1 / 0.02});
  const Vec3 speed_before = log_rotation(before.conjugate() * turn(t[2])) / e;
  const Vec3 speed_after = log_rotation(turn(t[2]).conjugate() * after) / e;
  EXPECT_LT((speed_before - speed_after).norm(), 0.02 * speed_before.norm());
}

TEST(Rotation, FitFindsTheRotation) {
  Random random(4);
  for (int i = 0; i < 100; ++i) {
    const Quat truth = random.rotation();
    const Vec3 shift = random.direction() * 5;
    std::vector<Vec3> from;
    std::vector<Vec3> to;
    for (int k = 0; k < 10; ++k) {
      from.push_back(random.direction() * random.uniform(0.01, 0.1));
      to.push_back(truth * from.back() + shift);
    }
    expect_same_rotation(fit_rotation(from, to), truth, 1e-9);
  }
}

TEST(Rotation, FitOfAFlatPatchIsNeverAMirror) {
  // Points in a plane, as a patch of skin nearly is: the rotation that mirrors through the plane fits as
  // well.
  Random random(5);
  for (int i = 0; i < 100; ++i) {
    const Quat truth = random.rotation();
    std::vector<Vec3> from;
    std::vector<Vec3> to;
    for (int k = 0; k < 6; ++k) {
      from.push_back(Vec3{random.uniform(-1, 1), random.uniform(-1, 1), 0});
      to.push_back(truth * from.back());
    }
    expect_same_rotation(fit_rotation(from, to), truth, 1e-7);
  }
  // A real mirror image is answered with a rotation all the same.
  const std::vector<Vec3> from = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}};
  const std::vector<Vec3> to = {{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}};
  EXPECT_NEAR(fit_rotation(from, to).toRotationMatrix().determinant(), 1, 1e-12);
}

TEST(Rotation, FitIsTheOneBySingularValues) {
  // Kabsch 1976: the closest rotation by the singular value decomposition, of patches that are flat, mirrored
  // and noisy.
  Random random(7);
  for (int i = 0; i < 300; ++i) {
    const Vec3 widths(1, random.uniform(0.1, 1), i % 3 == 0 ? 0 : random.uniform(0, 1));
    const Vec3 mirrored(i % 5 == 0 ? -1 : 1, 1, 1);
    const Quat turn = i % 2 == 0 ? random.rotation() : exp_rotation(0.3 * random.direction());
    Mat3 covariance = Mat3::Zero();
    for (int k = 0; k < 20; ++k) {
      const Vec3 from = widths.cwiseProduct(random.direction());
      const Vec3 to = turn * mirrored.cwiseProduct(from) + 0.02 * random.direction();
      covariance += from * to.transpose();
    }
    const Eigen::JacobiSVD<Mat3> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Mat3 flip = Mat3::Identity();
    flip(2, 2) = (svd.matrixV() * svd.matrixU().transpose()).determinant() < 0 ? -1 : 1;
    const Quat best(Mat3(svd.matrixV() * flip * svd.matrixU().transpose()));
    expect_same_rotation(fit_rotation(covariance), best, 1e-9);
  }
}

TEST(Rotation, FitOfWhatHasNoOrientationIsARotation) {
  // Points on a line, in one place, and a mirror image of a ball's.
  for (const Mat3& covariance : {Mat3(Vec3(1, 2, 3) * Vec3(0, 1, 0).transpose()), Mat3(Mat3::Zero()),
                                 Mat3(-Mat3::Identity()), Mat3(1e-200 * Mat3::Identity())})
    EXPECT_NEAR(fit_rotation(covariance).toRotationMatrix().determinant(), 1, 1e-12) << covariance;
}

TEST(Rotation, FitIsTheBestOne) {
  Random random(6);
  const Quat truth = random.rotation();
  std::vector<Vec3> from;
  std::vector<Vec3> to;
  for (int k = 0; k < 50; ++k) {
    from.push_back(random.direction());
    to.push_back(truth * from.back() + 0.1 * random.direction());
  }
  Vec3 mean_from = Vec3::Zero();
  Vec3 mean_to = Vec3::Zero();
  for (std::size_t k = 0; k < from.size(); ++k) {
    mean_from += from[k] / 50;
    mean_to += to[k] / 50;
  }
  const auto cost = [&](const Quat& q) {
    double sum = 0;
    for (std::size_t k = 0; k < from.size(); ++k)
      sum += (q * (from[k] - mean_from) - (to[k] - mean_to)).squaredNorm();
    return sum;
  };
  const Quat best = fit_rotation(from, to);
  for (int i = 0; i < 100; ++i) EXPECT_LE(cost(best), cost(best * exp_rotation(random.direction() * 0.01)));
}

}  // namespace
}  // namespace mien::rotation_test
