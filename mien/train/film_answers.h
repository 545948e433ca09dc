#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "mien/core/error.h"
#include "mien/headset/answer.h"
#include "mien/headset/network_view.h"
#include "mien/model/architecture.h"
#include "mien/sensor/rig.h"
#include "mien/synthetic/headset/headset_dataset.h"

// What networks of a headset's pictures learn from films: which view stands where, and what is true.
namespace mien::train {

/// Below this openness a gaze cannot be seen, and an eye counts as closed.
inline constexpr float kShutEye = 0.25F;
/// Chance of a window to be told nothing of what the face is like at rest.
inline constexpr double kNotTold = 1.0 / 6;

/// Which of a film's cameras stands in a place of the network, if one does, and how its view is turned.
struct FilmPlace {
  std::size_t camera = 0;
  bool is_there = false;
  headset::NetworkViewSettings view;
};
using FilmPlaces = std::array<FilmPlace, model::kViews>;

/// The places of the rig's cameras in films of views of `side` pixels. Errors: headset_cameras'; mismatch
/// (films of another size or number of views).
[[nodiscard]] Result<FilmPlaces> film_places(const synthetic::HeadsetFilms& films, const sensor::Rig& rig,
                                             std::size_t side);

/// What a network should answer, in its outputs' range; NaN: gaze and pupil of an eye that is shut.
[[nodiscard]] std::array<float, headset::kAnswerOutputs> answer_of(const synthetic::FilmTruth& truth);
/// Where the eyes' directions stand.
[[nodiscard]] std::vector<std::int64_t> gaze_outputs();
/// answer_of() of the mirrored face.
[[nodiscard]] std::array<float, headset::kAnswerOutputs> mirrored_answer(
    const std::array<float, headset::kAnswerOutputs>& answer);

/// How well the eyes' directions and closed lids are told.
class EyeScore {
 public:
  /// Directions of one eye (0 left, 1 right), as Answer::gaze_rad has them.
  void add_gaze(const std::array<float, 4>& told_rad, const std::array<float, 4>& true_rad, std::size_t eye);
  void add_openness(float told, float truth);

  /// The error that this share (0 to 1) of the directions is within; 0 without any.
  [[nodiscard]] double gaze_deg(double share) const;
  /// F1 of closed eyes.
  [[nodiscard]] double closed_f1() const;

 private:
  std::vector<double> gaze_deg_;
  double hits_ = 0, told_ = 0, shut_ = 0;
};

}  // namespace mien::train
