#include "mien/synthetic/eyewear/eyewear_dataset.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "mien/builtin_face/builtin_face.h"
#include "mien/core/toml.h"
#include "mien/eyewear/normalisation.h"
#include "mien/performer/canvas.h"
#include "mien/performer/mimic.h"
#include "mien/performer/performer.h"
#include "mien/performer/script.h"
#include "mien/performer/style.h"
#include "mien/synthetic/eyewear/worn_glasses.h"
#include "mien/synthetic/recipe_table.h"
#include "mien/virtual/eyewear/eyewear_faults.h"
#include "mien/virtual/eyewear/eyewear_wearer.h"
#include "mien/virtual/eyewear/marker_poses.h"
#include "mien/virtual/performers.h"

namespace mien::synthetic {
namespace {

using face::BlendshapeWeights;
using face::kShapeCount;
using face::kShapeNames;

constexpr double kPosesShare = 0.7;  // Of a wearer's performance.

bool may_be_posed(std::size_t shape) {
  return !kShapeNames[shape].starts_with("eyeLook") && kShapeNames[shape] != "mouthClose";
}

/// A few shapes at once, most of them on both sides.
BlendshapeWeights random_pose(Random& random) {
  constexpr std::uint64_t kMostShapes = 6;
  constexpr double kBothSides = 0.7;
  BlendshapeWeights pose;
  const std::uint64_t count = 1 + random.below(kMostShapes);
  for (std::uint64_t i = 0; i < count;) {
    const std::size_t k = random.below(kShapeCount);
    if (!may_be_posed(k)) continue;
    const auto weight = static_cast<float>(random.uniform(0.2, 1.0));
    pose[k] = weight;
    if (random.chance(kBothSides)) pose[performer::other_side(k)] = weight;
    ++i;
  }
  return pose;
}

/// Held poses, short and long.
face::Motion poses_motion(const virt::MarkerPoses& poses, double seconds, const Random& random) {
  Random drawn = random.fork("targets");
  std::vector<performer::PoseCue> cues;
  for (double at_s = 0; at_s < seconds;) {
    const double kind = drawn.uniform();
    performer::PoseCue& cue = cues.emplace_back();
    cue.begin_s = at_s;
    if (kind < 0.5)
      cue.target = poses.draw(drawn);
    else if (kind < 0.85)
      cue.target = random_pose(drawn);
    at_s += drawn.chance(0.5) ? drawn.uniform(1.5, 4) : drawn.uniform(4, 12);
  }
  return performer::mimic(cues, seconds, {}, random.fork("mimic"));
}

face::Motion script_motion(double seconds, const Random& random) {
  performer::Script script;
  for (const performer::Block block : {performer::Block::free, performer::Block::reading,
                                       performer::Block::range_of_motion, performer::Block::free})
    for (performer::Segment& segment : performer::default_script(block, seconds / 4).segments)
      script.segments.push_back(std::move(segment));
  Random style = random.fork("style");
  return performer::perform(script, performer::draw_style(style), random.fork("motion"));
}

/// The default identity's markers, which all wearers' are told as.
struct Markers {
  builtin_face::PlacedMarkers placed;
  Eigen::VectorXd neutral_m;
};

Result<LightSequence> wear(const EyewearDataRecipe& recipe, const sensor::Rig& rig,
                           const virt::EyewearFaults& faults, const virt::MarkerPoses& poses,
                           const Markers& markers, std::uint32_t index) {
  const Random root = Random(recipe.seed).fork("wearer", index);
  MIEN_TRY_ASSIGN(const virt::EyewearWearer wearer,
                  virt::draw_eyewear_wearer(rig, faults, root.fork("wearer")));
  virt::EyewearSimulator simulator(wearer, faults, root.fork("glasses"));
  simulator.put_on();

  WornGlasses session(simulator, rig);
  std::vector<eyewear::GridLight> lights;
  LightSequence out;
  out.wearer = index;
  const WornGlasses::See see = [&](const eyewear::GridLight& light, const BlendshapeWeights& weights) {
    lights.push_back(light);
    const Eigen::VectorXd moved_m = markers.placed.at(weights) - markers.neutral_m;
    for (const double m : moved_m) out.displacement_m.push_back(static_cast<float>(m));
  };
  const eyewear::Normalisation normalisation = session.first_minute(root.fork("minute"), see);
  const double poses_s = kPosesShare * recipe.seconds;
  session.play(poses_motion(poses, poses_s, root.fork("poses")), poses_s, see);
  const double script_s = recipe.seconds - poses_s;
  session.play(script_motion(script_s, root.fork("script")), script_s, see);

  out.frames = lights.size();
  eyewear::LightFrame features;
  for (const eyewear::GridLight& light : lights) {
    eyewear::read_features(normalisation, light, features);
    out.present.insert(out.present.end(), features.present.begin(), features.present.end());
    out.values.insert(out.values.end(), features.values.begin(), features.values.end());
  }
  return out;
}

}  // namespace

Result<EyewearDataRecipe> parse_eyewear_data_recipe(std::string_view text, const std::string& where) {
  MIEN_TRY_ASSIGN(const toml::table table, parse_toml(text, where + ", [data]"));
  constexpr std::int64_t kMostPeople = 100'000;
  EyewearDataRecipe recipe;
  RecipeTable data(table, "data.", where);
  data.number("seed", recipe.seed, 0, std::numeric_limits<std::int64_t>::max());
  data.number("wearers", recipe.wearers, 1, kMostPeople);
  data.number("validation_wearers", recipe.validation_wearers, 1, kMostPeople);
  data.number("seconds", recipe.seconds, 12, 3600);
  MIEN_TRY(data.finish());
  return recipe;
}

Result<EyewearData> make_eyewear_dataset(const EyewearDataRecipe& recipe, const sensor::Rig& rig,
                                         const builtin_face::MarkerSet& markers, const Progress& progress,
                                         unsigned threads) {
  MIEN_TRY_ASSIGN(const virt::EyewearFaults faults, virt::parse_eyewear_faults(rig.faults_toml, rig.name));
  MIEN_TRY_ASSIGN(
      const virt::MarkerPoses poses,
      virt::MarkerPoses::measure(markers, virt::kMeasuredBeforeS, Random(recipe.seed).fork("before")));
  MIEN_TRY_ASSIGN(builtin_face::PlacedMarkers placed,
                  builtin_face::PlacedMarkers::place(builtin_face::make_builtin(), markers));
  Eigen::VectorXd neutral_m = placed.at({});
  const Markers canonical{std::move(placed), std::move(neutral_m)};
  std::vector<LightSequence> sequences(static_cast<std::size_t>(recipe.wearers + recipe.validation_wearers));
  MIEN_TRY(
      virt::for_each_performer(sequences.size(), threads, progress, [&](std::size_t index) -> Result<void> {
        MIEN_TRY_ASSIGN(sequences[index],
                        wear(recipe, rig, faults, poses, canonical, static_cast<std::uint32_t>(index)));
        return {};
      }));
  EyewearData data;
  data.train.sensors = eyewear::photo_sensor_names(rig);
  for (const builtin_face::Marker& marker : markers.markers) data.train.markers.push_back(marker.name);
  data.train.face = eyewear::MarkedShapes{canonical.neutral_m, canonical.placed.shapes_m()};
  data.validation = data.train;
  const auto trained = sequences.begin() + recipe.wearers;
  std::move(sequences.begin(), trained, std::back_inserter(data.train.sequences));
  std::move(trained, sequences.end(), std::back_inserter(data.validation.sequences));
  return data;
}

}  // namespace mien::synthetic
