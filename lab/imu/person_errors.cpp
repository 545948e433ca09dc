#include "lab/imu/person_errors.h"

#include <vector>

#include "mien/core/units.h"
#include "mien/virtual/performers.h"

namespace mien::lab {
namespace {

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

void SeedErrors::add_seed(std::span<const PersonErrors> people) {
  for (SeedFigures* figures : {&pve_mm, &lmk_mm, &mse, &jitter}) figures->emplace_back();
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
        const Quat clean(sensor.rotation[0], sensor.rotation[1], sensor.rotation[2], sensor.rotation[3]);
        const Quat noisy = exp_rotation(noise.normal_vector(kLabNoiseRad)) * clean;
        sensor.rotation = {static_cast<float>(noisy.w()), static_cast<float>(noisy.x()),
                           static_cast<float>(noisy.y()), static_cast<float>(noisy.z())};
      }
  }
  return people;
}

}  // namespace mien::lab
