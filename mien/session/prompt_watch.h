#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "mien/core/time.h"
#include "mien/face/output_frame.h"
#include "mien/sensor/rig.h"
#include "mien/session/prompt.h"

namespace mien::session {

/// Looks whether what is recorded while a line is shown is fit to learn from: every sensor but microphones
/// that was received still is, the face is seen by whoever tells the truth, and something moved.
class PromptWatch {
 public:
  /// A sensor may be lost, or a face unseen, in this share of a line's frames. Raising it keeps lines with
  /// holes; lowering it asks again for what a training could have used.
  static constexpr double kMostMissing = 0.1;
  /// Some shape, but those of lids and eyes only where they are asked for, must have changed by this while a
  /// text was read or a pose made.
  /// Raising it asks again for quiet lines; lowering it keeps those in which sensors were not on the face.
  static constexpr float kLeastMoved = 0.08F;

  explicit PromptWatch(const sensor::Rig& rig) : missing_(rig.sensors.size()) {}

  /// How one sensor of the rig is at a tick.
  enum class Link : std::uint8_t { there, lost, no_face };
  /// At each tick at which the line is shown that began at `begin`; another begin is another line. `link`:
  /// of a sensor of the rig.
  template <class LinkOf>
  void add(DeviceTime begin, const face::OutputFrame& frame, LinkOf&& link) {
    if (begin_ != begin) clear(begin);
    for (std::uint16_t i = 0; i < missing_.size(); ++i) {
      const Link is = link(i);
      if (is == Link::lost) ++missing_[i].lost;
      if (is == Link::no_face) ++missing_[i].no_face;
    }
    add_weights(frame.weights);
  }

  /// What was poor, a sentence each. `rig`: as in the constructor.
  [[nodiscard]] std::vector<std::string> poor(const Prompt& prompt, const sensor::Rig& rig) const;

 private:
  struct Missing {
    std::size_t lost = 0;
    std::size_t no_face = 0;
  };
  void clear(DeviceTime begin);
  void add_weights(const face::BlendshapeWeights& weights);

  std::optional<DeviceTime> begin_;
  std::size_t frames_ = 0;
  std::vector<Missing> missing_;  // One a sensor of the rig.
  face::BlendshapeWeights least_, most_;
};

}  // namespace mien::session
