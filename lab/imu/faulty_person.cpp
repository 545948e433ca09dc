#include "lab/imu/faulty_person.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>
#include <vector>

#include "lab/imu/impair.h"
#include "lab/imu/loss.h"
#include "lab/worsened.h"
#include "mien/solve/trace_features.h"
#include "mien/synthetic/imu/watched_person.h"
#include "mien/synthetic/shifted_person.h"
#include "mien/virtual/imu/device_faults.h"
#include "mien/virtual/performance.h"

namespace mien::lab {
namespace {

/// What a session can be heard through.
std::vector<LossCondition> heard_faults(const sensor::Rig& rig) {
  std::vector<LossCondition> out = {{},
                                    {Fault::loss, 20, {}},
                                    {Fault::bursts, 20, {}},
                                    {Fault::jitter, 100, {}},
                                    {Fault::lag, 100, {}},
                                    {Fault::disorder, 20, {}},
                                    {Fault::corrupted, 5, {}},
                                    {Fault::truncated, 5, {}},
                                    {Fault::clock_drift, 50, {}},
                                    {Fault::restart, 0, {}},
                                    {Fault::frozen, 1, {}},
                                    {Fault::all_silent, 2, {}}};
  if (rig.face_sensors().size() > 1) out.push_back({Fault::shared_id, 0, {}});
  if (rig.face_sensors().size() > 3) out.push_back({Fault::sensors_silent, 3, {}});
  if (rig.head_sensor()) out.push_back({Fault::head_silent, 2, {}});
  return out;
}

/// What a session must be played anew for.
struct WornFault {
  std::string_view name;
  void (*worsen)(virt::DeviceFaults&);
};

constexpr std::array<WornFault, 7> kWornFaults = {{
    {"mountings slip 5 times as much", worsened<5, &virt::DeviceFaults::slip_deg_per_sqrt_min>},
    {"stuck up to 3 times as far off", worsened<3, &virt::DeviceFaults::mount_position_mm>},
    {"adhesive lags 3 times as long",
     [](virt::DeviceFaults& f) {
       for (double& lag_ms : f.adhesive_lag_ms) lag_ms *= 3;
     }},
    {"gyroscopes 5 times worse",
     worsened<5, &virt::DeviceFaults::gyro_noise_dps_sqrt_hz, &virt::DeviceFaults::gyro_bias_dps,
              &virt::DeviceFaults::gyro_bias_walk_dps_sqrt_min, &virt::DeviceFaults::gyro_scale>},
    {"accelerometers 5 times worse",
     worsened<5, &virt::DeviceFaults::accel_noise_ug_sqrt_hz, &virt::DeviceFaults::accel_bias_mg,
              &virt::DeviceFaults::accel_scale>},
    {"ranges of 64 deg/s and 2 g",
     [](virt::DeviceFaults& f) {
       f.gyro_range_dps = 64;
       f.accel_range_g = 2;
     }},
    {"sensors silent now and then", [](virt::DeviceFaults& f) { f.sensor_loss_per_hour = 60; }},
}};

/// Who performs, and on what skin.
struct Cast {
  face::Face face;
  face::Motion motion;
  virt::Wearing wearing;
};

class FaultyImuPerson final : public synthetic::FaultyPerson {
 public:
  FaultyImuPerson(std::shared_ptr<const model::ModelFile> model, std::shared_ptr<const sensor::Rig> rig,
                  virt::DeviceFaults faults, std::size_t index, double seconds, bool shifted, Random root)
      : model_(std::move(model)),
        rig_(std::move(rig)),
        faults_(faults),
        index_(index),
        seconds_(seconds),
        shifted_(shifted),
        root_(root) {}

