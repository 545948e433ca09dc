#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/random.h"
#include "mien/dataset/dataset.h"
#include "mien/model/features.h"
#include "mien/model/skin_map.h"
#include "mien/train/recipe.h"
#include "mien/train/takes_mix.h"
#include "mien/train/window_places.h"

namespace mien::train {

/// Windows for one step of training, as plain arrays.
struct Batch {
  std::size_t windows = 0;
  std::vector<float> condition;  ///< windows x frames x condition.
  /// windows x frames x outputs, in [-1, 1]; of a judgement (Recipe::Judgement) whether it can be right.
  std::vector<float> clean;
  std::vector<std::int64_t> level;  ///< Noise level of each window.
  std::vector<std::int64_t> held;   ///< First frames of each window that are given clean; mostly 0.
};

/// Windows of one kind that a validation score is made of.
struct ValidationPart {
  std::string name;  ///< As results call it.
  double share = 1;  ///< Of the score.
  Batch windows;
};

[[nodiscard]] bool all_finite(std::span<const float> values);
/// Refuses a data set whose arrays do not fit each other or hold what is not finite. Errors: mismatch,
/// out_of_range.
[[nodiscard]] Result<void> check(const dataset::Dataset& dataset);

/// SHA-256 over everything in the data set: equal hashes mean that scores can be compared.
[[nodiscard]] std::string hash_of(const dataset::Dataset& dataset);
/// SHA-256 over what is from takes alone, of one data set after the other; not over people's numbers, which
/// follow from how many performers there are.
[[nodiscard]] std::string hash_of_takes(const dataset::Dataset& training, const dataset::Dataset& validation);

/// Refuses two sets of which somebody performs in both, or whose sensors differ. Errors: mismatch.
[[nodiscard]] Result<void> check_apart(const dataset::Dataset& training, const dataset::Dataset& validation);

/// Mean and scale of each value over the frames where it is there. Lab rotations count with their noise.
[[nodiscard]] model::FeatureNormalisation normalisation_of(const dataset::Dataset& dataset,
                                                           double lab_noise_rad,
                                                           const FrameWeights& weights = {});

/// Who moves in a window.
enum class WindowsOf { virtual_performers, takes };

/// Turns sequences into what the network reads. Everything random comes from the generator that is handed in,
/// so a step's batch depends on nothing but the recipe's seed and the step's number.
class BatchMaker {
 public:
  /// Keeps references: the data set must stay.
  /// `skin` and `mean_pose`: what wearers' skins are brought to the standard's by, where the recipe wants
  /// known skins.
  BatchMaker(const dataset::Dataset& dataset, const Recipe& recipe, const model::FeatureLayout& layout,
             const model::FeatureNormalisation& normalisation, const std::optional<model::Skin>& skin,
             const std::vector<float>& mean_pose);

  /// From now on batches are normalised by these.
  void use(const model::FeatureNormalisation& normalisation) { normalisation_ = normalisation; }

  [[nodiscard]] const dataset::Dataset& dataset() const { return dataset_; }

  /// `count` windows at random places, augmented: the recipe's share of them of takes, where there are both
  /// kinds. Thread-safe. Errors: none; needs at least one sequence as long as a window, see places().
  [[nodiscard]] Batch random_batch(std::size_t count, Random random) const;

  /// At most `count` windows of one kind, evenly spread over the data set, with lab noise (from `random`) but
  /// nothing lost.
  [[nodiscard]] Batch even_batch(std::size_t count, Random random,
                                 WindowsOf whose = WindowsOf::virtual_performers) const;

  /// Condition of `count` frames of one sequence, from `first` on, with lab noise where the sequence is lab.
  void encode(std::size_t sequence, std::size_t first, std::size_t count, Random& random,
              std::span<float> out) const;

  /// Places at which a window may begin.
  [[nodiscard]] std::size_t places(WindowsOf whose) const;

 private:
  [[nodiscard]] WindowPlaces window_places(WindowsOf whose) const;
  /// What is missing or wrong in one window, though the data have it.
  struct Loss {
    /// A sensor is not there in frames [begin, end).
    struct Stretch {
      std::size_t sensor, begin, end;
    };
    std::vector<std::uint8_t> sensor;  ///< Not there at all; empty: none.
    bool acceleration = false;         ///< None is there.
    std::vector<Stretch> away;
    std::vector<std::uint8_t> held;  ///< frames x sensors: the reading is the last frame's; empty: none.
    /// What a device's headings are off, frame H's +Y taken for the vertical; empty: nothing. Lab rotations
    /// have none.
    std::vector<double> heading_rad;
  };
  void encode_with(std::size_t sequence, std::size_t first, std::size_t count, const Loss& loss,
                   Random& random, std::span<float> out) const;
  /// The performer's skin as a minute of prompts would tell it; none where it is not to be known, or nobody
  /// knows it.
  [[nodiscard]] std::optional<model::SkinMap> draw_skin(std::size_t sequence, Random& random) const;
  void append_window(std::size_t sequence, std::size_t first, const Loss& loss, Random& random,
                     Batch& batch) const;
  [[nodiscard]] Loss draw_loss(Random& random) const;
  void draw_stretches(Random& random, Loss& loss) const;
  void draw_held(Random& random, Loss& loss) const;

  const dataset::Dataset& dataset_;
  const Recipe& recipe_;
  model::FeatureLayout layout_;
  model::FeatureNormalisation normalisation_;
  std::optional<model::Skin> skin_;
  std::vector<float> mean_pose_;
};

}  // namespace mien::train
