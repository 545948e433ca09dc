#include "mien/virtual/headset/headset_simulator.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "mien/core/rotation.h"
#include "mien/face/face.h"
#include "mien/virtual/headset/obstacles.h"
#include "mien/virtual/headset/watched_parts.h"

namespace mien::virt {

using face::shape;

namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180;
constexpr std::array<std::string_view, kHeadsetFailures> kNames = {
    "none", "hand", "cup", "mask", "moustache", "poor_seat", "smear", "sun", "dark", "covered"};
/// Sides of a crop that is to be square differ by at most this share.
constexpr double kSquare = 0.02;
/// Of poor donning; of grease on a lens.
constexpr double kPoor_m = 8e-3, kPoor_rad = 8 * kRadPerDeg;
/// How far a cup is tipped against the lips.
constexpr double kDrinking_rad = 60 * kRadPerDeg;
constexpr std::array<double, 2> kGrease = {0.6, 0.9};
/// Sun is so many times as bright as the lamps at the cheek; in the dark a lamp gives this share.
constexpr float kSun = 25, kDark = 0.004F;
/// Where no lamp reaches a place, the light of the lamps at the cheek is taken from here.
constexpr float kCheek_m = 0.05F;
/// What skin at this distance sends of the light that one camera's lamps throw there.
constexpr double kUsual_m = 0.06, kSkin = 0.6 / std::numbers::pi;
/// Slow unrest of pupils (hippus), Hz: Stark, Campbell and Atwood 1958, doi:10.1038/182857a0 have 0.05 to
/// 0.3.
constexpr std::array<double, 3> kHippus_hz = {0.06, 0.13, 0.27};

Eigen::Matrix3f turn_of(const Vec3& rotation_rad) {
  return exp_rotation(rotation_rad).toRotationMatrix().cast<float>();
}

}  // namespace

Result<void> check_network_views(const sensor::Rig& rig) {
  for (const sensor::Mount& mount : rig.sensors) {
    if (!mount.camera) continue;
    const sensor::CameraMount& camera = *mount.camera;
    const double width = camera.crop[2] * camera.size[0], height = camera.crop[3] * camera.size[1];
    if (std::abs(width - height) > kSquare * std::max(width, height))
      return fail(ErrorCode::out_of_range,
                  fmt::format("{}'s crop is {:.0f} x {:.0f} pixels, not a square", mount.name, width, height),
                  "rig " + rig.name, "give its [sensor.camera] a crop that is as wide as high");
  }
  return {};
}

std::string_view failure_name(HeadsetFailure failure) {
  return kNames[static_cast<std::size_t>(failure)];
}

std::optional<HeadsetFailure> failure_named(std::string_view name) {
  for (std::size_t i = 0; i < kNames.size(); ++i)
    if (kNames[i] == name) return static_cast<HeadsetFailure>(i);
  return std::nullopt;
}

/// The thing that hides the face, in its own frame, and how it comes there.
struct HeadsetSimulator::Obstacle {
  std::vector<Vec3f> vertices_m;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  Vec3f at_m = Vec3f::Zero();  // Frame H.
  Vec3 turn_rad = Vec3::Zero();
  std::array<double, 4> phase{};     // Of its unrest, turns.
  bool with_head = false;            // A mask sits on the face.
  std::vector<std::uint32_t> roots;  // Of a moustache: the face's vertex that each vertex hangs on.
  std::vector<Vec3f> hangs_m;        // And how far from it.
};

