#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "mien/core/time.h"
#include "mien/face/gaze_targets.h"
#include "mien/headset/gaze_map.h"
#include "mien/sensor/calibration.h"

namespace mien::headset {

/// Gathers where a wearer's eyes are found while they rest on targets whose directions are known, and learns
/// from it what to make of what is found. add() does not allocate. A pure function of the calls.
class GazeLearner {
 public:
  /// Where each eye is found, rad; none where it cannot be told: a closed lid, no camera, little confidence.
  using Found = std::array<std::optional<Eigen::Vector2f>, 2>;

  /// One more target, looked at on the frames [begin, end).
  void ask(const face::GazeTarget& target, DeviceTime begin, DeviceTime end);
  /// Asks for nothing any more.
  void clear() { asked_.clear(); }
  /// Forgets what was gathered, not what is asked for.
  void restart();

  [[nodiscard]] bool asks() const { return !asked_.empty(); }
  /// The last target's time is over.
  [[nodiscard]] bool is_over(DeviceTime frame) const { return asks() && frame >= asked_.back().end; }
  void add(DeviceTime frame, const Found& found);

  struct Learnt {
    std::optional<GazeMap> map;         ///< None: the eyes were seen at too few targets.
    std::vector<sensor::Score> scores;  ///< "gaze targets", and "gaze left", "gaze right" of what was fitted.
  };
  /// Of all targets together. A target at which an eye was seen for less than half of the time is left out
  /// for that eye.
  [[nodiscard]] Learnt learn() const;

 private:
  struct Asked {
    face::GazeTarget target;
    DeviceTime begin, end;
    std::array<Eigen::Vector2d, 2> sum = {Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
    std::array<std::size_t, 2> frames{};
    /// The eye's mean direction; none where it was seen too little.
    [[nodiscard]] std::optional<Eigen::Vector2f> mean(std::size_t eye) const;
  };
  std::vector<Asked> asked_;
};

}  // namespace mien::headset
