#include "lab/eyewear/faulty_wearer.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <functional>
#include <iterator>
#include <map>
#include <string_view>
#include <utility>

#include "lab/eyewear/watched_wearer.h"
#include "mien/eyewear/light_grid.h"
#include "mien/synthetic/shifted_person.h"
#include "mien/virtual/eyewear/eyewear_faults.h"
#include "mien/virtual/network.h"

namespace mien::lab {
namespace {

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
      {"slip 5 times as much",
       [](Faults& f) {
         f.slip_mm_per_sqrt_min *= 5;
         f.slip_deg_per_sqrt_min *= 5;
       }},
      {"sway 3 times as much",
       [](Faults& f) {
         f.sway_mm *= 3;
         f.sway_deg *= 3;
       }},
      {"ride up 3 times as much", [](Faults& f) { f.ride_up_mm *= 3; }},
      {"folds 3 times as high", [](Faults& f) { f.tissue_mm *= 3; }},
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
       [](Faults& f) {
         f.blush_per_sqrt_min *= 5;
         f.sweat_per_sqrt_min *= 5;
       }},
      {"readings 10 times as noisy", [](Faults& f) { f.noise_counts *= 10; }},
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