HeadsetSimulator::HeadsetSimulator(const HeadsetWearer& wearer, const HeadsetFaults& faults,
                                   const Random& random, int network_view, HeadsetFailure failure)
    : wearer_(&wearer),
      faults_(faults),
      failure_(failure),
      fails_(failure != HeadsetFailure::none),
      lamps_(wearer.lamps),
      seats_(random.fork("seat")),
      slips_(random.fork("slip")),
      sways_(random.fork("sway")) {
  std::vector<Vec3f> places_m;
  double all = 0;
  for (const render::InfraredLamp& lamp : lamps_) all += double{lamp.intensity};
  const double usual = kSkin * all / static_cast<double>(wearer.cameras.size()) / (kUsual_m * kUsual_m);
  for (std::size_t c = 0; c < wearer.cameras.size(); ++c) {
    const FittedCamera& camera = wearer.cameras[c];
    const auto& [width, height] = camera.mount.size;
    render::Lens lens = render::make_lens(camera.position_m, camera.look_at_m, camera.up,
                                          camera.field_of_view_rad, camera.radial_k1, width, height);
    const Eigen::Vector2f whole(static_cast<float>(width), static_cast<float>(height));
    lens.centre_px = camera.centre.cwiseProduct(whole);
    PictureSize size{width, height};
    if (network_view > 0) {
      const auto& [left, top, share, ignored] = camera.mount.crop;
      const float scale = static_cast<float>(network_view) / (static_cast<float>(share) * whole.x());
      lens.centre_px -=
          Eigen::Vector2f(static_cast<float>(left), static_cast<float>(top)).cwiseProduct(whole);
      lens.centre_px *= scale;
      lens.pixel /= scale;
      size = {network_view, network_view};
      lens.width = size.width;
      lens.height = size.height;
    }
    const float distance_m = (camera.look_at_m - camera.position_m).norm();
    places_m.push_back(camera.position_m);
    views_.push_back(
        {size, lens, CameraSensor(faults, size, distance_m, lens.pixel, usual, random.fork("camera", c)),
         std::vector<float>(static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height)),
         failure == HeadsetFailure::none ? std::vector<std::uint32_t>()
                                         : watched_vertices(wearer.face, camera.of_mouth, lens)});
  }

  Random fails = random.fork("failure");
  covered_ = fails.below(std::max<std::size_t>(1, views_.size()));
  render::InfraredWearer looks = wearer.looks;
  things_m_ = wearer.things_m;
  const auto hide_by = [&](virt::Obstacle mesh, const Vec3f& at_m, double turned_deg) {
    obstacle_ = std::make_unique<Obstacle>();
    obstacle_->vertices_m = std::move(mesh.vertices_m);
    obstacle_->triangles = mesh.thing.triangles;
    obstacle_->at_m = at_m;
    obstacle_->turn_rad = fails.normal_vector(kRadPerDeg * turned_deg);
    for (double& phase : obstacle_->phase) phase = fails.uniform();
    looks.things.push_back(std::move(mesh.thing));
    things_m_.insert(things_m_.end(), obstacle_->vertices_m.size(), Vec3f(0, 0, -10));
  };
  const face::Face& face = wearer.face;
  const auto mark = [&](std::size_t i) { return face.neutral_m[face.landmarks[i]]; };
  const Vec3f mouth_m = face.has_landmarks ? Vec3f(0.5F * (mark(51) + mark(57)))
                                           : Vec3f(wearer.middle_m - Vec3f(0, 0.05F, 0.03F));
  if (failure == HeadsetFailure::moustache && !face.has_landmarks) failure_ = HeadsetFailure::none;
  switch (failure_) {
    case HeadsetFailure::hand:
      hide_by(make_hand(fails), mouth_m + Vec3f(0, 0, 0.016F) + fails.normal_vector(0.006).cast<float>(), 25);
      break;
    case HeadsetFailure::cup:
      hide_by(make_cup(fails), mouth_m + Vec3f(0, 0.002F, 0.004F), 10);
      obstacle_->turn_rad.x() -= kDrinking_rad;
      break;
    case HeadsetFailure::mask:
      hide_by(make_mask(fails), mouth_m + Vec3f(0, 0.012F, 0), 1);
      obstacle_->with_head = true;
      break;
    case HeadsetFailure::moustache: {
      virt::Obstacle hairs;
      hairs.thing.albedo = static_cast<float>(fails.uniform(0.07, 0.4));
      std::vector<std::uint32_t> roots;
      const Vec3f nose_m = mark(33), left_m = mark(54), lip_m = mark(51);
      for (std::uint32_t v = 0; v < face.neutral_m.size(); ++v) {
        const Vec3f& p = face.neutral_m[v];
        if (p.z() < left_m.z() || std::abs(p.x() - nose_m.x()) > 1.15F * std::abs(left_m.x() - nose_m.x()) ||
            p.y() > nose_m.y() - 0.001F || p.y() < lip_m.y() - 0.001F)
          continue;
        const auto before = hairs.vertices_m.size();
        const auto long_m = static_cast<float>(fails.uniform(0.009, 0.018));
        const Vec3f down(0.25F * (p.x() - nose_m.x()) / std::abs(left_m.x() - nose_m.x()), -1, 0.35F);
        add_tube(
            hairs,
            {p, p + 0.5F * long_m * (down + Vec3f(0, 0, 0.25F)).normalized(), p + long_m * down.normalized()},
            0.0009F, false);
        roots.insert(roots.end(), hairs.vertices_m.size() - before, v);
      }
      hairs.thing.vertices = hairs.vertices_m.size();
      std::vector<Vec3f> hangs_m;
      for (std::size_t i = 0; i < roots.size(); ++i)
        hangs_m.push_back(hairs.vertices_m[i] - face.neutral_m[roots[i]]);
      hide_by(std::move(hairs), Vec3f::Zero(), 0);
      obstacle_->roots = std::move(roots);
      obstacle_->hangs_m = std::move(hangs_m);
      break;
    }
    case HeadsetFailure::poor_seat:
      poor_.shift_m = kPoor_m * fails.direction();
      poor_.tilt_rad = kPoor_rad * fails.direction();
      break;
    case HeadsetFailure::smear:
      for (const View& view : views_)
        grease_.push_back({view.sensor.smear(), static_cast<float>(fails.uniform(kGrease[0], kGrease[1]))});
      break;
    default:
      break;
  }

  looks.background =
      static_cast<float>(random.fork("background").uniform(faults.background[0], faults.background[1]));
  scene_.emplace(face, std::move(looks), places_m);
  first_m_.resize(face.neutral_m.size());
  last_m_.resize(face.neutral_m.size());
  neutral_gap_ = lid_gaps(face.neutral_m);
  ambient_ =
      random.fork("ambient").uniform(faults.ambient[0], faults.ambient[1]) * all / (kCheek_m * kCheek_m);
  Random breath = random.fork("breath");
  for (double& phase : breath_phase_) phase = breath.uniform();
}

