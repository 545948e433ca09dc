#include "lab/imu/short_training.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>
#include <vector>

#include "mien/core/nearest_word.h"
#include "mien/core/units.h"
#include "mien/virtual/performers.h"

namespace mien::lab {
namespace {

sensor::SkinMotion marginal(const sensor::SkinMotion& skin, std::span<const std::string> names) {
  sensor::SkinMotion out;
  std::vector<Eigen::Index> rows;
  for (std::size_t s = 0; s < skin.sensors.size(); ++s) {
    if (std::ranges::find(names, skin.sensors[s]) == names.end()) continue;
    out.sensors.push_back(skin.sensors[s]);
    for (Eigen::Index axis = 0; axis < 3; ++axis) rows.push_back(3 * static_cast<Eigen::Index>(s) + axis);
  }
  const Eigen::MatrixXd covariance = skin.factor_deg * skin.factor_deg.transpose();
  out.mean_deg = skin.mean_deg(rows);
  out.factor_deg = Eigen::MatrixXd(covariance(rows, rows)).llt().matrixL();
  return out;
}

/// Frames that a step sees.
constexpr std::size_t kFramesAStep = 3840;

std::string network_table(const ShortRecipe& recipe) {
  if (recipe.network == ShortNetwork::recurrent)
    return fmt::format("architecture = \"causal\"\nd_model = 128\nwindow = {}\ndropout = 0\n", recipe.window);
  return fmt::format(
      "architecture = \"light\"\nlayers = 2\nd_model = 128\nheads = 4\nd_head = 32\nffn = 256\nwindow = {}\n"
      "dropout = 0\nnear_first = true\n",
      recipe.window);
}

std::string network_settings(const ShortRecipe& recipe) {
  switch (recipe.network) {
    case ShortNetwork::recurrent:
      return "";
    case ShortNetwork::transformer:
      // Levels are drawn so near the noisiest that what it reads of the answer says nothing.
      return "\n[noise]\nt_bias = 100\n\n[sampler]\nsteps = [1]\nframes = 1200\n";
    case ShortNetwork::diffusion:
      return "\n[noise]\nheld_overlap = 0.25\n\n[sampler]\nsteps = [4]\nframes = 1200\n";
  }
  return "";
}

/// The profile's white noise, an axis.
constexpr double kLabNoiseRad = kRadPerDeg;

Result<PersonErrors> errors_of(const model::ModelFile& model, const std::vector<std::string>& sensors,
                               const synthetic::ImuPerson& person, const measure::Meter& meter,
                               synthetic::WindowJoin join) {
  MIEN_TRY_ASSIGN(const std::vector<face::BlendshapeWeights> answer,
                  synthetic::answers_of(model, sensors, person.features, join));
  const measure::Stretch stretch{person.truth, answer};
  const measure::Metrics metrics = meter.measure({&stretch, 1});
  return PersonErrors{.pve_mm = metrics.pve_mm.mean,
                      .lmk_mm = metrics.lmk_mm ? metrics.lmk_mm->mean : 0,
                      .mse = metrics.mse,
                      .jitter = metrics.jitter_ratio.value_or(0)};
}

}  // namespace

Result<sensor::Rig> rig_with_sensors(const sensor::Rig& rig, std::span<const std::string> names) {
  if (names.empty()) return fail(ErrorCode::bad_usage, "no sensor is left", "rig " + rig.name);
  const std::vector<std::string> all = rig.face_sensor_names();
  for (const std::string& name : names)
    if (std::ranges::find(all, name) == all.end())
      return fail(ErrorCode::not_found,
                  fmt::format("the rig has no face sensor {}{}", name, did_you_mean(name, all)),
                  "rig " + rig.name);
  if (names.size() == all.size()) return rig;
  sensor::Rig part = rig;
  std::erase_if(part.sensors, [&](const sensor::Mount& mount) {
    return mount.role == "face" && std::ranges::find(names, mount.name) == names.end();
  });
  if (!part.find(part.reference)) part.reference = names.front();
  if (rig.skin) {
    part.skin = marginal(*rig.skin, names);
    if (part.skin->sensors.empty()) part.skin.reset();
  }
  return part;
}

std::uint64_t recipe_seed(std::uint64_t seed) {
  constexpr std::uint64_t kLargest = std::numeric_limits<std::int64_t>::max();
  return seed & kLargest;
}

std::uint64_t training_seed(std::uint64_t study_seed, std::size_t training) {
  return recipe_seed(study_seed * 100 + training);
}

std::string data_table(const synthetic::DataRecipe& data) {
  return fmt::format(
      "seed = {}\nperformers = {}\nvalidation_performers = {}\nseconds = {}\ndevice_seconds = {}\n"
      "device_share = {}\nidentities = {}\nplacement_mm = {}\nkinematics_gain = {}\nkinematics_deg = {:g}\n",
      data.seed, data.performers, data.validation_performers, data.seconds, data.device_seconds,
      data.device_share, data.identities, data.placement_mm, data.kinematics.gain,
      data.kinematics.direction_rad * kDegPerRad);
}

std::string short_recipe(const ShortRecipe& recipe, const synthetic::DataRecipe& data) {
  const bool recurrent = recipe.network == ShortNetwork::recurrent;
  return fmt::format(
      "seed = {}\n\n[network]\n{}\n[data]\n{}\n[optimiser]\nlearning_rate = {}\nloss = \"l2\"\nbatch = {}\n"
      "warm_up_steps = {}\nema = 0.98\n{}\n[augmentation]\nsensor_loss = 0.02\nmany_lost = 0.02\n{}\n"
      "[validation]\nwindows = 200\nevery_steps = {}\n\n[budget]\nsteps = {}\n",
      recipe.seed, network_table(recipe), data_table(data), recurrent ? "4e-3" : "2e-3",
      kFramesAStep / recipe.window, std::min<std::size_t>(40, recipe.steps / 4),
      recurrent ? fmt::format("difference_weight = {}\n", recipe.difference_weight) : "",
      network_settings(recipe), std::max<std::size_t>(1, recipe.steps / 6), recipe.steps);
}

synthetic::DataRecipe short_data(std::uint64_t seed) {
  synthetic::DataRecipe data;
  data.seed = seed;
  data.performers = 300;
  data.validation_performers = 8;
  data.seconds = 24;
  data.device_seconds = 24;
  data.device_share = 0.4;
  data.kinematics = {.gain = 0.30, .direction_rad = 13 * kRadPerDeg};
  return data;
}

void SeedErrors::add_seed(std::span<const PersonErrors> people) {
  for (measure::SeedFigures* figures : {&pve_mm, &lmk_mm, &mse, &jitter}) figures->emplace_back();
  for (const PersonErrors& person : people) {
    pve_mm.back().push_back(person.pve_mm);
    lmk_mm.back().push_back(person.lmk_mm);
    mse.back().push_back(person.mse);
    jitter.back().push_back(person.jitter);
  }
}

Result<std::vector<PersonErrors>> errors_of_people(const model::ModelFile& model,
                                                   const std::vector<std::string>& sensors,
                                                   std::span<const synthetic::ImuPerson> people,
                                                   const measure::Meter& meter, synthetic::WindowJoin join,
                                                   unsigned threads) {
  std::vector<PersonErrors> out(people.size());
  MIEN_TRY(virt::for_each_performer(people.size(), threads, no_progress, [&](std::size_t p) -> Result<void> {
    MIEN_TRY_ASSIGN(out[p], errors_of(model, sensors, people[p], meter, join));
    return {};
  }));
  return out;
}

std::vector<synthetic::ImuPerson> watched_in_lab(const dataset::Dataset& data, std::uint64_t seed) {
  dataset::Dataset lab;
  lab.sensors = data.sensors;
  for (const dataset::Sequence& sequence : data.sequences)
    if (sequence.lab) lab.sequences.push_back(sequence);
  std::vector<synthetic::ImuPerson> people = synthetic::watched(lab);
  for (std::size_t p = 0; p < people.size(); ++p) {
    Random noise = Random(seed).fork("lab noise", p);
    for (model::FeatureFrame& frame : people[p].features)
      for (model::SensorFeature& sensor : frame.sensors) {
        const Quat clean = quat_of(sensor.rotation);
        sensor.rotation = wxyz_of(exp_rotation(noise.normal_vector(kLabNoiseRad)) * clean);
      }
  }
  return people;
}

}  // namespace mien::lab
