#include "mien/virtual/headset/headset_wearer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "mien/builtin_face/builtin_face.h"
#include "mien/builtin_face/skin_marks.h"
#include "mien/core/smoothstep.h"
#include "mien/render/solid_noise.h"
#include "mien/virtual/headset/obstacles.h"

namespace mien::virt {

using face::Material;

namespace {

constexpr double kDeg = std::numbers::pi / 180;
/// Fields of view that rigs may give, and none beyond is drawn.
constexpr double kNarrowest_deg = 5, kWidest_deg = 170;
/// A camera or lamp stands at least so far from the neutral skin.
constexpr float kClearance_m = 0.008F;
/// A headset is pushed forward in such steps until that holds, so often at most.
constexpr float kPush_m = 0.001F;
constexpr int kPushes = 25;
/// Spectacles' glasses stand so far before the eyeballs' middles.
constexpr std::array<double, 2> kGlassesAhead_m = {0.023, 0.029};

double drawn(const std::array<double, 2>& range, Random& random) {
  return random.uniform(range[0], range[1]);
}

/// The middle between the eyes: of the eyeballs, or of the lids' corners where there are none.
Result<Vec3f> middle_of_eyes(const face::Face& face) {
  if (face.eyes[0].vertex_count > 0 && face.eyes[1].vertex_count > 0)
    return Vec3f(0.5F * (face.eyes[0].centre_m + face.eyes[1].centre_m));
  if (!face.has_landmarks)
    return fail(ErrorCode::not_found,
                "the face has neither eyeballs nor landmarks, so a headset cannot be put on", face.name,
                "use the built-in face, an ICT-FaceKit folder, or a head with 68 landmarks");
  Vec3f sum = Vec3f::Zero();
  for (const std::size_t corner : {36, 39, 42, 45}) sum += face.neutral_m[face.landmarks[corner]];
  return Vec3f(0.25F * sum - Vec3f(0, 0, 0.011F));
}

/// The skin that a headset must not stand in.
class NeutralSkin {
 public:
  explicit NeutralSkin(const face::Face& face) : face_(face), normals_(face.neutral_m.size()) {
    face::vertex_normals(face, face.neutral_m, normals_);
    const std::vector<bool> is_skin = face.vertices_of(Material::skin);
    for (std::uint32_t v = 0; v < is_skin.size(); ++v)
      if (is_skin[v]) skin_.push_back(v);
    if (skin_.empty())
      for (std::uint32_t v = 0; v < is_skin.size(); ++v) skin_.push_back(v);
  }
  /// How far a place is from the nearest vertex, below 0 where it lies behind the surface there.
  [[nodiscard]] float height_m(const Vec3f& p_m) const {
    std::uint32_t nearest = skin_[0];
    float best = std::numeric_limits<float>::max();
    for (const std::uint32_t v : skin_)
      if (const float square = (face_.neutral_m[v] - p_m).squaredNorm(); square < best) {
        best = square;
        nearest = v;
      }
    return std::copysign(std::sqrt(best), normals_[nearest].dot(p_m - face_.neutral_m[nearest]));
  }