HeadsetSimulator::~HeadsetSimulator() = default;

void HeadsetSimulator::put_on() {
  seat_.shift_m = seats_.normal_vector(1e-3 * faults_.seat_mm);
  seat_.tilt_rad = seats_.normal_vector(kRadPerDeg * faults_.seat_deg);
}

void HeadsetSimulator::sit(const HeadsetSeat& seat) {
  seat_ = seat;
}

void HeadsetSimulator::wait_until(double time_s) {
  const double seconds = begun_ ? std::max(0.0, time_s - now_s_) : 0.0;
  const double root_min = std::sqrt(seconds / 60);
  seat_.shift_m += slips_.normal_vector(1e-3 * faults_.slip_mm_per_sqrt_min * root_min);
  seat_.tilt_rad += slips_.normal_vector(kRadPerDeg * faults_.slip_deg_per_sqrt_min * root_min);
  // It stands in its own spread from the first moment on.
  const double kept = begun_ ? std::exp(-seconds / faults_.sway_s) : 0.0, fresh = std::sqrt(1 - kept * kept);
  sway_.shift_m = kept * sway_.shift_m + sways_.normal_vector(1e-3 * faults_.sway_mm * fresh);
  sway_.tilt_rad = kept * sway_.tilt_rad + sways_.normal_vector(kRadPerDeg * faults_.sway_deg * fresh);
  now_s_ = begun_ ? std::max(now_s_, time_s) : time_s;
  begun_ = true;
}

HeadsetSeat HeadsetSimulator::seat_with(const face::BlendshapeWeights& weights) const {
  const auto mean = [&](std::size_t left, std::size_t right) {
    return 0.5 * (double{weights[left]} + double{weights[right]});
  };
  const double raised = std::clamp(mean(shape("cheekSquint_L"), shape("cheekSquint_R")) +
                                       0.4 * mean(shape("mouthSmile_L"), shape("mouthSmile_R")),
                                   0.0, 1.0);
  HeadsetSeat seat = seat_;
  seat.shift_m += sway_.shift_m + Vec3(0, 1e-3 * faults_.lift_mm * raised, 0);
  seat.tilt_rad += sway_.tilt_rad - Vec3(kRadPerDeg * faults_.lift_deg * raised, 0, 0);
  if (fails_) {
    seat.shift_m += poor_.shift_m;
    seat.tilt_rad += poor_.tilt_rad;
  }
  return seat;
}

