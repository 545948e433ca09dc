#include "mien/virtual/eyewear/eyewear_simulator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "mien/face/surface_point.h"
#include "mien/render/ray_scene.h"

namespace mien::virt {

using face::shape;

namespace {

/// Skin farther than this from every sensor is left out of the rays' scene: none can see it, moved as far as
/// skin moves.
constexpr double kSceneRadiusM = 0.024;
/// Rays of a cone: the middle one, and a ring at two thirds of its half-angle.
constexpr std::size_t kRingRays = 6;
constexpr double kRing = 2.0 / 3.0;
/// The LED shines brighter straight ahead.
constexpr double kMiddleShare = 0.25;
/// Closer than this a sensor touches.
constexpr double kContactM = 0.0003;
/// A seat leaves at least this between the neutral skin and every sensor.
constexpr double kClearanceM = 0.001;
constexpr int kSeatTries = 200;
/// The bench's card.
constexpr double kCardReflectance = 0.55;

std::array<Vec3, kRingRays + 1> cone(const Vec3& aim, double half_angle_rad) {
  const Vec3 side = (std::abs(aim.y()) < 0.9 ? Vec3::UnitY() : Vec3::UnitX()).cross(aim).normalized();
  const Vec3 up = aim.cross(side);
  std::array<Vec3, kRingRays + 1> rays;
  rays[0] = aim;
  for (std::size_t i = 0; i < kRingRays; ++i) {
    const double turn = 2 * std::numbers::pi * static_cast<double>(i) / kRingRays;
    rays[i + 1] = std::cos(kRing * half_angle_rad) * aim +
                  std::sin(kRing * half_angle_rad) * (std::cos(turn) * side + std::sin(turn) * up);
  }
  return rays;
}

double ray_share(std::size_t ray) {
  return ray == 0 ? kMiddleShare : (1 - kMiddleShare) / kRingRays;
}

}  // namespace

/// The skin about the sensors, and rays onto it.
class EyewearSimulator::Skin {
 public:
  explicit Skin(const EyewearWearer& wearer) {
    const face::Face& face = wearer.face;
    std::vector<std::uint32_t> local(face.neutral_m.size(), kLeftOut);
    const auto near = [&](std::uint32_t v) {
      return std::ranges::any_of(wearer.sensors, [&](const SeatedSensor& sensor) {
        return (face.neutral_m[v].cast<double>() - sensor.position_m).squaredNorm() <
               kSceneRadiusM * kSceneRadiusM;
      });
    };
    for (const std::uint32_t t : face::skin_triangles(face)) {
      if (!std::ranges::any_of(face.triangles[t], near)) continue;
      std::array<std::uint32_t, 3>& triangle = triangles_.emplace_back();
      for (std::size_t c = 0; c < 3; ++c) {
        const std::uint32_t v = face.triangles[t][c];
        if (local[v] == kLeftOut) {
          local[v] = static_cast<std::uint32_t>(neutral_m_.size());
          neutral_m_.push_back(face.neutral_m[v]);
        }
        triangle[c] = local[v];
      }
    }
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      for (std::size_t i = 0; i < face.shapes[k].vertex.size(); ++i)
        if (const std::uint32_t v = local[face.shapes[k].vertex[i]]; v != kLeftOut)
          moves_[k].push_back({v, face.shapes[k].delta_m[i]});
    moved_m_ = neutral_m_;
    normals_.resize(neutral_m_.size());
    scene_ = std::make_unique<render::RayScene>(neutral_m_, triangles_);
    find_normals();
  }

  void move(const face::BlendshapeWeights& weights) {
    if (weights == weights_) return;
    weights_ = weights;
    moved_m_ = neutral_m_;
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      if (weights[k] != 0)
        for (const Move& move : moves_[k]) moved_m_[move.vertex] += weights[k] * move.delta_m;
    scene_->move(moved_m_);
    find_normals();
  }

  struct Seen {
    double distance_m = std::numeric_limits<double>::infinity();
    double cosine = 0;              ///< Of the angle between ray and normal; 0 or less: seen from inside.
    Vec3 neutral_m = Vec3::Zero();  ///< Which spot of skin.
  };
  [[nodiscard]] Seen look(const Vec3& from, const Vec3& direction) const {
    const render::RayScene::Hit hit = scene_->first_hit(from.cast<float>(), direction.cast<float>());
    if (!hit.any()) return {};
    const auto& [a, b, c] = triangles_[hit.triangle];
    const float w = 1 - hit.u - hit.v;
    const Vec3f normal = (w * normals_[a] + hit.u * normals_[b] + hit.v * normals_[c]).normalized();
    const Vec3f spot = w * neutral_m_[a] + hit.u * neutral_m_[b] + hit.v * neutral_m_[c];
    return {double{hit.distance}, -normal.cast<double>().dot(direction), spot.cast<double>()};
  }

