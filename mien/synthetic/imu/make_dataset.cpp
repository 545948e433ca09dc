#include "mien/synthetic/imu/make_dataset.h"

#include <algorithm>
#include <limits>
#include <numbers>
#include <optional>

#include "mien/builtin_face/builtin_face.h"
#include "mien/builtin_face/load_face.h"
#include "mien/core/toml.h"
#include "mien/face/livelink_csv.h"
#include "mien/performer/head_motion.h"
#include "mien/performer/performer.h"
#include "mien/performer/prologue.h"
#include "mien/performer/recorded_motion.h"
#include "mien/performer/script.h"
#include "mien/performer/style.h"
#include "mien/solve/trace_features.h"
#include "mien/synthetic/recipe_table.h"
#include "mien/virtual/imu/device_faults.h"
#include "mien/virtual/imu/imu_session.h"
#include "mien/virtual/performers.h"

namespace mien::synthetic {
namespace {

/// How much longer a long device session is.
constexpr double kLong = 2.5;

/// Where people come from.
struct FaceSource {
  std::optional<face::IctModel> ict;
  std::optional<face::Face> one;  // A face without a family.
};

Result<FaceSource> open_faces(const std::string& what, const Progress& progress) {
  FaceSource source;
  if (what == "builtin") return source;
  if (what.ends_with(".glb") || what.ends_with(".gltf") || what.ends_with(".vrm")) {
    MIEN_TRY_ASSIGN(source.one, builtin_face::load_face(what, progress));
    return source;
  }
  MIEN_TRY_ASSIGN(source.ict, face::import_ict_model(what, {.identities = true}, progress));
  return source;
}

face::Face draw_face(const FaceSource& source, bool identities, Random random) {
  if (source.one) return *source.one;
  if (!source.ict)
    return identities ? builtin_face::make_builtin(without_hair(builtin_face::random_identity(random)))
                      : builtin_face::make_builtin();
  if (!identities) return source.ict->face;
  std::vector<float> coefficients(source.ict->identities.size());
  for (float& c : coefficients) c = static_cast<float>(random.normal());
  return face::with_identity(*source.ict, coefficients);
}

/// Slopes of the face sensors' sites, as model::Skin has them: of a weight in the middle of what is
/// performed.
std::vector<float> slopes_of(const sensor::Rig& rig, const std::vector<virt::SkinSite>& sites) {
  constexpr float kUsualWeight = 0.6F;
  std::vector<virt::SkinSite> on_face;
  for (const std::uint16_t s : rig.face_sensors()) on_face.push_back(sites[s]);
  const Eigen::MatrixXd slopes = virt::rotation_slopes(on_face, kUsualWeight);
  std::vector<float> out;
  for (Eigen::Index row = 0; row < slopes.rows(); ++row)
    for (Eigen::Index k = 0; k < slopes.cols(); ++k) out.push_back(static_cast<float>(slopes(row, k)));
  return out;
}

/// The skin that everybody's is drawn around.
Result<std::vector<float>> standard_slopes(const FaceSource& faces, const sensor::Rig& rig) {
  MIEN_TRY_ASSIGN(const std::vector<virt::SkinSite> sites,
                  virt::skin_sites(draw_face(faces, false, Random(0)), rig));
  return slopes_of(rig, sites);
}

/// One performer's sequences, lab first.
Result<std::vector<dataset::Sequence>> perform_one(const DataRecipe& recipe, const FaceSource& faces,
                                                   const sensor::Rig& rig, const virt::DeviceFaults& faults,
                                                   const std::vector<float>& standard,
                                                   std::span<const face::Motion> recorded,
                                                   std::uint32_t performer) {
  const Random root = Random(recipe.seed).fork("performer", performer);
  const face::Face face = draw_face(faces, recipe.identities, root.fork("identity"));
  // People are unlike the standard skin by anything from not at all to what the recipe says.
  Random unlike_random = root.fork("unlike");
  const double unlike = unlike_random.uniform();
  const std::vector<Vec3> offsets_m =
      virt::draw_placement(rig, 1e-3 * unlike * recipe.placement_mm, root.fork("placement"));
  MIEN_TRY_ASSIGN(const std::vector<virt::SkinSite> mesh_sites, virt::skin_sites(face, rig, offsets_m));
  const std::vector<virt::SkinSite> sites =
      virt::draw_kinematics(mesh_sites, recipe.kinematics.times(unlike), root.fork("kinematics"));
  Random style_random = root.fork("style");
  const performer::Style style = performer::draw_style(style_random);
  const std::vector<std::uint16_t> face_sensors = rig.face_sensors();
  std::vector<float> slopes = slopes_of(rig, sites);
  const face::BlendshapeWeights told = performer::prompted_shapes();
  for (std::size_t i = 0; i < slopes.size(); ++i)
    if (told[i % face::kShapeCount] == 0) slopes[i] = standard[i];

  const bool held_out = performer >= static_cast<std::uint32_t>(recipe.performers);
  // Nobody recorded is left to validate on.
  const bool replays =
      !recorded.empty() && !held_out && root.fork("recorded").uniform() < recipe.recorded_share;
  std::vector<dataset::Sequence> out;
  Random script_random = root.fork("script");
  const auto perform = [&](double seconds, bool moves_head, const Random& random) {
    if (replays) return performer::perform_recorded(recorded, seconds, style, random);
    performer::Script script = performer::random_script(seconds, script_random);
    script.moves_head = moves_head;
    return performer::perform(script, style, random);
  };
  if (recipe.seconds > 0) {
    const face::Motion motion = perform(recipe.seconds, false, root.fork("motion"));
    dataset::Sequence lab;
    lab.performer = performer;
    lab.lab = true;
    lab.slopes = slopes;
    std::vector<model::SensorFeature> sensors(face_sensors.size());
    for (const face::MotionFrame& frame : motion.frames) {
      for (std::size_t s = 0; s < face_sensors.size(); ++s) {
        sensors[s].rotation = wxyz_of(sites[face_sensors[s]].rotation(frame.weights));
        sensors[s].has_rotation = true;
      }
      dataset::append_frame(sensors, frame.weights, lab);
    }
    out.push_back(std::move(lab));
  }
  if (recipe.device_seconds > 0 && (held_out || root.fork("device share").uniform() < recipe.device_share)) {
    // Some sessions are long, since headings drift, and in half of them the head moves as people wear such
    // things: nodding, turning, walking, whatever the face does.
    Random session_random = root.fork("device session");
    const double seconds =
        recipe.device_seconds * (session_random.chance(recipe.device_long_share) ? kLong : 1);
    face::Motion motion = perform(seconds, true, root.fork("device motion"));
    if (session_random.chance(recipe.device_moving_share))
      motion = performer::with_head_motion(motion, root.fork("head"));
    const performer::PrologueMotion begun =
        performer::with_prologue(motion, performer::PrologueKind::brief, root.fork("prologue"));
    MIEN_TRY_ASSIGN(const virt::VirtualSession session,
                    virt::play_devices(begun, sites, rig, faults, root.fork("devices")));
    MIEN_TRY_ASSIGN(const std::vector<model::FeatureFrame> features,
                    solve::trace_features(rig, session.events, session.entries, session.ticks));
    dataset::Sequence device;
    device.performer = performer;
    device.slopes = slopes;
    for (std::size_t i = 0; i < features.size(); ++i)
      if (session.truth[i].evaluated)
        dataset::append_frame(features[i].sensors, session.truth[i].weights, device);
    out.push_back(std::move(device));
  }
  return out;
}

}  // namespace

Result<DataRecipe> parse_data_recipe(std::string_view text, const std::string& where) {
  MIEN_TRY_ASSIGN(const toml::table table, parse_toml(text, where + ", [data]"));
  constexpr std::int64_t kMostPeople = 1'000'000;
  constexpr double kMostSeconds = 86'400;  // A day.
  DataRecipe recipe;
  double kinematics_deg = recipe.kinematics.direction_rad * 180 / std::numbers::pi;
  RecipeTable data(table, "data.", where);
  data.number("seed", recipe.seed, 0, std::numeric_limits<std::int64_t>::max());
  data.number("performers", recipe.performers, 1, kMostPeople);
  data.number("validation_performers", recipe.validation_performers, 1, kMostPeople);
  data.number("seconds", recipe.seconds, 0, kMostSeconds);
  data.number("device_seconds", recipe.device_seconds, 0, kMostSeconds);
  data.number("device_share", recipe.device_share, 0, 1);
  data.number("device_long_share", recipe.device_long_share, 0, 1);
  data.number("device_moving_share", recipe.device_moving_share, 0, 1);
  data.flag("identities", recipe.identities);
  data.number("placement_mm", recipe.placement_mm, 0, 50);
  data.number("kinematics_gain", recipe.kinematics.gain, 0, 10);
  data.number("kinematics_deg", kinematics_deg, 0, 180);
  data.number("recorded_share", recipe.recorded_share, 0, 1);
  data.texts("recorded", recipe.recorded);
  MIEN_TRY(data.finish());
  if (table.contains("kinematics_deg"))
    recipe.kinematics.direction_rad = kinematics_deg * std::numbers::pi / 180;
  for (const double seconds : {recipe.seconds, recipe.device_seconds})
    if (seconds > 0 && seconds < 1)
      return fail(ErrorCode::out_of_range, "data.seconds and data.device_seconds must be 0 or at least 1",
                  where);
  for (const std::string& name : recipe.recorded)
    if (name.empty() || std::filesystem::path(name).filename() != name)
      return fail(ErrorCode::out_of_range, "data.recorded must be names of files, without a folder", where);
  if ((recipe.recorded_share > 0) == recipe.recorded.empty())
    return fail(ErrorCode::out_of_range, "data.recorded_share and data.recorded need each other", where);
  if (recipe.seconds == 0 && (recipe.device_seconds == 0 || recipe.device_share == 0))
    return fail(ErrorCode::out_of_range, "[data] seconds and device_seconds leave nothing to perform", where);
  return recipe;
}

Result<std::vector<face::Motion>> read_recorded(const DataRecipe& recipe,
                                                const std::filesystem::path& folder) {
  std::vector<face::Motion> out;
  for (const std::string& name : recipe.recorded) {
    const std::filesystem::path path = folder / name;
    MIEN_TRY_ASSIGN(out.emplace_back(), face::load_motion(path));
    const auto with_face = std::ranges::count(out.back().frames, true, &face::MotionFrame::has_face);
    if (with_face < 2 || out.back().duration_s() < 1)
      return fail(ErrorCode::out_of_range, "less than a second of it shows a face", path.string(),
                  "take it out of data.recorded");
  }
  return out;
}

Result<dataset::TrainingData> make_dataset(const DataRecipe& recipe, const std::string& face_name,
                                           const sensor::Rig& rig, const Progress& progress, unsigned threads,
                                           std::span<const face::Motion> recorded) {
  MIEN_TRY_ASSIGN(const virt::DeviceFaults faults, virt::parse_faults(rig.faults_toml, rig.name));
  MIEN_TRY_ASSIGN(const FaceSource faces, open_faces(face_name, progress));
  MIEN_TRY_ASSIGN(const std::vector<float> standard, standard_slopes(faces, rig));
  const auto count = static_cast<std::size_t>(recipe.performers + recipe.validation_performers);
  std::vector<std::vector<dataset::Sequence>> performed(count);
  MIEN_TRY(virt::for_each_performer(count, threads, progress, [&](std::size_t p) -> Result<void> {
    MIEN_TRY_ASSIGN(performed[p], perform_one(recipe, faces, rig, faults, standard, recorded,
                                              static_cast<std::uint32_t>(p)));
    return {};
  }));

  dataset::TrainingData data;
  data.train.sensors = rig.face_sensor_names();
  data.validation.sensors = data.train.sensors;
  data.train.standard_slopes = data.validation.standard_slopes = standard;
  for (std::size_t p = 0; p < count; ++p)
    for (dataset::Sequence& sequence : performed[p])
      (p < static_cast<std::size_t>(recipe.performers) ? data.train : data.validation)
          .sequences.push_back(std::move(sequence));
  return data;
}

}  // namespace mien::synthetic
