#include "lab/eyewear/watched_wearer.h"

#include <algorithm>
#include <cstring>
#include <iterator>
#include <map>
#include <memory>
#include <string_view>
#include <utility>

#include "lab/worsened.h"
#include "mien/core/draw_first.h"
#include "mien/core/time.h"
#include "mien/eyewear/light_grid.h"
#include "mien/eyewear/normalisation.h"
#include "mien/synthetic/shifted_person.h"
#include "mien/virtual/eyewear/eyewear_faults.h"
#include "mien/virtual/eyewear/eyewear_simulator.h"
#include "mien/virtual/eyewear/eyewear_wearer.h"
#include "mien/virtual/network.h"
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

using Samples = std::vector<sensor::Sample>;

/// A network between the board and whoever receives it: a packet is one scan of all sensors.
void send_through(const virt::NetworkSettings& network, const Random& random, Samples& samples) {
  std::vector<virt::Datagram> sent;
  std::vector<std::size_t> begin;  // Of each packet's samples.
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (i > 0 && samples[i].sequence == samples[i - 1].sequence) continue;
    const std::size_t packet = begin.size();
    virt::Datagram& datagram = sent.emplace_back();
    datagram.time = HostTime(samples[i].time.time_since_epoch());
    datagram.bytes.resize(sizeof packet);
    std::memcpy(datagram.bytes.data(), &packet, sizeof packet);
    begin.push_back(i);
  }
  begin.push_back(samples.size());
  const auto arrived = virt::deliver(sent, network, random);
  Samples out;
  // The settings are this file's own, so they are within their ranges.
  for (const virt::Datagram& datagram : arrived.value()) {
    std::size_t packet = 0;
    std::memcpy(&packet, datagram.bytes.data(), sizeof packet);
    for (std::size_t i = begin[packet]; i < begin[packet + 1]; ++i) out.push_back(samples[i]);
  }
  samples = std::move(out);
}

/// Nothing is heard for two seconds, half-way.
void silence(Samples& samples) {
  if (samples.empty()) return;
  const DeviceTime first = samples.front().time;
  const DeviceTime middle = first + (samples.back().time - first) / 2;
  std::erase_if(samples, [&](const sensor::Sample& sample) {
    return sample.time >= middle && sample.time < middle + std::chrono::seconds(2);
  });
}

/// One sensor says what it said first.
void freeze(Random random, Samples& samples) {
  std::map<std::uint16_t, sensor::Sample> first;
  for (const sensor::Sample& sample : samples) first.try_emplace(sample.sensor, sample);
  if (first.empty()) return;
  const auto& [number, held] =
      *std::next(first.begin(), static_cast<std::ptrdiff_t>(random.below(first.size())));
  for (sensor::Sample& sample : samples)
    if (sample.sensor == number) sample.values = held.values;
}

struct GlassesFault {
  std::string_view name;
  /// Each may be null: nothing.
  void (*worsen)(virt::EyewearFaults&) = nullptr;
  void (*spoil)(const Random&, Samples&) = nullptr;
  WornLater::Remount remount = WornLater::Remount::no;
};

const std::vector<GlassesFault>& glasses_faults() {
  using Remount = WornLater::Remount;
  using Faults = virt::EyewearFaults;
  static const std::vector<GlassesFault> faults = {
      {"clean"},
      {"20 % lost", nullptr, [](const Random& r, Samples& s) { send_through({.loss = 0.2}, r, s); }},
      {"20 % lost in bursts", nullptr,
       [](const Random& r, Samples& s) { send_through({.burst_share = 0.2, .burst_length = 40}, r, s); }},
      {"jitter 100 ms", nullptr, [](const Random& r, Samples& s) { send_through({.jitter_ms = 100}, r, s); }},
      {"20 % twice, out of order", nullptr,
       [](const Random& r, Samples& s) {
         send_through({.jitter_ms = 20, .jitter = virt::NetworkSettings::Jitter::uniform, .duplicated = 0.2},
                      r, s);
       }},
      {"silent for 2 s", nullptr, [](const Random&, Samples& s) { silence(s); }},
      {"1 frozen", nullptr, [](const Random& r, Samples& s) { freeze(r, s); }},
      {"put on again", nullptr, nullptr, Remount::uncalibrated},
      {"put on again, 5 s of neutral", nullptr, nullptr, Remount::calibrated},
      {"slip 5 times as much", worsened<5, &Faults::slip_mm_per_sqrt_min, &Faults::slip_deg_per_sqrt_min>},
      {"sway 3 times as much", worsened<3, &Faults::sway_mm, &Faults::sway_deg>},
      {"ride up 3 times as much", worsened<3, &Faults::ride_up_mm>},
      {"folds 3 times as high", worsened<3, &Faults::tissue_mm>},
      {"light that saturates",
       [](Faults& f) {
         f.ambient = {0.3, 0.9};
       }},
      {"lamps that change 5 times as much",
       [](Faults& f) {
         f.ambient_walk_per_sqrt_min *= 5;
         f.ambient_flicker = 1;
       }},
      {"blood and sweat 5 times as much",
       worsened<5, &Faults::blush_per_sqrt_min, &Faults::sweat_per_sqrt_min>},
      {"readings 10 times as noisy", worsened<10, &Faults::noise_counts>},
  };
  return faults;
}

