#include "mien/virtual/speech/worn_microphones.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mien/speech/sound_block.h"
#include "mien/virtual/node.h"
#include "mien/virtual/reception.h"
#include "mien/virtual/speaking_node.h"
#include "mien/virtual/speech/microphone_simulator.h"

namespace mien::virt {
namespace {

constexpr std::string_view kMicrophones = "microphone";

std::vector<MicrophoneSimulator> simulators(const std::vector<std::uint64_t>& devices,
                                            const MicrophoneFaults& faults, const SoundInAir& sound,
                                            const Random& random) {
  std::vector<MicrophoneSimulator> all;
  for (std::size_t m = 0; m < devices.size(); ++m)
    all.emplace_back(sound, faults, devices[m], random.fork(kMicrophones, m));
  return all;
}

class MicrophonesOnNetwork final : public SpeakingDevices {
 public:
  MicrophonesOnNetwork(std::vector<MicrophoneSimulator> microphones,
                       const std::vector<std::uint64_t>& devices, const Stage& stage,
                       const PlayedMotion& motion)
      : SpeakingDevices(motion, motion.curve.duration_s() + kDeviceMarginS),
        microphones_(std::move(microphones)),
        start_s_(stage.motion.times.motion_start_s) {
    for (const std::uint64_t device : devices) nodes_.emplace_back(device);
  }
  [[nodiscard]] Result<void> simulate() override {
    simulated_s_ += 1 / kFrameRateHz;
    for (std::size_t m = 0; m < microphones_.size(); ++m) {
      sent_.clear();
      while (microphones_[m].heard_s() < simulated_s_)
        MIEN_TRY(microphones_[m].hear([this](double true_s) { return motion_s(true_s); }, sent_));
      for (Datagram& block : sent_) nodes_[m].hand_over(std::move(block));
    }
    return {};
  }

 private:
  /// What is said comes again with the motion.
  [[nodiscard]] double motion_s(double true_s) const {
    if (!motion_.encore || true_s < motion_.encore->end_s) return true_s - start_s_;
    return std::fmod(true_s - motion_.encore->begin_s, motion_.encore->end_s - motion_.encore->begin_s);
  }

  std::vector<MicrophoneSimulator> microphones_;
  double start_s_;
  std::vector<Datagram> sent_;
};

}  // namespace

performer::PrologueNeeds WornMicrophones::prologue(const Stage&) const {
  return {.neutral_s = 1, .gestures = false};
}

Result<Sent> WornMicrophones::send(const Stage& stage, const Progress&) const {
  MIEN_TRY_ASSIGN(const face::MotionCurve curve, curve_of(stage.motion));
  const double end_s = curve.duration_s() + kDeviceMarginS;
  const auto motion_s = [start_s = stage.motion.times.motion_start_s](double true_s) {
    return true_s - start_s;
  };
  std::vector<MicrophoneSimulator> microphones = simulators(devices_, faults_, sound_, stage.devices);
  Sent sent;
  sent.reference = microphones.front().clock();
  for (MicrophoneSimulator& microphone : microphones)
    while (microphone.heard_s() < end_s) MIEN_TRY(microphone.hear(motion_s, sent.datagrams));
  return sent;
}

Result<std::unique_ptr<NodeDevices>> WornMicrophones::on_network(const Stage& stage,
                                                                 const PlayedMotion& motion,
                                                                 NodeLanguage language) const {
  if (language == NodeLanguage::slimevr)
    return fail(ErrorCode::bad_usage, "a microphone does not speak SlimeVR's language", stage.rig.name,
                "send to udp://HOST:PORT");
  return std::make_unique<MicrophonesOnNetwork>(simulators(devices_, faults_, sound_, stage.devices),
                                                devices_, stage, motion);
}

Result<std::shared_ptr<const WornDevices>> wear_microphones(const StageRequest& request, face::Face,
                                                            const Random&, const Stage& stage) {
  MicrophoneFaults faults;
  if (!stage.lab) {
    MIEN_TRY_ASSIGN(const FaultsText text, read_faults(request, stage.rig, kMicrophones));
    MIEN_TRY_ASSIGN(faults, parse_microphone_faults(text.toml, text.where));
  }
  MIEN_TRY_ASSIGN(const std::vector<sensor::DeviceKey> keys, virtual_devices(stage.rig));
  std::vector<std::uint64_t> devices;
  for (std::size_t m = 0; m < keys.size(); ++m) {
    if (keys[m].channel != 0 || keys[m].device == speech::kThisMachine)
      return fail(
          ErrorCode::bad_usage,
          fmt::format("the microphone '{}' is bound to {}, which none on a network can be",
                      stage.rig.sensors[m].name, sensor::format_device(keys[m])),
          "rig " + stage.rig.name,
          fmt::format("write device = \"{}\" at it", sensor::format_device({speech::kAnyMicrophone, 0})));
    devices.push_back(keys[m].device);
  }
  SoundInAir sound;
  if (request.sound) {
    MIEN_TRY_ASSIGN(sound, SoundInAir::of(*request.sound));
  }
  return std::make_shared<const WornMicrophones>(std::move(devices), faults, std::move(sound));
}

}  // namespace mien::virt
