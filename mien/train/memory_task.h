#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <vector>

#include "mien/headset/moment_features.h"
#include "mien/headset/views_file.h"
#include "mien/sensor/rig.h"
#include "mien/synthetic/headset/headset_dataset.h"
#include "mien/train/task.h"

namespace mien::train {

/// What a network of pictures finds, frame by frame, to the face: the memory of a headset::ViewsFile, at
/// kFrameRateHz. Its network of pictures stays as it is. The same files are read as for that network: each
/// donning as it is, mirrored, and as other mountings and cameras show it.
class MemoryTask final : public Task {
 public:
  /// `views`: what finds. Errors: bad_usage (not a causal network; no donning as long as a window), mismatch
  /// (films of another size or number of views), cancelled.
  [[nodiscard]] static Result<std::unique_ptr<MemoryTask>> create(Recipe recipe,
                                                                  const synthetic::HeadsetFilms& films,
                                                                  headset::ViewsFile views,
                                                                  const sensor::Rig& rig,
                                                                  const Progress& progress);

  [[nodiscard]] const Recipe& recipe() const override { return recipe_; }
  /// Of cameras that are slow, late or away, and of frames that are lost; one window in six without a face at
  /// rest.
  [[nodiscard]] Batch random_batch(std::size_t count, Random random) const override;
  /// With all of them.
  [[nodiscard]] Batch validation_batch(Random random) const override;
  [[nodiscard]] std::string training_hash() const override { return training_hash_; }
  [[nodiscard]] std::string validation_hash() const override { return validation_hash_; }
  [[nodiscard]] std::size_t training_frames() const override { return frames_of(training_); }
  [[nodiscard]] std::size_t validation_frames() const override { return frames_of(validation_); }
  [[nodiscard]] Result<std::string> results_of(const std::filesystem::path& model) const override;
  [[nodiscard]] Result<std::vector<model::Tensor>> begin_with(const std::filesystem::path& model) override;
  /// "headset": over validation, frame by frame after the rest: squared error of the weights beside the mean
  /// answer's and that of the network of pictures alone, the gaze's median error and its 90th percentile, how
  /// well closed lids are told, how restless the answer is (third differences over the truth's), and of the
  /// judgements calibration error and area under the ROC of each half of the wearers with what was fitted on
  /// the other (the model's own are fitted on all); and how well eyes that are shown mirrored are told.
  [[nodiscard]] Result<std::string> assess(std::span<const model::Tensor> network,
                                           const Progress& progress) override;
  [[nodiscard]] Result<void> write(const std::filesystem::path& path,
                                   const std::string& results) const override;

 private:
  /// A donning, and what was found in it.
  struct Sequence {
    std::size_t film = 0;  ///< Whose it is.
    std::size_t frames = 0, rest_end = 0;
    double rate_hz = 0;
    std::vector<float> features;                ///< frames x kViews x features.
    headset::RestFeatures rest, mirrored_rest;  ///< The second of eyes that are shown mirrored.
    std::vector<float> wanted;                  ///< frames x kAnswerOutputs; NaN: nobody can know it.
    /// Of each frame, whether upper and lower face can be seen.
    std::vector<std::array<bool, 2>> visible;
  };
  /// What arrives of a view in a window.
  struct Delivery;

  MemoryTask(Recipe recipe, headset::ViewsFile views, model::ViewsNetwork network)
      : recipe_(std::move(recipe)), views_(std::move(views)), network_(std::move(network)) {}
  [[nodiscard]] static std::size_t frames_of(const std::vector<Sequence>& sequences);
  [[nodiscard]] std::size_t ticks_of(const Sequence& sequence) const;
  /// What is found in the eyes at rest, as they are or mirrored.
  [[nodiscard]] static std::vector<std::vector<float>> eyes_at_rest(const std::vector<Sequence>& sequences,
                                                                    bool mirrored, std::size_t features);
  void append(const Sequence& sequence, std::size_t first_tick, Random* random,
              model::ViewsNetwork::Workspace& memory, Batch& batch) const;
  /// The moment at a tick, of views that are there as `delivery` says (null: all are).
  void moment_at(const Sequence& sequence, double frame, std::span<const Delivery> delivery,
                 headset::MomentFeatures& moment) const;
  static void wanted_at(const Sequence& sequence, double frame, std::span<float> out);
  /// Whether what a judgement is about can be seen.
  [[nodiscard]] static bool is_visible(const Sequence& sequence, double frame, std::size_t judgement);

  Recipe recipe_;
  headset::ViewsFile views_;
  model::ViewsNetwork network_;  // That of views_.
  std::vector<Sequence> training_, validation_;
  std::string training_hash_, validation_hash_;
};

}  // namespace mien::train
