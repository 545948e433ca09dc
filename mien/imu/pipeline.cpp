#include "mien/imu/pipeline.h"

#include <array>
#include <cmath>
#include <vector>

namespace mien::imu {
namespace {

using sensor::Sample;
using sensor::SampleKind;

/// Newest rotations of one sensor of the lab profile; their times stand on the reference's line already.
class LabTrack {
 public:
  void add(DeviceTime time, const Vec3& rotation_vector) {
    entries_[static_cast<std::size_t>(next_ % kSize)] = {time, rotation_vector};
    ++next_;
  }

  /// The rotation at the frame: the nearest sample, since a mean of two would halve the noise that the
  /// profile adds.
  [[nodiscard]] bool at(DeviceTime frame, Duration silence, Quat& out) const {
    const Entry* best = nullptr;
    Duration best_distance{};
    for (std::size_t i = 0; i < std::min<std::size_t>(next_, kSize); ++i) {
      const Entry& entry = entries_[i];
      const Duration distance = entry.time > frame ? entry.time - frame : frame - entry.time;
      if (best == nullptr || distance < best_distance) {
        best = &entry;
        best_distance = distance;
      }
    }
    if (best == nullptr || best_distance > silence) return false;
    out = canonical(exp_rotation(best->rotation_vector));
    return true;
  }

 private:
  struct Entry {
    DeviceTime time;
    Vec3 rotation_vector = Vec3::Zero();
  };
  static constexpr std::size_t kSize = 16;
  std::array<Entry, kSize> entries_;
  std::size_t next_ = 0;
};

void put_rotation(const Quat& q, model::SensorFeature& feature) {
  feature.rotation = {static_cast<float>(q.w()), static_cast<float>(q.x()), static_cast<float>(q.y()),
                      static_cast<float>(q.z())};
  feature.has_rotation = true;
}

}  // namespace

struct Pipeline::State {
  PipelineSettings settings;
  std::vector<std::uint16_t> face;  // Numbers in the rig.
  std::vector<LabTrack> lab;        // One a sensor of the rig.
  Calibration calibration;
};

Pipeline::Pipeline(const sensor::Rig& rig, const PipelineSettings& settings)
    : state_(std::make_unique<State>()) {
  state_->settings = settings;
  state_->face = rig.face_sensors();
  state_->lab.resize(rig.sensors.size());
  state_->calibration.sensors.resize(state_->face.size());
}
Pipeline::Pipeline(Pipeline&&) noexcept = default;
Pipeline& Pipeline::operator=(Pipeline&&) noexcept = default;
Pipeline::~Pipeline() = default;

void Pipeline::mark(Phase, DeviceTime, DeviceTime) {}

void Pipeline::add(HostTime, const Sample& sample) {
  if (sample.sensor >= state_->lab.size()) return;
  if (sample.kind == SampleKind::imu_head_relative && sample.count >= 3)
    state_->lab[sample.sensor].add(sample.time, Vec3(sample.values[0], sample.values[1], sample.values[2]));
}

void Pipeline::tick(DeviceTime frame, model::FeatureFrame& out) {
  out.time = frame;
  out.head = Quat::Identity();
  out.has_head = false;
  out.sensors.assign(state_->face.size(), model::SensorFeature{});
  for (std::size_t i = 0; i < state_->face.size(); ++i) {
    Quat rotation;
    if (state_->lab[state_->face[i]].at(frame, state_->settings.silence, rotation))
      put_rotation(rotation, out.sensors[i]);
  }
}

const Calibration& Pipeline::calibration() const {
  return state_->calibration;
}
int Pipeline::calibration_count() const {
  return 0;
}
Result<void> Pipeline::restore(const Calibration& calibration) {
  if (calibration.sensors.size() != state_->face.size())
    return fail(ErrorCode::mismatch, "the calibration is of another number of sensors");
  state_->calibration = calibration;
  return {};
}
SensorStatus Pipeline::status(std::uint16_t) const {
  return {};
}

}  // namespace mien::imu
