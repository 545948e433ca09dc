#pragma once

#include <memory>

#include "mien/eyewear/marker_network.h"
#include "mien/synthetic/eyewear/eyewear_dataset.h"
#include "mien/train/task.h"

namespace mien::train {

/// Light of photo-reflective sensors to markers: models of eyewear::MarkerNetworkFile, of causal networks.
class MarkerTask final : public Task {
 public:
  /// An output of 1, metres: farther than any marker moves.
  static constexpr double kScaleM = 0.06;

  /// `rig`: text of the rig file, to be kept in the model. Errors: bad_usage (not a causal network; no
  /// sequence as long as a window), mismatch (arrays that do not fit), out_of_range.
  [[nodiscard]] static Result<std::unique_ptr<MarkerTask>> create(Recipe recipe,
                                                                  synthetic::LightDataset training,
                                                                  synthetic::LightDataset validation,
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
  /// "markers": mean distance over validation, of the network frame by frame, of a ridge on the same frames,
  /// and of neutral, mm.
  [[nodiscard]] Result<std::string> assess(std::span<const model::Tensor> network,
                                           const Progress& progress) override;
  [[nodiscard]] Result<void> write(const std::filesystem::path& path,
                                   const std::string& results) const override;

 private:
  MarkerTask(Recipe recipe, synthetic::LightDataset training, synthetic::LightDataset validation,
             std::string rig);
  void append_window(const synthetic::LightSequence& sequence, std::size_t first,
                     const std::vector<std::uint8_t>& lost, Batch& batch) const;

  Recipe recipe_;
  synthetic::LightDataset training_;
  synthetic::LightDataset validation_;
  eyewear::MarkerNetworkFile model_;
};

}  // namespace mien::train