class FaultyGlasses final : public synthetic::FaultyPerson {
 public:
  /// What all of a group share.
  struct Worn {
    eyewear::MarkerNetworkFile model;
    eyewear::MarkedFace marked;
    sensor::Rig rig;
    virt::EyewearFaults faults;  // The rig's own.
  };
  FaultyGlasses(std::shared_ptr<const Worn> worn, Wearer wearer, Random root)
      : worn_(std::move(worn)), wearer_(std::move(wearer)), root_(root) {}

  [[nodiscard]] Result<void> watch_each(const See& see) const override {
    std::size_t number = 0;
    for (const GlassesFault& fault : glasses_faults()) {
      virt::EyewearFaults faults = worn_->faults;
      if (fault.worsen != nullptr) fault.worsen(faults);
      WornLater later{.remount = fault.remount, .spoil = {}};
      if (fault.spoil != nullptr)
        later.spoil = [&](Samples& samples) { fault.spoil(root_.fork("spoil"), samples); };
      std::vector<LightPerson> one(1);
      MIEN_TRY_ASSIGN(one.front(),
                      wear_glasses(wearer_.motion, wearer_.face, worn_->rig, faults, later, root_));
      MIEN_TRY_ASSIGN(const synthetic::WatchedGroup group,
                      watched_by(worn_->model, worn_->marked, eyewear::photo_sensor_names(worn_->rig), {},
                                 std::move(one)));
      MIEN_TRY_ASSIGN(const synthetic::Watched seen, group.people.front()->watch(0, root_));
      see(number++, seen);
    }
    return {};
  }

 private:
  std::shared_ptr<const Worn> worn_;
  Wearer wearer_;
  Random root_;
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

Result<synthetic::FaultyGroup> faulty_wearers(const eyewear::MarkerNetworkFile& model,
                                              const eyewear::MarkedFace& marked, const sensor::Rig& rig,
                                              std::string who, int people, double seconds, bool shifted,
                                              std::uint64_t seed) {
  MIEN_TRY_ASSIGN(const virt::EyewearFaults faults, virt::parse_eyewear_faults(rig.faults_toml, rig.name));
  MIEN_TRY(watched_by(model, marked, eyewear::photo_sensor_names(rig), {}, {}));
  const auto worn =
      std::make_shared<const FaultyGlasses::Worn>(FaultyGlasses::Worn{model, marked, rig, faults});
  synthetic::FaultyGroup group{std::move(who), {}, {}};
  for (const GlassesFault& fault : glasses_faults()) group.faults.emplace_back(fault.name);
  for (std::size_t p = 0; p < static_cast<std::size_t>(people); ++p) {
    const Random root = Random(seed).fork("faulty wearer", p);
    Wearer wearer;
    if (shifted && p % 2 == 1) {
      synthetic::ShiftedPerson person = synthetic::draw_shifted_person(p / 2, seconds, root);
      wearer = {std::move(person.face), std::move(person.motion)};
    } else {
      wearer = draw_wearer(seconds, root);
    }
    group.people.push_back(std::make_shared<const FaultyGlasses>(worn, std::move(wearer), root));
  }
  return group;
}

}  // namespace mien::lab
