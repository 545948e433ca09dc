#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/model/architecture.h"
#include "mien/model/schedule.h"

namespace mien::train {

/// What a validation score is compared by.
enum class Score {
  mse,   ///< Squared error of the weights that the network gives when asked once, from pure noise.
  loss,  ///< Mean absolute error over a few noise levels, whatever loss training makes small.
};

/// What training makes small: of the clean windows' errors in [-1, 1].
enum class LossKind {
  l1,      ///< Mean absolute error: the network answers with medians, as the published one does.
  l2,      ///< Mean squared error: it answers with means, which is what an error in squares asks for.
  points,  ///< Mean distance of points, three outputs each.
};

/// Share of a step's windows that are drawn from people's takes, where the recipe says nothing.
inline constexpr double kUsualTakesShare = 0.5;

/// Where in a network's condition stand as many numbers as are asked for, which its first outputs are added
/// to, and of each the judgement by whose probability of being wrong it is multiplied first.
struct Addition {
  std::int64_t to = 0;
  std::vector<std::int64_t> doubted_by;
};

/// How a model is made, from data to budget: a TOML file (docs/guide/training.md lists its keys). Defaults
/// are the light network's; a recipe names what differs.
struct Recipe {
  std::string text;        ///< The file as it was read: it goes into the model.
  std::uint64_t seed = 1;  ///< Fixes weights, order, augmentation and noise.

  // [network]
  model::Architecture architecture;  ///< `condition` is filled in from the data's sensors.
  bool presence_flags = true;        ///< Off in the faithful variant.
  double dropout = 0.1;              ///< 0 to 0.9. Raise it when training loss runs away from validation.
  /// Attention begins by looking at near frames, each head more closely than the one before; else anywhere.
  bool near_first = false;

  /// Filled in by tasks whose network judges itself: its last outputs, one each, are the logits of whether
  /// the mean absolute error of these others is at most `most_error`, counting those that are known; where
  /// none is, it is wrong. Batch::clean holds, behind a frame's answers, one number a judgement: 1 where what
  /// it judges can be seen; elsewhere it is wrong, too.
  struct Judgement {
    std::vector<std::int64_t> outputs;
    double most_error = 0;
  };
  std::vector<Judgement> judgements;
  /// Filled in by tasks whose network adds to what it reads as much as it doubts that.
  std::optional<Addition> addition;
  /// Filled in by tasks: answers whose error counts `gaze_weight` times.
  std::vector<std::int64_t> gaze_outputs;
  /// Filled in by tasks: answers that difference_weight leaves out, since they change as fast as lids do.
  std::vector<std::int64_t> quick_outputs;

  // [data]: the table as TOML text, unread, for whoever makes the data.
  std::string data;
  /// Filled in by make_task: files of the recorded performances that virtual performers perform.
  std::vector<std::string> recorded;

  /// [takes] share, 0 to 1: of a step's windows, in expectation, those that are drawn from people's takes,
  /// however many frames these have; 1: takes alone. Raising: the network is of those people and their
  /// sensors sooner, and less of all others. None: the recipe asks for no takes.
  std::optional<double> takes_share;

  // [optimiser]
  double learning_rate = 2e-4;
  /// Networks of views: their backbones' matrices are stepped by Muon, all else by Adam.
  bool muon = false;
  std::size_t batch = 64;           ///< Windows a step.
  std::size_t warm_up_steps = 200;  ///< The rate rises from zero over these.
  bool cosine_decay = true;         ///< The rate falls to a hundredth along a half cosine over the budget.
  double clip_norm = 1.0;           ///< Gradients longer than this are shortened; 0 never.
  double ema = 0.999;               ///< The averaged weights keep this share at each averaging.
  std::size_t ema_every = 1;        ///< Steps between averagings.
  bool bf16 = true;                 ///< Products in bf16.
  LossKind loss = LossKind::l1;
  /// Causal networks: weight of the error of the change from frame to frame, which keeps an answer as calm as
  /// the truth is. Changes are small, so weights of 1 to 100 make sense.
  double difference_weight = 0;
  /// Headsets' networks: weight of the error of the eyes' directions, whose numbers are small beside weights.
  /// Raising: gaze is learnt sooner, all else later. Scores of validation count every answer once.
  double gaze_weight = 1;

  // [noise]
  model::ScheduleSettings schedule;
  double t_bias = 0;  ///< 0 draws levels evenly; above, high ones more often: level ~ uniform^(1/(1+t_bias)).
  double t_weight = 0;      ///< Loss weight (level / levels)^t_weight: above 0 high levels count more.
  double held_overlap = 0;  ///< Share of windows whose first half is given clean, as OverlapHold::clean does.

  // [augmentation]
  double lab_noise_rad = 0.017453292519943295;  ///< White noise an axis on lab rotations: 1 degree.
  double sensor_loss = 0.05;                    ///< Chance of each sensor to be missing through a window.
  double many_lost = 0.05;  ///< Chance of a window to lose each sensor with a chance drawn from 0 to 0.9.
  double acceleration_loss = 0.1;  ///< Chance of a window to lose every acceleration.
  /// Chance of each sensor to be away for a stretch of the window, and of all of them to be away together
  /// for one.
  double stretch_loss = 0;
  /// Chance of a window whose readings stand still now and then, as they do where packets are lost: each
  /// sensor for a few frames, as often as a share drawn from 0 to 0.4 says.
  double held_readings = 0;
  /// Chance of a device's window whose headings have drifted, as they do in long sessions: each sensor's by a
  /// normal error that stays through the window, of a sigma drawn evenly up to heading_drift_rad.
  double heading_drift = 0;
  double heading_drift_rad = 0.1;

  /// Share of the windows in which the wearer's skin is known, as it is after a minute of prompts: the
  /// network then reads what the sensors would say on the standard skin (model::SkinMap).
  double known_skin = 0;
  /// How wrong that knowledge is: one sigma of each shape's gain, and of each slope, as a share of how much
  /// the shape turns that sensor.
  double skin_gain_error = 0.12;
  double skin_slope_error = 0.10;

  // [validation]
  std::size_t windows = 256;    ///< Windows looked at each time.
  double every_s = 120;         ///< Seconds between validations (which also write the checkpoint).
  std::size_t every_steps = 0;  ///< The same in steps, when not 0: then runs repeat to the bit.
  Score score = Score::mse;     ///< By which the best averaged weights are kept.

  // [sampler]: candidates, of which validation chooses.
  std::vector<std::size_t> sampler_steps = {1, 2, 4, 8};
  std::size_t sampler_frames = 3000;  ///< Validation frames solved for each candidate.

  // [budget]: whichever ends first; 0 is none. One must be given.
  std::size_t steps = 0;
  double seconds = 0;
};

/// Reads a recipe. Errors: malformed (not TOML), bad_usage (a key that is not known), out_of_range.
[[nodiscard]] Result<Recipe> parse_recipe(std::string_view text, std::string_view where);

}  // namespace mien::train
