#pragma once

#include <string_view>
#include <vector>

#include "mien/core/time.h"
#include "mien/face/output_frame.h"
#include "mien/sensor/calibration.h"
#include "mien/session/command.h"
#include "mien/session/tracker_set.h"
#include "mien/tracker/tracker.h"

namespace mien::session {

/// Leads a performer through a calibration on the grid's time: neutral, nod and shake as the tracker asks for
/// them, in a full one the anchor expressions, each with a score of how much of it the tracker saw, in one
/// that learns the wearer a range of motion too, and in one of gaze the targets to look at. Allocates where
/// it begins and ends.
class Guide {
 public:
  /// From the next tick on: as the session leads through it, or the steps that the command gives.
  void begin(const Calibrate& command);
  void cancel() { *this = {}; }
  [[nodiscard]] bool running() const { return state_ != State::idle; }

  /// At each tick: first this, ...
  void before(DeviceTime frame, TrackerSet& trackers);
  /// ... then, with the tracker's answer, this. Returns true at the tick at which it is over.
  bool after(const face::OutputFrame& frame);
  /// Of the anchors, of the run that was over last; empty for a short one.
  [[nodiscard]] const std::vector<sensor::Score>& anchor_scores() const { return scores_; }

  /// A part of the run, for events in a take and for the page.
  struct Part {
    tracker::Step step = tracker::Step::none;  ///< none: an expression, the learning, or a target.
    std::string_view name;  ///< "neutral", "nod", "shake", "smile", ..., "learning", "look left", ...
    std::string_view prompt;
    const face::BlendshapeWeights* target = nullptr;  ///< Of an expression.
    const face::GazeTarget* look = nullptr;           ///< Where to look.
    bool scored = false;                              ///< An anchor.
    bool range = false;                               ///< A whole range of motion.
    DeviceTime begin, end;
    /// When the eyes are taken to rest on a target: people hear, read and turn them first.
    [[nodiscard]] DeviceTime looks_from() const;
  };
  /// Of the run that is on, or was over last.
  [[nodiscard]] const std::vector<Part>& parts() const { return parts_; }
  /// Whether it runs, and of the tracker's own steps none is left.
  [[nodiscard]] bool steps_over(DeviceTime frame) const;
  /// Where the run is at a frame: the part that runs or comes next, how far it is (0 to 1; 0 before its
  /// begin), and the time until its end.
  struct Place {
    const Part* part = nullptr;  ///< None when not running.
    std::size_t number = 0;      ///< Of the part, from 1.
    double progress = 0;
    Duration remaining{};
  };
  [[nodiscard]] Place place(DeviceTime frame) const;

 private:
  enum class State { idle, wanted, running };
  void plan(DeviceTime begin, const tracker::Guidance& wanted);
  /// The command's own steps.
  void plan_given();

  State state_ = State::idle;
  Calibrate command_;
  std::vector<Part> parts_;
  std::vector<float> response_;  // Of each part.
  std::vector<sensor::Score> scores_;
};

}  // namespace mien::session
