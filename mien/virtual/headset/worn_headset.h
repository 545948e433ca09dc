#pragma once

#include <memory>
#include <optional>
#include <utility>

#include "mien/core/random.h"
#include "mien/face/face.h"
#include "mien/virtual/headset/headset_boards.h"
#include "mien/virtual/headset/headset_faults.h"
#include "mien/virtual/headset/headset_wearer.h"
#include "mien/virtual/stage.h"
#include "mien/virtual/worn_devices.h"

namespace mien::virt {

/// A headset with cameras, and who wears it.
class WornHeadset final : public WornDevices {
 public:
  /// The longest performance that is filmed into memory, s: some 1.3 GB with four cameras.
  static constexpr double kLongestS = 600;

  /// `rig`: of nothing but this headset's cameras.
  WornHeadset(sensor::Rig rig, HeadsetFaults faults, HeadsetWearer wearer,
              std::optional<TimedFailure> failure)
      : rig_(std::move(rig)), faults_(std::move(faults)), wearer_(std::move(wearer)), failure_(failure) {}

  [[nodiscard]] const HeadsetFaults& faults() const { return faults_; }
  [[nodiscard]] const HeadsetWearer& wearer() const { return wearer_; }

  /// Three seconds of neutral; cameras that the head carries see nothing of a nod.
  [[nodiscard]] performer::PrologueNeeds prologue(const Stage& stage) const override;
  /// Pictures as datagrams of type 15, each with its JPEG as payload, and the failure as an event.
  /// Errors: WornDevices::send()'s, out_of_range (longer than kLongestS), those of HeadsetBoards.
  [[nodiscard]] Result<Sent> send(const Stage& stage, const Progress& progress) const override;
  [[nodiscard]] bool are_asked() const override { return true; }
  /// Errors: bad_usage, always: cameras send nothing, they are asked.
  [[nodiscard]] Result<std::unique_ptr<NodeDevices>> on_network(const Stage& stage,
                                                                const PlayedMotion& motion,
                                                                NodeLanguage language) const override;

  /// Its boards, from where the performance begins; `width` and `rate_hz` as HeadsetFilming has them.
  /// Errors: HeadsetBoards::put_on()'s.
  [[nodiscard]] Result<HeadsetBoards> boards(const Stage& stage, int width = 0, double rate_hz = 0) const;
  /// The performance at a true time, for HeadsetBoards::shoot().
  [[nodiscard]] HeadsetMoment moment_at(const Stage& stage, const PlayedMotion& motion, double true_s) const;

 private:
  sensor::Rig rig_;
  HeadsetFaults faults_;
  HeadsetWearer wearer_;
  std::optional<TimedFailure> failure_;
};

/// Reads its faults and draws looks, parts and seat from `root`. Built-in people have their reflectances and
/// marks at 850 nm and no hair. Errors: bad_usage (the profile *lab*, skin unlike the face's), those of
/// read_faults(), parse_headset_faults(), virtual_devices() and seat_headset().
[[nodiscard]] Result<std::shared_ptr<const WornDevices>> wear_headset(const StageRequest& request,
                                                                      face::Face face, const Random& root,
                                                                      const Stage& stage);

/// The stage's headset; null where its rig has no cameras. Valid as long as the stage's `worn`.
[[nodiscard]] const WornHeadset* headset_of(const Stage& stage);

}  // namespace mien::virt