 private:
  static constexpr std::uint32_t kLeftOut = ~0U;
  struct Move {
    std::uint32_t vertex = 0;
    Vec3f delta_m;
  };

  void find_normals() {
    std::ranges::fill(normals_, Vec3f::Zero());
    for (const auto& [a, b, c] : triangles_) {
      const Vec3f normal = (moved_m_[b] - moved_m_[a]).cross(moved_m_[c] - moved_m_[a]);
      normals_[a] += normal;
      normals_[b] += normal;
      normals_[c] += normal;
    }
    for (Vec3f& normal : normals_) normal.normalize();
  }

  std::vector<Vec3f> neutral_m_;
  std::vector<std::array<std::uint32_t, 3>> triangles_;
  std::array<std::vector<Move>, face::kShapeCount> moves_;
  face::BlendshapeWeights weights_;
  std::vector<Vec3f> moved_m_;
  std::vector<Vec3f> normals_;
  std::unique_ptr<render::RayScene> scene_;
};

EyewearSimulator::EyewearSimulator(const EyewearWearer& wearer, const EyewearFaults& faults,
                                   const Random& random)
    : wearer_(&wearer),
      faults_(faults),
      response_(1e-3 * faults.focal_peak_mm, 1e-3 * faults.falloff_mm),
      skin_(std::make_unique<Skin>(wearer)),
      sweat_(wearer.sensors.size(), 0.0),
      tissue_m_(wearer.sensors.size(), 0.0),
      seats_(random.fork("seat")),
      slip_(random.fork("slip")),
      skin_walk_(random.fork("skin")),
      sways_(random.fork("sway")),
      tissues_(random.fork("tissue")) {
  for (std::size_t s = 0; s < wearer.sensors.size(); ++s) parts_.emplace_back(faults, random.fork("part", s));
  clock_ = VirtualClock::drawn(faults.clock_offset_s, faults.clock_drift_ppm, random.fork("clock"));
}

EyewearSimulator::EyewearSimulator(EyewearSimulator&&) noexcept = default;
EyewearSimulator::~EyewearSimulator() = default;

void EyewearSimulator::put_on() {
  for (int i = 0; i < kSeatTries; ++i) {
    seat_ = draw_seat(faults_, seats_);
    if (std::ranges::all_of(distances_m({}), [](double d) { return d > kClearanceM; })) return;
  }
  seat_ = {};  // Glasses that fit nowhere else sit as they were fitted.
}

void EyewearSimulator::sit(const EyewearSeat& seat) {
  seat_ = seat;
}

EyewearSeat EyewearSimulator::seat() const {
  return seat_;
}

EyewearSeat EyewearSimulator::seat_with(const face::BlendshapeWeights& weights) const {
  const auto mean = [&](std::size_t left, std::size_t right) {
    return 0.5 * (double{weights[left]} + double{weights[right]});
  };
  const double lift =
      mean(shape("cheekSquint_L"), shape("cheekSquint_R")) + mean(shape("noseSneer_L"), shape("noseSneer_R"));
  EyewearSeat seat = seat_;
  seat.shift_m += sway_.shift_m;
  seat.tilt_rad += sway_.tilt_rad;
  seat.shift_m.y() += 1e-3 * faults_.ride_up_mm * lift;
  return seat;
}

void EyewearSimulator::wait_until(double time_s) {
  const double seconds = std::max(0.0, time_s - now_s_);
  const double root_min = std::sqrt(seconds / 60);
  seat_.shift_m += slip_.normal_vector(1e-3 * faults_.slip_mm_per_sqrt_min * root_min);
  seat_.tilt_rad += slip_.normal_vector(faults_.slip_deg_per_sqrt_min * std::numbers::pi / 180 * root_min);
  // Both stand in their own spread from the first moment on: they were there before the glasses were.
  const double sway_kept = now_s_ > 0 ? std::exp(-seconds / faults_.sway_s) : 0.0;
  const double sway_new = std::sqrt(1 - sway_kept * sway_kept);
  sway_.shift_m = sway_kept * sway_.shift_m + sways_.normal_vector(1e-3 * faults_.sway_mm * sway_new);
  sway_.tilt_rad =
      sway_kept * sway_.tilt_rad + sways_.normal_vector(faults_.sway_deg * std::numbers::pi / 180 * sway_new);
  const double tissue_kept = now_s_ > 0 ? std::exp(-seconds / faults_.tissue_s) : 0.0;
  const double tissue_new = std::sqrt(1 - tissue_kept * tissue_kept);
  for (double& spot_m : tissue_m_)
    spot_m = tissue_kept * spot_m + tissues_.normal(0, 1e-3 * faults_.tissue_mm * tissue_new);
  blush_ += skin_walk_.normal(0, faults_.blush_per_sqrt_min * root_min);
  for (double& spot : sweat_) spot += skin_walk_.normal(0, faults_.sweat_per_sqrt_min * root_min);
  for (PhotoSensor& part : parts_) part.wait(seconds);
  now_s_ = std::max(now_s_, time_s);
}

std::vector<double> EyewearSimulator::distances_m(const face::BlendshapeWeights& weights) {
  skin_->move(weights);
  const EyewearSeat seat = seat_with(weights);
  std::vector<double> distances;
  for (std::size_t s = 0; s < wearer_->sensors.size(); ++s) {
    const SeatedSensor sensor = seated(*wearer_, s, seat);
    const Skin::Seen seen = skin_->look(sensor.position_m, sensor.aim);
    distances.push_back(seen.cosine > 0 ? seen.distance_m : 0.0);
  }
  return distances;
}

std::vector<double> EyewearSimulator::reflected(const face::BlendshapeWeights& weights) {
  skin_->move(weights);
  const EyewearSeat seat = seat_with(weights);
  std::vector<double> light;
  for (std::size_t s = 0; s < wearer_->sensors.size(); ++s) {
    const SeatedSensor sensor = seated(*wearer_, s, seat);
    const auto rays = cone(sensor.aim, faults_.cone_deg * std::numbers::pi / 180);
    double sum = 0;
    for (std::size_t r = 0; r < rays.size(); ++r) {
      const Skin::Seen seen = skin_->look(sensor.position_m, rays[r]);
      // Seen from inside: the skin lies on the sensor.
      const double distance_m =
          seen.cosine > 0 ? std::max(seen.distance_m - tissue_m_[s], kContactM) : kContactM;
      if (!std::isfinite(seen.distance_m)) continue;
      sum += ray_share(r) * std::abs(seen.cosine) * wearer_->pattern.at(seen.neutral_m) *
             response_.at(distance_m);
    }
    light.push_back(wearer_->reflectance * std::exp(blush_ + sweat_[s]) * sum);
  }
  return light;
}

std::vector<sensor::Sample> EyewearSimulator::play(double begin_s, int pairs,
                                                   const face::BlendshapeWeights& from,
                                                   const face::BlendshapeWeights& to) {
  wait_until(begin_s);
  const std::vector<double> first = reflected(from);
  const std::vector<double> last = from == to ? first : reflected(to);
  const double period_s = pair_period_s();
  const double slot_s = period_s / static_cast<double>(parts_.size());
  std::vector<sensor::Sample> samples;
  samples.reserve(static_cast<std::size_t>(pairs) * parts_.size());
  for (int p = 0; p < pairs; ++p, ++sequence_)
    for (std::size_t s = 0; s < parts_.size(); ++s) {
      const double slot_begin_s = begin_s + p * period_s + static_cast<double>(s) * slot_s;
      const double u = (slot_begin_s - begin_s) / (pairs * period_s);
      sensor::Sample sample;
      sample.sensor = static_cast<std::uint16_t>(s);
      sample.kind = sensor::SampleKind::eyewear_light;
      sample.sequence = sequence_;
      sample.time = clock_.device(slot_begin_s + 0.5 * slot_s);
      sample.count = 2;
      sample.values[0] = static_cast<float>(
          parts_[s].read(first[s] + u * (last[s] - first[s]), slot_begin_s + 0.25 * slot_s));
      sample.values[1] = static_cast<float>(parts_[s].read(0, slot_begin_s + 0.75 * slot_s));
      samples.push_back(sample);
    }
  return samples;
}

std::vector<eyewear::BenchReading> EyewearSimulator::bench(std::size_t sensor) const {
  const auto rays = cone(Vec3::UnitZ(), faults_.cone_deg * std::numbers::pi / 180);
  std::vector<eyewear::BenchReading> readings;
  for (int half_mm = 2; half_mm <= 60; ++half_mm) {
    const double distance_m = 0.0005 * half_mm;
    double sum = 0;
    for (std::size_t r = 0; r < rays.size(); ++r)
      sum += ray_share(r) * rays[r].z() * response_.at(distance_m / rays[r].z());
    readings.push_back({distance_m, parts_[sensor].bench(kCardReflectance * sum)});
  }
  return readings;
}

}  // namespace mien::virt
