#pragma once

#include <memory>

#include "mien/speech/speech_network.h"
#include "mien/synthetic/speech/closure_score.h"
#include "mien/synthetic/speech/speech_dataset.h"
#include "mien/train/task.h"

namespace mien::train {

/// Sound to the mouth: models of speech::SpeechNetworkFile, of causal networks that take a step a block. One
/// window of six is of sounds that are no speech.
class SpeechTask final : public Task {
 public:
  /// Errors: bad_usage (not a causal network; no sequence as long as a window), mismatch (arrays that do not
  /// fit; a voice in both sets), out_of_range.
  [[nodiscard]] static Result<std::unique_ptr<SpeechTask>> create(Recipe recipe,
                                                                  synthetic::SpeechDataset training,
                                                                  synthetic::SpeechDataset validation);

  [[nodiscard]] const Recipe& recipe() const override { return recipe_; }
  [[nodiscard]] Batch random_batch(std::size_t count, Random random) const override;
  /// Half of them through other rooms and microphones, with other sounds about.
  [[nodiscard]] Batch validation_batch(Random random) const override;
  [[nodiscard]] std::string training_hash() const override;
  [[nodiscard]] std::string validation_hash() const override;
  [[nodiscard]] std::size_t training_frames() const override;
  [[nodiscard]] std::size_t validation_frames() const override;
  [[nodiscard]] Result<std::string> results_of(const std::filesystem::path& model) const override;
  [[nodiscard]] Result<std::vector<model::Tensor>> begin_with(const std::filesystem::path& model) override;
  /// "speech": over validation, block by block: recall and false share of closures, the correlation of the
  /// jaw while something is said, and how often a voice is told in other sounds.
  [[nodiscard]] Result<std::string> assess(std::span<const model::Tensor> network,
                                           const Progress& progress) override;
  [[nodiscard]] Result<void> write(const std::filesystem::path& path,
                                   const std::string& results) const override;

 private:
  SpeechTask(Recipe recipe, synthetic::SpeechDataset training, synthetic::SpeechDataset validation);
  void normalise_by(const synthetic::SpeechDataset& dataset);
  /// What is about in a window: of the training's sounds, or of what one of its voices says.
  [[nodiscard]] std::vector<float> draw_other(Random& random) const;
  void append_window(const synthetic::SpeechSequence& sequence, std::size_t first, std::span<float> frames,
                     Batch& batch) const;
  [[nodiscard]] std::vector<float> frames_of(const synthetic::SpeechSequence& sequence,
                                             std::size_t first) const;

  Recipe recipe_;
  synthetic::SpeechDataset training_;
  synthetic::SpeechDataset validation_;
  std::vector<std::size_t> spoken_, others_;  // Of the training's sequences.
  speech::SpeechNetworkFile model_;
};

}  // namespace mien::train
