#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <vector>

#include "mien/headset/network_view.h"
#include "mien/headset/views_file.h"
#include "mien/sensor/rig.h"
#include "mien/synthetic/headset/headset_dataset.h"
#include "mien/train/film_answers.h"
#include "mien/train/task.h"

namespace mien::train {

/// Pictures of a headset's cameras to the face, moment by moment: models of headset::ViewsFile.
class ViewsTask final : public Task {
 public:
  /// `rig`: whose cameras the films are of. Errors: bad_usage (not a network of pictures), mismatch (films of
  /// another size or number of views).
  [[nodiscard]] static Result<std::unique_ptr<ViewsTask>> create(Recipe recipe, synthetic::HeadsetFilms films,
                                                                 const sensor::Rig& rig,
                                                                 std::string rig_text);

  [[nodiscard]] const Recipe& recipe() const override { return recipe_; }
  /// A window is a donning: its first moment at rest, which one window in six is not told of. Half of them
  /// mirrored; one view in twenty missing.
  [[nodiscard]] Batch random_batch(std::size_t count, Random random) const override;
  [[nodiscard]] Batch validation_batch(Random random) const override;
  [[nodiscard]] std::string training_hash() const override;
  [[nodiscard]] std::string validation_hash() const override;
  [[nodiscard]] std::size_t training_frames() const override;
  [[nodiscard]] std::size_t validation_frames() const override;
  [[nodiscard]] Result<std::string> results_of(const std::filesystem::path& model) const override;
  [[nodiscard]] Result<std::vector<model::Tensor>> begin_with(const std::filesystem::path& model) override;
  /// "headset": over validation, moment by moment, of what can be seen: squared error of the weights, where
  /// the face at rest is known and where not, beside the mean answer's and a ridge's on 12 x 12 means of
  /// each view, the gaze's median error, and how well closed lids are told.
  [[nodiscard]] Result<std::string> assess(std::span<const model::Tensor> network,
                                           const Progress& progress) override;
  [[nodiscard]] Result<void> write(const std::filesystem::path& path,
                                   const std::string& results) const override;

 private:
  struct Donning {
    const synthetic::HeadsetFilm* film;
    synthetic::HeadsetFilm::Donning frames;
  };
  ViewsTask(Recipe recipe, synthetic::HeadsetFilms films)
      : recipe_(std::move(recipe)), films_(std::move(films)) {}
  void find_mean();
  /// From ridge_inputs() to the outputs: inputs x outputs.
  [[nodiscard]] Eigen::MatrixXd fit_ridge() const;
  /// Appends a window: of these frames, the first at rest where `known`; `augment` may be null.
  void append(const synthetic::HeadsetFilm& film, std::span<const std::size_t> frames, bool known,
              Random* augment, Batch& batch) const;

  Recipe recipe_;
  synthetic::HeadsetFilms films_;
  FilmPlaces places_{};
  std::vector<Donning> training_, validation_;
  headset::ViewsFile model_;
};

}  // namespace mien::train
