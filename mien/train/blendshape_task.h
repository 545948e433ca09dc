#pragma once

#include <memory>

#include "mien/dataset/dataset.h"
#include "mien/model/model_file.h"
#include "mien/train/task.h"

namespace mien::train {

/// Features of IMUs to blendshape weights: models of model::ModelFile, of either kind of network.
class BlendshapeTask final : public Task {
 public:
  /// The data may be of virtual performers, of takes (Sequence::from_take) or of both; of both, the recipe's
  /// share (kUsualTakesShare unless told) says how much of the windows, of the score, and of normalisation,
  /// mean pose and covariance is of takes. `rig`: text of the rig file, to be kept in the model.
  /// `one_person`: those takes that train and those that validate are of the same one, and results say so.
  /// Errors: mismatch, out_of_range (data that do not fit, somebody in both sets, performers of unknown skin
  /// where the recipe wants known ones); bad_usage (no sequence as long as a window, nobody to validate on).
  [[nodiscard]] static Result<std::unique_ptr<BlendshapeTask>> create(Recipe recipe,
                                                                      dataset::Dataset training,
                                                                      dataset::Dataset validation,
                                                                      std::string rig,
                                                                      bool one_person = false);

  [[nodiscard]] const Recipe& recipe() const override { return recipe_; }
  [[nodiscard]] Batch random_batch(std::size_t count, Random random) const override;
  /// Of virtual performers, where there are any to validate on; else of takes.
  [[nodiscard]] Batch validation_batch(Random random) const override;
  /// Of virtual performers and of takes, by the recipe's share.
  [[nodiscard]] std::vector<ValidationPart> validation_parts(Random random) const override;
  [[nodiscard]] std::string training_hash() const override;
  [[nodiscard]] std::string validation_hash() const override;
  [[nodiscard]] std::size_t training_frames() const override;
  [[nodiscard]] std::size_t validation_frames() const override;
  [[nodiscard]] Result<std::string> results_of(const std::filesystem::path& model) const override;
  /// Takes over the standard skin too, where the data know none.
  [[nodiscard]] Result<std::vector<model::Tensor>> begin_with(const std::filesystem::path& model) override;
  [[nodiscard]] Result<std::string> assess(std::span<const model::Tensor> network,
                                           const Progress& progress) override;
  [[nodiscard]] Result<void> write(const std::filesystem::path& path,
                                   const std::string& results) const override;

 private:
  BlendshapeTask(Recipe recipe, dataset::Dataset training, dataset::Dataset validation, std::string rig,
                 bool one_person);
  [[nodiscard]] Result<void> check_places() const;
  [[nodiscard]] double takes_share() const { return recipe_.takes_share.value_or(0); }

  Recipe recipe_;
  dataset::Dataset training_;
  dataset::Dataset validation_;
  bool one_person_ = false;
  FrameWeights frame_weights_;  ///< Of training.
  model::ModelFile model_;
  BatchMaker training_batches_;
  BatchMaker validation_batches_;
};

}  // namespace mien::train