/// Where a headset at a seat has what was fitted elsewhere.
struct HeadsetSimulator::Seated {
  Seated(const HeadsetWearer& wearer, const HeadsetSeat& seat)
      : middle_m(wearer.middle_m), shift_m(seat.shift_m.cast<float>()), turn(turn_of(seat.tilt_rad)) {}
  [[nodiscard]] Vec3f place(const Vec3f& fitted_m) const {
    return middle_m + turn * (fitted_m - middle_m) + shift_m;
  }
  [[nodiscard]] render::Lens lens(const render::Lens& fitted) const {
    render::Lens moved = fitted;
    moved.position_m = place(fitted.position_m);
    moved.forward = turn * fitted.forward;
    moved.right = turn * fitted.right;
    moved.up = turn * fitted.up;
    return moved;
  }
  Vec3f middle_m, shift_m;
  Eigen::Matrix3f turn;
};

void HeadsetSimulator::place_obstacles(double time_s) {
  if (!obstacle_) return;
  const std::span<Vec3f> places = std::span(things_m_).last(obstacle_->vertices_m.size());
  if (!fails_) {
    std::ranges::fill(places, Vec3f(0, 0, -10));
    return;
  }
  if (!obstacle_->roots.empty()) {
    for (std::size_t i = 0; i < places.size(); ++i)
      places[i] = first_m_[obstacle_->roots[i]] + obstacle_->hangs_m[i];
    return;
  }
  // A hand or cup is never still.
  Vec3f unrest = Vec3f::Zero();
  if (!obstacle_->with_head)
    for (Eigen::Index i = 0; i < 3; ++i)
      unrest[i] = static_cast<float>((i == 2 ? 0.002 : 0.006) *
                                     std::sin(2 * std::numbers::pi *
                                              ((0.35 + 0.23 * static_cast<double>(i)) * time_s +
                                               obstacle_->phase[static_cast<std::size_t>(i)])));
  const double wave =
      obstacle_->with_head
          ? 0
          : 8 * kRadPerDeg * std::sin(2 * std::numbers::pi * (0.4 * time_s + obstacle_->phase[3]));
  const Eigen::Matrix3f turn = turn_of(obstacle_->turn_rad + Vec3(0, 0, wave));
  for (std::size_t i = 0; i < places.size(); ++i)
    places[i] = obstacle_->at_m + unrest + turn * obstacle_->vertices_m[i];
}

std::array<float, 2> HeadsetSimulator::lid_gaps(std::span<const Vec3f> vertices_m) const {
  const face::Face& face = wearer_->face;
  if (!face.has_landmarks) return {0, 0};
  // Multi-PIE 36 to 41 is the performer's right eye: upper lid 37 and 38, lower 41 and 40.
  const auto gap = [&](std::size_t first) {
    const auto at = [&](std::size_t i) { return vertices_m[face.landmarks[first + i]]; };
    return 0.5F * (at(1).y() - at(5).y() + at(2).y() - at(4).y());
  };
  return {gap(42), gap(36)};
}

std::array<bool, 2> HeadsetSimulator::seen_halves(std::span<const render::Lens> lenses,
                                                  std::span<const std::span<std::uint8_t>> pictures) const {
  if (failure_ == HeadsetFailure::none) return {true, true};
  if (failure_ == HeadsetFailure::smear) return {false, false};
  HidingMesh thing;
  if (obstacle_) thing = {std::span(things_m_).last(obstacle_->vertices_m.size()), obstacle_->triangles};
  SeenHalves halves;
  for (std::size_t c = 0; c < views_.size(); ++c) {
    if (views_[c].watched.empty()) continue;
    const bool is_covered = failure_ == HeadsetFailure::covered && c == covered_;
    // Exposure follows the dark, and not what is bright and dark at once.
    const std::span<const std::uint8_t> picture =
        failure_ == HeadsetFailure::sun ? pictures[c] : std::span<std::uint8_t>();
    halves.add(wearer_->cameras[c].of_mouth ? 1 : 0,
               is_covered ? 1 : hidden_share(views_[c].watched, first_m_, thing, lenses[c], picture));
  }
  return halves.seen();
}