  [[nodiscard]] Result<void> watch_each(const See& see) const override {
    const Cast cast = drawn();
    std::size_t fault = 0;
    {
      MIEN_TRY_ASSIGN(const virt::Performance played, perform(cast, cast.wearing));
      for (const LossCondition& condition : heard_faults(*rig_)) {
        const Random random = root_.fork("faults");
        MIEN_TRY_ASSIGN(const Impairment bad,
                        impairment(condition, *rig_, played.begin_s, played.end_s, random));
        MIEN_TRY_ASSIGN(const virt::VirtualSession heard,
                        impair(played.session, *rig_, bad.network, random.fork("network"), bad.troubles));
        MIEN_TRY(watch(heard, fault++, see));
      }
    }
    for (const WornFault& worn : kWornFaults) {
      virt::Wearing wearing = cast.wearing;
      worn.worsen(wearing.faults);
      Result<virt::Performance> played = perform(cast, wearing);
      // On some faces there is no skin so far off: then the sensors sit as far off as there is.
      while (!played && wearing.faults.mount_position_mm > cast.wearing.faults.mount_position_mm) {
        wearing.faults.mount_position_mm =
            std::max(wearing.faults.mount_position_mm - 1, cast.wearing.faults.mount_position_mm);
        played = perform(cast, wearing);
      }
      if (!played) return std::unexpected(std::move(played).error());
      MIEN_TRY(watch(played->session, fault++, see));
    }
    return {};
  }

 private:
  [[nodiscard]] Cast drawn() const {
    if (shifted_) {
      synthetic::ShiftedPerson person = synthetic::draw_shifted_person(index_, seconds_, root_);
      return {std::move(person.face), std::move(person.motion), {.faults = faults_}};
    }
    virt::VirtualPerson person = virt::draw_person(root_);
    Cast out{std::move(person.face), virt::draw_motion(seconds_, person.style, root_), {.faults = faults_}};
    // As unlike the standard skin as those of training are: evenly, from not at all to what a recipe says.
    const double unlike = root_.fork("unlike").uniform();
    out.wearing.faults.mount_position_mm *= unlike;
    out.wearing.kinematics = virt::KinematicsSpread().times(unlike);
    return out;
  }

  [[nodiscard]] Result<virt::Performance> perform(const Cast& cast, const virt::Wearing& wearing) const {
    return virt::perform_with(wearing, cast.face, cast.motion, *rig_, root_.fork("wearing"));
  }

  [[nodiscard]] Result<void> watch(const virt::VirtualSession& session, std::size_t fault,
                                   const See& see) const {
    MIEN_TRY_ASSIGN(std::vector<model::FeatureFrame> features,
                    solve::trace_features(*rig_, session.events, session.entries, session.ticks));
    std::vector<synthetic::ImuPerson> one;
    one.push_back(synthetic::evaluated_frames(std::move(features), session.truth));
    const synthetic::WatchedGroup group =
        synthetic::watched_by(model_, rig_->face_sensor_names(), {}, std::move(one));
    MIEN_TRY_ASSIGN(const synthetic::Watched seen, group.people.front()->watch(0, root_));
    see(fault, seen);
    return {};
  }

  std::shared_ptr<const model::ModelFile> model_;
  std::shared_ptr<const sensor::Rig> rig_;
  virt::DeviceFaults faults_;  // The rig's own.
  std::size_t index_;
  double seconds_;
  bool shifted_;
  Random root_;
};

}  // namespace

Result<synthetic::FaultyGroup> faulty_people(const model::ModelFile& model, const sensor::Rig& rig,
                                             std::string who, int people, double seconds, bool shifted,
                                             std::uint64_t seed) {
  MIEN_TRY_ASSIGN(const virt::DeviceFaults faults, virt::parse_faults(rig.faults_toml, rig.name));
  const auto file = std::make_shared<const model::ModelFile>(model);
  const auto worn = std::make_shared<const sensor::Rig>(rig);
  synthetic::FaultyGroup group{std::move(who), {}, {}};
  for (const LossCondition& condition : heard_faults(rig)) group.faults.push_back(condition.name());
  for (const WornFault& fault : kWornFaults) group.faults.emplace_back(fault.name);
  for (std::size_t p = 0; p < static_cast<std::size_t>(people); ++p)
    group.people.push_back(std::make_shared<const FaultyImuPerson>(
        file, worn, faults, p / 2, seconds, shifted && p % 2 == 1, Random(seed).fork("faulty person", p)));
  return group;
}

}  // namespace mien::lab