 private:
  const face::Face& face_;
  std::vector<Vec3f> normals_;
  std::vector<std::uint32_t> skin_;
};

/// How much of each vertex a beard covers, or a moustache: by landmarks.
std::vector<float> beard_of(const face::Face& face, bool moustache_only, float density) {
  const auto mark = [&](std::size_t i) { return face.neutral_m[face.landmarks[i]]; };
  const float corner_m = 0.5F * (mark(54).x() - mark(48).x()), nose_m = mark(33).y(), lip_m = mark(51).y();
  const float mouth_m = 0.5F * (mark(48).y() + mark(54).y());
  std::vector<float> amount(face.neutral_m.size(), 0.0F);
  for (std::size_t v = 0; v < face.neutral_m.size(); ++v) {
    const Vec3f& p = face.neutral_m[v];
    const float x = std::abs(p.x() - mark(33).x());
    // Its upper edge sinks from the nose to the mouth's corners and beyond.
    const float edge_m = nose_m - 0.002F - 0.55F * std::max(0.0F, x - 0.35F * corner_m);
    float here = smoothstep(edge_m + 0.002F, edge_m - 0.003F, p.y());
    if (moustache_only)
      here *= smoothstep(lip_m - 0.006F, lip_m - 0.001F, p.y()) *
              smoothstep(1.4F * corner_m, 1.1F * corner_m, x) * (p.y() > mouth_m - 0.004F ? 1.0F : 0.0F);
    amount[v] = density * here;
  }
  return amount;
}

void draw_looks(HeadsetWearer& wearer, const HeadsetFaults& faults, Random random) {
  render::InfraredWearer& looks = wearer.looks;
  const face::Face& face = wearer.face;
  Random skin = random.fork("skin"), paint = random.fork("make-up"), hair = random.fork("hair");
  Random eyes = random.fork("eyes"), glasses = random.fork("glasses");

  const auto gain = static_cast<float>(skin.log_normal(faults.skin_gain));
  const bool made_up = paint.chance(faults.make_up);
  const auto pores = static_cast<float>(faults.pores * skin.log_normal(0.4) * (made_up ? 0.5 : 1.0));
  const auto grain_m = static_cast<float>(skin.uniform(0.4e-3, 3e-3));
  const Vec3f offset = skin.normal_vector(1).cast<float>();
  const auto lids = static_cast<float>(made_up ? paint.uniform(0.45, 0.95) : paint.uniform(0.9, 1.02));
  const auto lips = static_cast<float>(made_up ? paint.uniform(0.6, 1.15) : paint.uniform(0.85, 1.05));
  const auto inside = static_cast<float>(paint.uniform(0.7, 1.2)),
             teeth = static_cast<float>(paint.uniform(0.75, 1.05));
  const std::array<Vec3f, 2> eye_m = {face.eyes[0].centre_m, face.eyes[1].centre_m};
  looks.repaint = [=](const Vec3f& p, Material material, float albedo) {
    switch (material) {
      case Material::skin:
      case Material::lips: {
        const float grain = render::solid_noise(p / grain_m + offset) +
                            0.6F * render::solid_noise(p / (0.4F * grain_m) + offset);
        float painted = albedo * gain * (1 + pores * grain);
        for (const Vec3f& eye : eye_m)
          painted *= std::lerp(
              1.0F, lids,
              smoothstep(0.023F, 0.015F, (p - eye).norm()) * smoothstep(-0.004F, 0.004F, p.y() - eye.y()));
        return material == Material::lips ? painted * lips : painted;
      }
      case Material::teeth:
        return albedo * teeth;
      default:
        return albedo * inside;
    }
  };

  looks.lash_cover = static_cast<float>(made_up ? paint.uniform(0.9, 1.5) : paint.uniform(0.25, 1.1));
  looks.beard_albedo = static_cast<float>(hair.uniform(0.07, 0.45));
  const bool beard = hair.chance(faults.beard), moustache = hair.chance(faults.moustache);
  if (face.has_landmarks && (beard || moustache))
    looks.beard = beard_of(face, !beard, static_cast<float>(hair.uniform(0.35, 1.0)));
  else if (face.has_landmarks && hair.chance(faults.stubble))
    looks.beard = beard_of(face, false, static_cast<float>(hair.uniform(0.1, 0.32)));

  wearer.pupil_mm = drawn(faults.pupil_mm, eyes);
  const auto iris = static_cast<float>(eyes.uniform(0.11, 0.34)),
             fibres = static_cast<float>(eyes.uniform(0.1, 0.6));
  const auto sclera = static_cast<float>(eyes.uniform(0.45, 0.72)),
             limbus = static_cast<float>(eyes.normal(5.85e-3, 0.2e-3));
  for (render::InfraredEye& eye : looks.eyes)
    eye = {.iris = iris,
           .sclera = sclera,
           .fibres = fibres,
           .limbus_m = limbus,
           .person = static_cast<float>(eyes.uniform(0, 100))};

  if (glasses.chance(faults.spectacles)) {
    const auto ahead = static_cast<float>(drawn(kGlassesAhead_m, glasses));
    const Vec3f bridge = 0.5F * (eye_m[0] + eye_m[1]) + Vec3f(0, -0.002F, ahead);
    Obstacle frame = make_spectacles(0.5F * (eye_m[0] - eye_m[1]).norm(), glasses);
    for (Vec3f& vertex : frame.vertices_m) vertex += bridge;
    looks.things.push_back(frame.thing);
    wearer.things_m = std::move(frame.vertices_m);
    const auto tilt = static_cast<float>(glasses.uniform(0.05, 0.2));
    for (const Vec3f& eye : eye_m)
      looks.glasses.push_back({.centre_m = Vec3f(eye.x(), bridge.y(), bridge.z()),
                               .forward = Vec3f(0, -std::sin(tilt), std::cos(tilt)),
                               .radius_m = 0.022F,
                               .curve_m = static_cast<float>(glasses.uniform(0.08, 0.25))});
  }
}

}  // namespace

Result<HeadsetWearer> seat_headset(face::Face face, const sensor::Rig& rig, const HeadsetFaults& faults,
                                   const Random& random) {
  HeadsetWearer wearer;
  MIEN_TRY_ASSIGN(const Vec3f middle_m, middle_of_eyes(face));
  MIEN_TRY_ASSIGN(const Vec3f usual_m, middle_of_eyes(builtin_face::default_builtin()));
  wearer.face = std::move(face);
  draw_looks(wearer, faults, random.fork("looks"));

  Random glued = random.fork("glued"), lamps = random.fork("lamps");
  Vec3f shift_m = middle_m - usual_m;
  std::vector<std::pair<std::string, Vec3f>> solid;  // What must not stand in the skin.
  for (const sensor::Mount& mount : rig.sensors) {
    if (!mount.camera || !mount.position_m) continue;
    FittedCamera camera{.name = mount.name, .of_mouth = mount.site == "mouth", .mount = *mount.camera};
    camera.position_m = (*mount.position_m + glued.normal_vector(1e-3 * faults.camera_mm)).cast<float>();
    const Vec3 sight = mount.camera->look_at_m - *mount.position_m;
    const Vec3 turn = glued.normal_vector(kDeg * faults.camera_deg);
    const Quat askew = exp_rotation(turn);
    camera.look_at_m = camera.position_m + (askew * sight).cast<float>();
    camera.up = (askew * mount.camera->up).cast<float>();
    const double field_deg = mount.camera->field_of_view_deg + glued.normal(0, faults.field_of_view_deg);
    camera.field_of_view_rad = static_cast<float>(kDeg * std::clamp(field_deg, kNarrowest_deg, kWidest_deg));
    // Not so bent that the picture's corners fold over.
    camera.radial_k1 = static_cast<float>(
        std::clamp(mount.camera->radial_k1 + glued.normal(0, faults.radial_k1), -0.1, 0.3));
    camera.centre = Eigen::Vector2f(static_cast<float>(0.5 + glued.normal(0, faults.centre)),
                                    static_cast<float>(0.5 + glued.normal(0, faults.centre)));
    for (const sensor::Lamp& lamp : mount.camera->lamps) {
      const double narrow = std::log(0.5) / std::log(std::cos(kDeg * lamp.half_angle_deg));
      const double whole = 1e-3 * lamp.power_mw * (narrow + 1) / (2 * std::numbers::pi);
      const double drawn_gain = lamps.log_normal(faults.lamp_gain);
      const bool dead = lamps.chance(faults.lamp_dead);
      solid.emplace_back("a lamp of " + mount.name, lamp.position_m.cast<float>());
      wearer.lamps.push_back({.position_m = lamp.position_m.cast<float>(),
                              .aim = lamp.aim.cast<float>(),
                              .intensity = dead ? 0.0F : static_cast<float>(whole * drawn_gain),
                              .narrow = std::abs(narrow - 1) < 1e-3 ? 1.0F : static_cast<float>(narrow)});
    }
    solid.emplace_back(mount.name, camera.position_m);
    wearer.cameras.push_back(std::move(camera));
  }
  if (wearer.cameras.empty())
    return fail(ErrorCode::not_found, "the rig has no cameras", rig.name,
                "give it sensors of kind \"camera\"");

  const NeutralSkin skin(wearer.face);
  // Inside the head by its own place: no push mends that.
  for (const auto& [name, place_m] : solid)
    if (skin.height_m(place_m + shift_m) < -kPush_m * kPushes)
      return fail(ErrorCode::out_of_range, fmt::format("{} is inside the head", name), rig.name,
                  "give it a position_m before the face, in metres, frame H");
  for (int i = 0; i < kPushes; ++i) {
    if (std::ranges::all_of(
            solid, [&](const auto& part) { return skin.height_m(part.second + shift_m) > kClearance_m; }))
      break;
    shift_m.z() += kPush_m;
  }
  for (const auto& [name, place_m] : solid)
    if (skin.height_m(place_m + shift_m) <= 0)
      return fail(ErrorCode::out_of_range, fmt::format("{} is inside the head", name), rig.name,
                  "give it a position_m before the face, in metres, frame H");
  for (FittedCamera& camera : wearer.cameras) {
    camera.position_m += shift_m;
    camera.look_at_m += shift_m;
    wearer.middle_m += camera.position_m / static_cast<float>(wearer.cameras.size());
  }
  for (render::InfraredLamp& lamp : wearer.lamps) lamp.position_m += shift_m;
  return wearer;
}

Result<HeadsetWearer> draw_headset_wearer(const sensor::Rig& rig, const HeadsetFaults& faults,
                                          const Random& random) {
  Random who = random.fork("identity");
  builtin_face::BuiltinParameters person = builtin_face::without_hair(builtin_face::random_identity(who));
  face::Face face = builtin_face::make_builtin(person);
  builtin_face::paint_infrared(face, person);
  face::SkinMarks marks = builtin_face::skin_marks(person, face);
  MIEN_TRY_ASSIGN(HeadsetWearer wearer, seat_headset(std::move(face), rig, faults, random));
  wearer.looks.marks = std::move(marks);
  return wearer;
}

}  // namespace mien::virt