HeadsetTruth HeadsetSimulator::shoot(double time_s, const HeadsetPose& first, const HeadsetPose& last,
                                     std::span<const std::span<std::uint8_t>> out) {
  wait_until(time_s);
  const face::Face& face = wearer_->face;
  face::evaluate(face, first.weights, first.tongue_out, first_m_);
  face::turn_eyes(face, first.weights, first_m_);
  const bool moves = !(first == last);
  if (moves) {
    face::evaluate(face, last.weights, last.tongue_out, last_m_);
    face::turn_eyes(face, last.weights, last_m_);
  }
  const Seated seated(*wearer_, seat_with(first.weights));
  place_obstacles(time_s);
  scene_->pose(first_m_, moves ? last_m_ : first_m_, things_m_);

  HeadsetTruth truth;
  double breath = 0;
  for (std::size_t k = 0; k < kHippus_hz.size(); ++k)
    breath += std::sin(2 * std::numbers::pi * (kHippus_hz[k] * time_s + breath_phase_[k]));
  const double pupil_mm = wearer_->pupil_mm * (1 + faults_.pupil_breath * breath / 1.3);
  truth.pupil_mm = {static_cast<float>(pupil_mm), static_cast<float>(pupil_mm)};
  scene_->set_pupils({static_cast<float>(0.5e-3 * pupil_mm), static_cast<float>(0.5e-3 * pupil_mm)});
  truth.gaze_rad = face::eyes_rad(first.weights);
  const std::array<float, 2> gaps = lid_gaps(first_m_);
  for (std::size_t e = 0; e < 2; ++e)
    truth.openness[e] = neutral_gap_[e] > 0 ? std::max(0.0F, gaps[e] / neutral_gap_[e]) : 1.0F;

  std::vector<render::InfraredLamp> lamps;
  for (render::InfraredLamp lamp : lamps_) {
    lamp.position_m = seated.place(lamp.position_m);
    lamp.aim = seated.turn * lamp.aim;
    if (fails_ && failure_ == HeadsetFailure::dark) lamp.intensity *= kDark;
    lamps.push_back(lamp);
  }
  if (fails_ && failure_ == HeadsetFailure::sun) {
    float all = 0;
    for (const render::InfraredLamp& lamp : lamps_) all += lamp.intensity;
    const Vec3f from(covered_ % 2 == 0 ? 0.6F : -0.6F, -0.35F, 0.35F);
    lamps.push_back({.position_m = wearer_->middle_m + from,
                     .aim = -from.normalized(),
                     .intensity = kSun * all * from.squaredNorm() / (kCheek_m * kCheek_m) / 10,
                     .narrow = 1,
                     .radius_m = 0.003F});
  }
  std::vector<render::Lens> lenses;
  for (const View& view : views_) lenses.push_back(seated.lens(view.lens));
  scene_->light(lamps, static_cast<float>(ambient_), lenses);

  for (std::size_t c = 0; c < views_.size(); ++c) {
    View& view = views_[c];
    const double exposure =
        faults_.rolling_ms > 0 ? wearer_->cameras[c].mount.exposure_ms / faults_.rolling_ms : 0;
    scene_->draw(lenses[c], static_cast<float>(exposure), canvas_, view.radiance);
    if (fails_ && failure_ == HeadsetFailure::covered && c == covered_)
      for (float& light : view.radiance) light = 0.15F * static_cast<float>(ambient_);
    if (!grease_.empty()) view.sensor.set_smear(fails_ ? grease_[c].much : grease_[c].usual);
    view.sensor.expose(time_s, view.radiance, out[c]);
  }

  if (fails_) truth.is_visible = seen_halves(lenses, out);
  return truth;
}

}  // namespace mien::virt
