#include "mien/virtual/eyewear/eyewear_wearer.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "mien/builtin_face/builtin_face.h"
#include "mien/face/surface_point.h"
#include "mien/render/ray_scene.h"

namespace mien::virt {
namespace {

constexpr int kWaves = 24;
/// Multi-PIE's points that a pair of glasses rests on or lies about: the temples' ends of the contour, the
/// bridge of the nose, the corners and lids of the eyes.
constexpr std::array<std::size_t, 18> kUnderGlasses = {0,  1,  15, 16, 27, 28, 36, 37, 38,
                                                       39, 40, 41, 42, 43, 44, 45, 46, 47};

Eigen::Affine3d lay_on(const face::Face& from, const face::Face& to) {
  Eigen::Matrix<double, 3, static_cast<int>(kUnderGlasses.size())> a;
  Eigen::Matrix<double, 3, static_cast<int>(kUnderGlasses.size())> b;
  for (std::size_t i = 0; i < kUnderGlasses.size(); ++i) {
    a.col(static_cast<Eigen::Index>(i)) = from.neutral_m[from.landmarks[kUnderGlasses[i]]].cast<double>();
    b.col(static_cast<Eigen::Index>(i)) = to.neutral_m[to.landmarks[kUnderGlasses[i]]].cast<double>();
  }
  return Eigen::Affine3d(Eigen::umeyama(a, b, false));
}

Vec3 facet_normal(const face::Face& face, const std::array<std::uint32_t, 3>& triangle) {
  const auto at = [&](std::size_t c) -> Vec3 { return face.neutral_m[triangle[c]].cast<double>(); };
  return (at(1) - at(0)).cross(at(2) - at(0));
}

}  // namespace

SkinPattern::SkinPattern(double relative, double size_m, Random random) : relative_(relative) {
  if (relative <= 0) return;
  for (int i = 0; i < kWaves; ++i)
    // Half a wave is about the size of a spot.
    waves_.push_back({random.direction() * random.uniform(0.5, 1.5) / (2 * size_m), random.uniform()});
}

double SkinPattern::at(const Vec3& neutral_m) const {
  double sum = 0;
  for (const Wave& wave : waves_)
    sum += std::sin(2 * std::numbers::pi * (wave.turns_per_m.dot(neutral_m) + wave.phase));
  // A sum of kWaves sines has this variance.
  return std::exp(relative_ * sum / std::sqrt(0.5 * kWaves));
}

Result<EyewearWearer> seat_eyewear(face::Face face, const sensor::Rig& rig, const EyewearFaults& faults,
                                   const Random& random) {
  if (!face.has_landmarks)
    return fail(ErrorCode::not_found, "the face has no landmarks, so glasses cannot be put onto it",
                face.name, "use the built-in face, an ICT-FaceKit folder, or a head with 68 landmarks");
  EyewearWearer wearer;
  Random skin = random.fork("skin");
  wearer.reflectance = skin.uniform(faults.skin_reflectance[0], faults.skin_reflectance[1]);
  wearer.pattern = SkinPattern(faults.pattern, 1e-3 * faults.pattern_mm, random.fork("pattern"));

  const Eigen::Affine3d laid = lay_on(builtin_face::default_builtin(), face);
  std::vector<std::array<std::uint32_t, 3>> skin_mesh;
  for (const std::uint32_t t : face::skin_triangles(face)) skin_mesh.push_back(face.triangles[t]);
  const render::RayScene scene(face.neutral_m, skin_mesh);
  for (const sensor::Mount& mount : rig.sensors) {
    if (!mount.position_m || !mount.aim)
      return fail(ErrorCode::not_found,
                  fmt::format("sensor {} has no place on the head or does not look anywhere", mount.name),
                  rig.name, "give it position_m and aim in the rig file");
    SeatedSensor sensor{laid * *mount.position_m, (laid.linear() * *mount.aim).normalized()};
    // On another head the frame may stand inside the skin: look from well before it.
    const double back_m = 0.02;
    const Vec3f from = (sensor.position_m - back_m * sensor.aim).cast<float>();
    const render::RayScene::Hit hit = scene.first_hit(from, sensor.aim.cast<float>());
    // From behind, as a sensor sees it that looks away from the face, skin does not count.
    if (!hit.any() || facet_normal(face, skin_mesh[hit.triangle]).dot(sensor.aim) >= 0)
      return fail(ErrorCode::not_found, fmt::format("sensor {} does not see skin", mount.name), face.name,
                  "turn its aim towards the skin");
    const double distance_m = double{hit.distance} - back_m;
    const double fitted_m = std::clamp(distance_m, 1e-3 * faults.fit_mm[0], 1e-3 * faults.fit_mm[1]);
    sensor.position_m += (distance_m - fitted_m) * sensor.aim;
    wearer.sensors.push_back(sensor);
    wearer.centre_m += sensor.position_m / static_cast<double>(rig.sensors.size());
  }
  wearer.face = std::move(face);
  return wearer;
}

Result<EyewearWearer> draw_eyewear_wearer(const sensor::Rig& rig, const EyewearFaults& faults,
                                          const Random& random) {
  Random identity = random.fork("identity");
  return seat_eyewear(builtin_face::make_builtin(without_hair(builtin_face::random_identity(identity))), rig,
                      faults, random);
}

EyewearSeat draw_seat(const EyewearFaults& faults, Random& random) {
  EyewearSeat seat;
  seat.shift_m = random.direction() * random.uniform(0, 1e-3 * faults.mount_shift_mm);
  seat.tilt_rad = random.direction() * random.uniform(0, faults.mount_tilt_deg * std::numbers::pi / 180);
  return seat;
}

SeatedSensor seated(const EyewearWearer& wearer, std::size_t sensor, const EyewearSeat& seat) {
  const SeatedSensor& fitted = wearer.sensors[sensor];
  const Quat turn = exp_rotation(seat.tilt_rad);
  return {wearer.centre_m + turn * (fitted.position_m - wearer.centre_m) + seat.shift_m, turn * fitted.aim};
}

}  // namespace mien::virt
