#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mien/core/progress.h"
#include "mien/face/output_frame.h"
#include "mien/measure/evaluation.h"
#include "mien/shaping/settings.h"
#include "mien/solve/trace_features.h"
#include "mien/take/take.h"
#include "mien/tracker/causal_tracker.h"
#include "mien/tracker/personalise.h"
#include "mien/tracker/tracker.h"
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
  bool shaped = false;   ///< A replay: shaping is in its frames.
  std::string hash;      ///< SHA-256 over each tick's device time, the 53 weights, head, eyes and provenance.
};

/// As face::FrameHash has it.
[[nodiscard]] std::string hash_frames(std::span<const face::OutputFrame> frames);

/// How a window network is asked with `steps` denoising steps: as its file says but for their number, and by
/// the published sampler where they are all of the schedule's levels. 0: as its file says.
[[nodiscard]] model::SamplerSettings sampler_of(const model::ModelFile& file, std::size_t steps);

/// Whether the take was recorded live: then its answer by a live model is the session's replay (replay_take).
[[nodiscard]] bool recorded_live(const take::Take& take);

/// Solves a whole take with the window network.
[[nodiscard]] Result<Solution> solve_take(const take::Take& take, const tracker::WindowSolver& solver,
                                          const model::SamplerSettings& settings, const Progress& progress);

/// Solves a performed take frame by frame, calibrated by its events; the tracker is reset first and last.
[[nodiscard]] Result<Solution> solve_take(const take::Take& take, tracker::CausalTracker& tracker,
                                          const Progress& progress);
/// The same with the features that take_features() gave.
[[nodiscard]] Result<Solution> solve_take(const take::Take& take,
                                          std::span<const model::FeatureFrame> features,
                                          tracker::CausalTracker& tracker, const Progress& progress);

/// Guides the tracker through the calibration that these events are of ("neutral", "nod", "shake", "range",
/// "gaze"); to be called before the first tick.
void guide_by_events(std::span<const take::Event> events, tracker::Tracker& tracker);

/// Solves a performed take with the tracker of its sensors: with the calibrations that the take holds, each
/// from when it was made; where it holds none, with those that the tracker makes of the take's events
/// ("neutral", "nod", "shake", "range", "gaze") or finds by itself. The tracker is a fresh one; no ridge.
/// Errors: the take's; not_found (no ticks); what the tracker says of a calibration; cancelled.
[[nodiscard]] Result<Solution> solve_take(const take::Take& take, tracker::Tracker& tracker,
                                          const Progress& progress);

/// Replays a live take with this live model (a file, or a folder of them where the rig has several kinds of
/// sensors): the frames that the session gave, to the bit, where it ran with the same model, kernels and
/// settings of shaping (those that it began with; what it changed later is in its log); no ridge. Errors: the
/// take's; not_found (no ticks); modalities::make_session's; cancelled.
[[nodiscard]] Result<Solution> replay_take(const take::Take& take, const std::filesystem::path& model,
                                           const Progress& progress,
                                           const shaping::ShaperSettings& settings = {});

/// Sends a tracker's frames through the shaping that a live session has (shaping::Shaper); not for a replay,
/// which is shaped.
void shape(const shaping::ShaperSettings& settings, Solution& solution);

/// A take's own truth, to be read before it is solved, which takes long. Errors: the take's; not_found (it
/// has none).
[[nodiscard]] Result<std::vector<take::TruthFrame>> own_truth(const take::Take& take);

/// A solution beside what its face truly did, for measure::evaluate(). `take`: its name. Ticks of which the
/// truth says nothing are not evaluated.
[[nodiscard]] measure::TakeEstimates with_truth(std::string take, const Solution& solution,
                                                std::span<const take::TruthFrame> truth);

}  // namespace mien::solve
