#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mien/core/progress.h"
#include "mien/face/output_frame.h"
#include "mien/measure/evaluation.h"
#include "mien/modalities/modalities.h"
#include "mien/shaping/settings.h"
#include "mien/take/take.h"
#include "mien/tracker/personalise.h"
#include "mien/tracker/window_solver.h"

namespace mien::solve {

/// A take's answer.
struct Solution {
  std::vector<face::OutputFrame> frames;     ///< One a tick.
  std::vector<std::size_t> sensors_present;  ///< How many stood behind it; one a tick.
  std::vector<face::BlendshapeWeights>
      ridge;  ///< One a tick; empty when the model file has none for the profile.
  /// Share of the sensors' rotations that were there from the first on (before it they are calibrated); the
  /// rest was guessed without them. Where they never tell a whole face (a microphone, gaze) it is that of the
  /// frames of which they tell a part. 0: there was none.
  double observed = 0;
  /// At the end of the take a tracker whose sensors send still waited to be calibrated.
  bool uncalibrated = false;
  /// What the model learnt of the wearer on the take's own prologue first, and how long it took; else none.
  std::optional<tracker::Personalisation> personalised;
  double personalise_s = 0;
  std::string unlearnt;  ///< Why the wearer was not learnt, and what to do, where that was asked for.
  std::string hash;      ///< SHA-256 over each tick's device time, the 53 weights, head, eyes and provenance.
};

/// As face::FrameHash has it.
[[nodiscard]] std::string hash_frames(std::span<const face::OutputFrame> frames);

/// How a window network is asked with `steps` denoising steps: as its file says but for their number, and by
/// the published sampler where they are all of the schedule's levels. 0: as its file says.
[[nodiscard]] model::SamplerSettings sampler_of(const model::ModelFile& file, std::size_t steps);

/// Solves a whole take with the window network, which sees what comes later: another way than a session's.
/// Frames are not shaped. Errors: the take's; not_found (no ticks); cancelled.
[[nodiscard]] Result<Solution> solve_take(const take::Take& take, const tracker::WindowSolver& solver,
                                          const model::SamplerSettings& settings, const Progress& progress);

/// Solves a take, recorded or performed, with this live model by replaying its session: of a recorded one the
/// frames that it gave, to the bit, where it ran with the same model, kernels and settings of shaping (those
/// that it began with; what it changed later is in its log). Ridge where `model` has the IMUs' file. Errors:
/// the take's; not_found (no ticks); modalities::make_session's; cancelled.
[[nodiscard]] Result<Solution> replay_take(const take::Take& take, const modalities::LiveModel& model,
                                           const Progress& progress,
                                           const shaping::ShaperSettings& settings = {});

/// Sends a window network's frames through the shaping that a session has (shaping::Shaper).
void shape(const shaping::ShaperSettings& settings, Solution& solution);

/// A take's own truth, to be read before it is solved, which takes long. Errors: the take's; not_found (it
/// has none).
[[nodiscard]] Result<std::vector<take::TruthFrame>> own_truth(const take::Take& take);

/// A solution beside what its face truly did, for measure::evaluate(). `take`: its name. Ticks of which the
/// truth says nothing are not evaluated.
[[nodiscard]] measure::TakeEstimates with_truth(std::string take, const Solution& solution,
                                                std::span<const take::TruthFrame> truth);

}  // namespace mien::solve
