#pragma once

#include <memory>

#include "mien/model/model_file.h"
#include "mien/study/dataset.h"
#include "mien/train/task.h"

namespace mien::train {

/// Features of IMUs to blendshape weights: models of model::ModelFile, of either kind of network.
class BlendshapeTask final : public Task {
 public:
  /// `rig`: text of the rig file, to be kept in the model. Errors: mismatch, out_of_range (data that do not
  /// fit, somebody in both sets); bad_usage (no sequence as long as a window).
  [[nodiscard]] static Result<std::unique_ptr<BlendshapeTask>> create(Recipe recipe, study::Dataset training,
                                                                      study::Dataset validation,
                                                                      std::string rig);

  [[nodiscard]] const Recipe& recipe() const override { return recipe_; }
  [[nodiscard]] Batch random_batch(std::size_t count, Random random) const override;
  [[nodiscard]] Batch validation_batch(Random random) const override;
  [[nodiscard]] std::string training_hash() const override;
  [[nodiscard]] std::string validation_hash() const override;
  [[nodiscard]] std::size_t training_frames() const override;
  [[nodiscard]] std::size_t validation_frames() const override;
  [[nodiscard]] Result<std::string> results_of(const std::filesystem::path& model) const override;
  [[nodiscard]] Result<std::vector<model::Tensor>> begin_with(const std::filesystem::path& model) override;
  [[nodiscard]] Result<std::string> assess(std::span<const model::Tensor> network,
                                           const Progress& progress) override;
  [[nodiscard]] Result<void> write(const std::filesystem::path& path,
                                   const std::string& results) const override;

 private:
  BlendshapeTask(Recipe recipe, study::Dataset training, study::Dataset validation, std::string rig);

  Recipe recipe_;
  study::Dataset training_;
  study::Dataset validation_;
  model::ModelFile model_;
  BatchMaker training_batches_;
  BatchMaker validation_batches_;
};

}  // namespace mien::train
