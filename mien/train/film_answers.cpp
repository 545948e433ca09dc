#include "mien/train/film_answers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "mien/core/quantile.h"
#include "mien/core/units.h"

namespace mien::train {

using headset::kAnswerOutputs;

Result<FilmPlaces> film_places(const synthetic::HeadsetFilms& films, const sensor::Rig& rig,
                               std::size_t side) {
  for (const auto* part : {&films.train, &films.validation})
    for (const synthetic::HeadsetFilm& film : *part)
      if (film.side() != side || film.views() != rig.sensors.size())
        return fail(ErrorCode::mismatch,
                    fmt::format("films have {} views of {} pixels, the network {} of {}", film.views(),
                                film.side(), rig.sensors.size(), side),
                    "[data] side");
  MIEN_TRY_ASSIGN(const std::vector<headset::HeadsetCamera> cameras, synthetic::film_cameras(rig, side));
  FilmPlaces places;
  for (const headset::HeadsetCamera& camera : cameras)
    places[camera.place] = {.camera = camera.sensor, .is_there = true, .view = camera.view};
  return places;
}

std::array<float, kAnswerOutputs> answer_of(const synthetic::FilmTruth& truth) {
  constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
  headset::Answer answer{.weights = {},
                         .tongue_out = truth.tongue_out,
                         .gaze_rad = truth.gaze_rad,
                         .openness = truth.openness,
                         .pupil_mm = truth.pupil_mm};
  for (std::size_t k = 0; k < face::kShapeCount; ++k) answer.weights[k] = truth.weights[k];
  std::array<float, kAnswerOutputs> wanted{};
  headset::encode_answer(answer, wanted);
  for (std::size_t e = 0; e < 2; ++e)
    if (truth.openness[e] < kShutEye) {
      wanted[headset::kGazeOutput + 2 * e] = wanted[headset::kGazeOutput + 2 * e + 1] = kUnknown;
      wanted[headset::kPupilOutput + e] = kUnknown;
    }
  return wanted;
}

std::vector<std::int64_t> gaze_outputs() {
  constexpr auto kFirst = static_cast<std::int64_t>(headset::kGazeOutput);
  return {kFirst, kFirst + 1, kFirst + 2, kFirst + 3};
}

std::array<float, kAnswerOutputs> mirrored_answer(const std::array<float, kAnswerOutputs>& answer) {
  std::array<float, kAnswerOutputs> mirrored{};
  for (std::size_t i = 0; i < kAnswerOutputs; ++i) {
    const float from = answer[headset::mirrored_outputs()[i]];
    mirrored[i] = headset::mirrors_sign(i) ? -from : from;
  }
  return mirrored;
}

void EyeScore::add_gaze(const std::array<float, 4>& told_rad, const std::array<float, 4>& true_rad,
                        std::size_t eye) {
  gaze_deg_.push_back(kDegPerRad * std::hypot(double{told_rad[2 * eye] - true_rad[2 * eye]},
                                              double{told_rad[2 * eye + 1] - true_rad[2 * eye + 1]}));
}

void EyeScore::add_openness(float told, float truth) {
  const bool is = truth < kShutEye, says = told < kShutEye;
  shut_ += is ? 1 : 0;
  told_ += says ? 1 : 0;
  hits_ += is && says ? 1 : 0;
}

double EyeScore::gaze_deg(double share) const {
  std::vector<double> sorted = gaze_deg_;
  std::ranges::sort(sorted);
  return sorted.empty() ? 0.0 : quantile_of_sorted(sorted, share);
}

double EyeScore::closed_f1() const {
  return 2 * hits_ / std::max(1.0, shut_ + told_);
}

}  // namespace mien::train
