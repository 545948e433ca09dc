#include "lab/eyewear/watched_wearer.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "mien/core/draw_first.h"
#include "mien/core/time.h"
#include "mien/eyewear/normalisation.h"
#include "mien/synthetic/shifted_person.h"
#include "mien/virtual/eyewear/eyewear_simulator.h"
#include "mien/virtual/eyewear/eyewear_wearer.h"
#include "mien/virtual/performance.h"
#include "mien/virtual/performers.h"

namespace mien::lab {
namespace {

/// As many wearers as `people`, each as `watch` (of the index and the rig's faults) has them seen.
template <typename Watch>
Result<std::vector<LightPerson>> watch_each(int people, const sensor::Rig& rig, const Progress& progress,
                                            unsigned threads, const Watch& watch) {
  MIEN_TRY_ASSIGN(const virt::EyewearFaults faults, virt::parse_eyewear_faults(rig.faults_toml, rig.name));
  std::vector<LightPerson> out(static_cast<std::size_t>(people));
  MIEN_TRY(virt::for_each_performer(out.size(), threads, progress, [&](std::size_t p) -> Result<void> {
    MIEN_TRY_ASSIGN(out[p], watch(p, faults));
    return {};
  }));
  return out;
}

/// `lost` of so many sensors, drawn: a flag each.
std::vector<std::uint8_t> draw_lost(std::size_t sensors, std::size_t lost, Random random) {
  std::vector<std::uint8_t> out(sensors);
  std::vector<std::size_t> order(sensors);
  for (std::size_t i = 0; i < sensors; ++i) order[i] = i;
  draw_first(std::span(order), lost, random);
  for (std::size_t i = 0; i < std::min(lost, sensors); ++i) out[order[i]] = 1;
  return out;
}

class WatchedByGlasses final : public synthetic::WatchedPerson {
 public:
  WatchedByGlasses(std::shared_ptr<const eyewear::MarkerNetworkFile> model,
                   std::shared_ptr<const eyewear::MarkedFace> marked, std::vector<std::string> sensors,
                   LightPerson person)
      : model_(std::move(model)),
        marked_(std::move(marked)),
        sensors_(std::move(sensors)),
        person_(std::move(person)) {}
  [[nodiscard]] std::size_t sensor_count() const override { return sensors_.size(); }
  [[nodiscard]] Result<synthetic::Watched> watch(std::size_t lost, const Random& random) const override {
    MIEN_TRY_ASSIGN(auto regressor, eyewear::NetworkRegressor::create(*model_, sensors_));
    MIEN_TRY_ASSIGN(eyewear::LightModel answers, eyewear::LightModel::create(*marked_, std::move(regressor)));
    const std::vector<std::uint8_t> silent = draw_lost(sensors_.size(), lost, random);
    synthetic::Watched out{{}, {}, person_.truth};
    face::OutputFrame frame;
    for (eyewear::LightFrame light : person_.light) {
      for (std::size_t s = 0; s < silent.size(); ++s) {
        if (silent[s] == 0) continue;
        light.present[s] = 0;
        light.values[s] = 0;
      }
      answers.step(light, 1 / kFrameRateHz, frame);
      out.answer.push_back(frame.weights);
      out.coverage.emplace_back().fill(answers.coverage());
    }
    return out;
  }

 private:
  std::shared_ptr<const eyewear::MarkerNetworkFile> model_;
  std::shared_ptr<const eyewear::MarkedFace> marked_;
  std::vector<std::string> sensors_;  // Names of the lights' entries.
  LightPerson person_;
};

}  // namespace

Result<LightPerson> wear_glasses(const face::Motion& motion, const face::Face& face, const sensor::Rig& rig,
                                 const virt::EyewearFaults& faults, const WornLater& later,
                                 const Random& random) {
  MIEN_TRY_ASSIGN(const virt::EyewearWearer wearer,
                  virt::seat_eyewear(face, rig, faults, random.fork("wearer")));
  virt::EyewearSimulator simulator(wearer, faults, random.fork("glasses"));
  simulator.put_on();
  synthetic::WornGlasses session(simulator, rig);
  eyewear::Normalisation normalisation = session.first_minute(random.fork("minute"), {});
  if (later.remount != WornLater::Remount::no) simulator.put_on();
  if (later.remount == WornLater::Remount::calibrated)
    normalisation = session.hold_neutral(normalisation, random.fork("again"));
  session.spoil(later.spoil);
  LightPerson out;
  session.play(motion, motion.duration_s(),
               [&](const eyewear::GridLight& light, const face::BlendshapeWeights& weights) {
                 eyewear::read_features(normalisation, light, out.light.emplace_back());
                 face::BlendshapeWeights& truth = out.truth.emplace_back();
                 for (std::size_t k = 0; k < face::kShapeCount; ++k)
                   truth[k] = std::clamp(weights[k], 0.0F, 1.0F);
               });
  return out;
}

Wearer draw_wearer(double seconds, const Random& root) {
  virt::VirtualPerson person = virt::draw_person(root);
  return {std::move(person.face), virt::draw_motion(seconds, person.style, root)};
}

Result<std::vector<LightPerson>> watch_wearers(int people, double seconds, std::uint64_t seed,
                                               const sensor::Rig& rig, const Progress& progress,
                                               unsigned threads) {
  return watch_each(people, rig, progress, threads, [&](std::size_t p, const virt::EyewearFaults& faults) {
    const Random root = Random(seed).fork("wearer", p);
    const Wearer wearer = draw_wearer(seconds, root);
    return wear_glasses(wearer.motion, wearer.face, rig, faults, {}, root);
  });
}

Result<std::vector<LightPerson>> watch_shifted_wearers(int people, double seconds, std::uint64_t seed,
                                                       const sensor::Rig& rig, const Progress& progress,
                                                       unsigned threads) {
  return watch_each(people, rig, progress, threads, [&](std::size_t p, const virt::EyewearFaults& faults) {
    const Random root = Random(seed).fork("shifted wearer", p);
    const synthetic::ShiftedPerson person = synthetic::draw_shifted_person(p, seconds, root);
    return wear_glasses(person.motion, person.face, rig, faults, {}, root.fork("devices"));
  });
}

Result<LightPerson> watch_wearer(const face::Motion& motion, const face::Face& face, const sensor::Rig& rig,
                                 const Random& random) {
  MIEN_TRY_ASSIGN(const virt::EyewearFaults faults, virt::parse_eyewear_faults(rig.faults_toml, rig.name));
  return wear_glasses(motion, face, rig, faults, {}, random);
}

Result<synthetic::WatchedGroup> watched_by(const eyewear::MarkerNetworkFile& model,
                                           const eyewear::MarkedFace& marked,
                                           const std::vector<std::string>& sensors, std::string who,
                                           std::vector<LightPerson> people) {
  // What does not fit is told here, once.
  MIEN_TRY_ASSIGN(auto regressor, eyewear::NetworkRegressor::create(model, sensors));
  MIEN_TRY(eyewear::LightModel::create(marked, std::move(regressor)));
  const auto file = std::make_shared<const eyewear::MarkerNetworkFile>(model);
  const auto face = std::make_shared<const eyewear::MarkedFace>(marked);
  synthetic::WatchedGroup group{std::move(who), {}};
  for (LightPerson& person : people)
    group.people.push_back(std::make_shared<const WatchedByGlasses>(file, face, sensors, std::move(person)));
  return group;
}

}  // namespace mien::lab
