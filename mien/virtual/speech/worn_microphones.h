#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "mien/core/random.h"
#include "mien/face/face.h"
#include "mien/virtual/speech/microphone_faults.h"
#include "mien/virtual/speech/sound_in_air.h"
#include "mien/virtual/stage.h"
#include "mien/virtual/worn_devices.h"

namespace mien::virt {

/// Microphones that hear what a performer says.
class WornMicrophones final : public WornDevices {
 public:
  /// `devices`: of each, its id, in the rig's order; none is this machine's.
  WornMicrophones(std::vector<std::uint64_t> devices, MicrophoneFaults faults, SoundInAir sound)
      : devices_(std::move(devices)), faults_(faults), sound_(std::move(sound)) {}

  /// A moment: there is nothing to calibrate.
  [[nodiscard]] performer::PrologueNeeds prologue(const Stage& stage) const override;
  [[nodiscard]] Result<Sent> send(const Stage& stage, const Progress& progress) const override;
  [[nodiscard]] Result<std::unique_ptr<NodeDevices>> on_network(const Stage& stage,
                                                                const PlayedMotion& motion,
                                                                NodeLanguage language) const override;

 private:
  std::vector<std::uint64_t> devices_;
  MicrophoneFaults faults_;
  SoundInAir sound_;
};

/// Reads their faults (the profile *lab* has none); they hear the request's sound, or a room in which nobody
/// speaks. Errors: bad_usage (one that is bound to no device, to a channel above 0, or to what is heard on
/// this machine), those of read_faults(), parse_microphone_faults() and SoundInAir::of().
[[nodiscard]] Result<std::shared_ptr<const WornDevices>> wear_microphones(const StageRequest& request,
                                                                          face::Face face, const Random& root,
                                                                          const Stage& stage);

}  // namespace mien::virt
