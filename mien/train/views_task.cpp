#include "mien/train/tasks.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "mien/core/sha256.h"
#include "mien/face/shape_region.h"
#include "mien/headset/answer.h"
#include "mien/headset/network_view.h"
#include "mien/headset/views_file.h"
#include "mien/model/views_network.h"
#include "mien/sensor/rig.h"
#include "mien/synthetic/headset/headset_dataset.h"
#include "mien/train/film_answers.h"
#include "mien/train/view_augmentation.h"

namespace mien::train {
namespace {

using headset::kAnswerOutputs;
using model::kViews;

/// Of a view, that it is missing; of a moment, that its face is mirrored.
constexpr double kViewMissing = 0.05, kMirrored = 0.5;
constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

/// What the network should answer; what cannot be seen is unknown.
std::array<float, kAnswerOutputs> wanted_of(const synthetic::FilmTruth& truth) {
  std::array<float, kAnswerOutputs> wanted = answer_of(truth);
  for (std::size_t i = 0; i < kAnswerOutputs; ++i)
    if (truth.visible[headset::half_of_face(headset::judgement_of(i))] == 0) wanted[i] = kUnknown;
  return wanted;
}

/// What the ridge reads: means of blocks of each view, and a one. Blocks a side.
constexpr std::size_t kBlocks = 12;
constexpr std::size_t kRidgeInputs = kViews * kBlocks * kBlocks + 1;
/// Moments that it is fitted to at most, and its penalty, in moments.
constexpr std::size_t kRidgeMoments = 6000;
constexpr double kBlockRidgePenalty = 30;

Eigen::VectorXd ridge_inputs(std::span<const float> views, std::size_t side) {
  Eigen::VectorXd inputs = Eigen::VectorXd::Zero(kRidgeInputs);
  Eigen::VectorXd counts = Eigen::VectorXd::Constant(kRidgeInputs, 1e-9);
  for (std::size_t v = 0; v < kViews; ++v)
    for (std::size_t y = 0; y < side; ++y)
      for (std::size_t x = 0; x < side; ++x) {
        const auto block =
            static_cast<Eigen::Index>((v * kBlocks + y * kBlocks / side) * kBlocks + x * kBlocks / side);
        inputs[block] += double{views[(v * side + y) * side + x]};
        ++counts[block];
      }
  inputs = inputs.cwiseQuotient(counts).array() - 0.5;
  inputs[kRidgeInputs - 1] = 1;
  return inputs;
}

/// Squared error of weights whose outputs lie in [-1, 1].
struct Squares {
  double sum = 0, count = 0;
  void add(double output, float wanted) {
    // Half the distance in [-1, 1] is the distance of weights.
    const double error = 0.5 * (std::clamp(output, -1.0, 1.0) - double{wanted});
    sum += error * error;
    ++count;
  }
  [[nodiscard]] double mean() const { return sum / std::max(1.0, count); }
};

TaskData data_of(const std::vector<synthetic::HeadsetFilm>& films) {
  Sha256 hash;
  std::size_t frames = 0;
  for (const synthetic::HeadsetFilm& film : films) {
    hash.add(std::as_bytes(std::span(film.hash())));
    hash.add_value(static_cast<std::uint64_t>(film.frames()));
    frames += film.frames();
  }
  return {.hash = hash.hex(), .frames = frames};
}

/// Pictures of a headset's cameras to the face, moment by moment.
class ViewsTask final
    : public FileTask<headset::ViewsFile, headset::read_views_file, headset::write_views_file> {
 public:
  ViewsTask(Recipe recipe, synthetic::HeadsetFilms films, const FilmPlaces& places, std::string rig_text)
      : FileTask(std::move(recipe), data_of(films.train), data_of(films.validation)),
        films_(std::move(films)),
        places_(places),
        training_(donnings_of(films_.train)),
        validation_(donnings_of(films_.validation)) {
    model_.rig = std::move(rig_text);
    find_mean();
  }

  /// A window is a donning: its first moment at rest, which one window in six is not told of. Half of them
  /// mirrored; one view in twenty missing.
  [[nodiscard]] Batch random_batch(std::size_t count, Random random) const override {
    Batch batch;
    std::vector<std::size_t> frames(recipe_.architecture.window);
    while (batch.windows < count) {
      const auto& [film, donning] = training_[random.below(training_.size())];
      const auto one_of = [&](std::size_t begin, std::size_t end) {
        return begin + random.below(end - begin);
      };
      const bool rests = donning.rest_end > donning.begin;
      for (std::size_t& frame : frames) frame = one_of(donning.begin, donning.end);
      if (rests) frames.front() = one_of(donning.begin, donning.rest_end);
      append(*film, frames, rests && !random.chance(kNotTold), &random, batch);
    }
    return batch;
  }

  [[nodiscard]] Batch validation_batch(Random) const override {
    Batch batch;
    const std::size_t count = std::min(recipe_.windows, validation_.size()),
                      each = recipe_.architecture.window;
    std::vector<std::size_t> frames(each);
    for (std::size_t i = 0; i < count; ++i) {
      const auto& [film, donning] = validation_[i * validation_.size() / count];
      // Its first frame, at rest, and some of those behind it.
      for (std::size_t m = 0; m < each; ++m)
        frames[m] = donning.begin + m * (donning.end - 1 - donning.begin) / (each - 1);
      append(*film, frames, donning.rest_end > donning.begin, nullptr, batch);
    }
    return batch;
  }

  [[nodiscard]] Result<std::vector<model::Tensor>> begin_with(const std::filesystem::path& model) override {
    MIEN_TRY_ASSIGN(headset::ViewsFile standing, headset::read_views_file(model));
    if (model::network_tensors(standing.architecture) != model::network_tensors(recipe_.architecture))
      return fail(ErrorCode::mismatch, "it is a network of another size", model.string(),
                  "start from a model of the recipe's own architecture");
    return std::move(standing.network);
  }

  /// "headset": over validation, moment by moment, of what can be seen: squared error of the weights, where
  /// the face at rest is known and where not, beside the mean answer's and a ridge's on 12 x 12 means of
  /// each view, the gaze's median error, and how well closed lids are told.
  [[nodiscard]] Result<std::string> assess(std::span<const model::Tensor> network,
                                           const Progress& progress) override {
    model_.network.assign(network.begin(), network.end());
    MIEN_TRY_ASSIGN(const model::ViewsNetwork runs,
                    model::ViewsNetwork::create(recipe_.architecture, model_.network));
    model::ViewsNetwork::Workspace memory(runs);
    const std::size_t side = recipe_.architecture.side, pixels = side * side;
    std::vector<float> features(kViews * recipe_.architecture.features), differences(features.size());
    std::array<float, kAnswerOutputs> answer{}, not_told{};
    const Eigen::MatrixXd ridge = fit_ridge();
    Squares told_error, not_told_error, of_mean, of_ridge;
    EyeScore eye_score;
    for (std::size_t d = 0; d < validation_.size(); ++d) {
      if (!progress(static_cast<double>(d) / static_cast<double>(validation_.size()), "measuring"))
        return fail(ErrorCode::cancelled, "stopped while measuring the model");
      const auto& [film, donning] = validation_[d];
      const auto look_at = [&](std::size_t frame) {
        Batch batch;
        append(*film, std::array{frame}, false, nullptr, batch);
        std::array<bool, kViews> present{};
        for (std::size_t v = 0; v < kViews; ++v) present[v] = batch.condition[kViews * pixels + v] > 0;
        runs.find(std::span(batch.condition).first(kViews * pixels), present, memory, features);
        return batch;
      };
      std::vector<float> at_rest(features.size(), 0.0F);
      const auto rests = static_cast<float>(donning.rest_end - donning.begin);
      for (std::size_t frame = donning.begin; frame < donning.rest_end; ++frame) {
        look_at(frame);
        for (std::size_t i = 0; i < features.size(); ++i) at_rest[i] += features[i] / rests;
      }
      for (std::size_t frame = donning.rest_end; frame < donning.end; ++frame) {
        const Batch batch = look_at(frame);
        std::ranges::fill(differences, 0.0F);
        runs.answer(features, differences, memory, not_told);
        if (rests > 0) std::ranges::transform(features, at_rest, differences.begin(), std::minus());
        runs.answer(features, differences, memory, answer);
        const Eigen::VectorXd by_ridge =
            ridge.transpose() * ridge_inputs(std::span(batch.condition).first(kViews * pixels), side);
        for (std::size_t k = 0; k < face::kShapeCount; ++k) {
          if (std::isnan(batch.clean[k])) continue;
          told_error.add(double{answer[k]}, batch.clean[k]);
          not_told_error.add(double{not_told[k]}, batch.clean[k]);
          of_mean.add(double{model_.mean_answer[k]}, batch.clean[k]);
          of_ridge.add(by_ridge[static_cast<Eigen::Index>(k)], batch.clean[k]);
        }
        const headset::Answer seen = headset::decode_answer(answer);
        const synthetic::FilmTruth truth = film->truth(frame);
        for (std::size_t e = 0; e < 2; ++e) {
          if (truth.visible[0] == 0) continue;
          if (truth.openness[e] >= kShutEye) eye_score.add_gaze(seen.gaze_rad, truth.gaze_rad, e);
          eye_score.add_openness(seen.openness[e], truth.openness[e]);
        }
      }
    }
    return nlohmann::json{{"headset",
                           {{"mse", told_error.mean()},
                            {"without_neutral_mse", not_told_error.mean()},
                            {"mean_pose_mse", of_mean.mean()},
                            {"ridge_mse", of_ridge.mean()},
                            {"gaze_median_deg", eye_score.gaze_deg(0.5)},
                            {"gaze_p90_deg", eye_score.gaze_deg(0.9)},
                            {"closed_f1", eye_score.closed_f1()}}}}
        .dump();
  }

 private:
  struct Donning {
    const synthetic::HeadsetFilm* film;
    synthetic::HeadsetFilm::Donning frames;
  };
  static std::vector<Donning> donnings_of(const std::vector<synthetic::HeadsetFilm>& films) {
    std::vector<Donning> all;
    for (const synthetic::HeadsetFilm& film : films)
      for (const synthetic::HeadsetFilm::Donning& frames : film.donnings()) all.push_back({&film, frames});
    return all;
  }

  void find_mean() {
    std::array<double, kAnswerOutputs> sum{}, count{};
    for (const synthetic::HeadsetFilm& film : films_.train)
      for (std::size_t frame = 0; frame < film.frames(); ++frame) {
        const auto wanted = wanted_of(film.truth(frame));
        for (std::size_t i = 0; i < kAnswerOutputs; ++i)
          if (!std::isnan(wanted[i])) {
            sum[i] += double{wanted[i]};
            ++count[i];
          }
      }
    model_.mean_answer.clear();
    for (std::size_t i = 0; i < kAnswerOutputs; ++i)
      model_.mean_answer.push_back(static_cast<float>(sum[i] / std::max(1.0, count[i])));
  }

  /// From ridge_inputs() to the outputs: inputs x outputs.
  [[nodiscard]] Eigen::MatrixXd fit_ridge() const {
    constexpr auto kIn = static_cast<Eigen::Index>(kRidgeInputs),
                   kOut = static_cast<Eigen::Index>(kAnswerOutputs);
    Eigen::MatrixXd square = kBlockRidgePenalty * Eigen::MatrixXd::Identity(kIn, kIn);
    Eigen::MatrixXd product = Eigen::MatrixXd::Zero(kIn, kOut);
    const std::size_t step = training_data().frames / kRidgeMoments + 1, side = recipe_.architecture.side;
    std::size_t number = 0;
    for (const synthetic::HeadsetFilm& film : films_.train)
      for (std::size_t frame = 0; frame < film.frames(); ++frame) {
        if (number++ % step != 0) continue;
        Batch batch;
        append(film, std::array{frame}, false, nullptr, batch);
        const Eigen::VectorXd inputs =
            ridge_inputs(std::span(batch.condition).first(kViews * side * side), side);
        Eigen::VectorXd wanted(kOut);
        // What cannot be known is taken for the mean.
        for (Eigen::Index i = 0; i < kOut; ++i) {
          const float value = batch.clean[static_cast<std::size_t>(i)];
          wanted[i] = double{std::isnan(value) ? model_.mean_answer[static_cast<std::size_t>(i)] : value};
        }
        square.selfadjointView<Eigen::Lower>().rankUpdate(inputs);
        product += inputs * wanted.transpose();
      }
    return square.selfadjointView<Eigen::Lower>().ldlt().solve(product);
  }

  /// Appends a window: of these frames, the first at rest where `known`; `augment` may be null.
  void append(const synthetic::HeadsetFilm& film, std::span<const std::size_t> frames, bool known,
              Random* augment, Batch& batch) const {
    const auto side = static_cast<int>(recipe_.architecture.side);
    const std::size_t pixels = film.side() * film.side(), each = model::views_condition(film.side());
    const bool mirrored = augment != nullptr && augment->chance(kMirrored);
    std::array<ViewLook, kViews> looks;
    std::array<bool, kViews> missing{};
    if (augment != nullptr)
      for (std::size_t v = 0; v < kViews; ++v) {
        looks[v] = draw_look(*augment);
        missing[v] = augment->chance(kViewMissing);
      }
    std::vector<std::uint8_t> changed, memory;
    for (const std::size_t frame : frames) {
      const std::size_t begin = batch.condition.size();
      batch.condition.resize(begin + each, 0.0F);
      for (std::size_t v = 0; v < kViews; ++v) {
        // A mirrored face's left camera sees what the right one saw, mirrored: and right views are shown
        // mirrored.
        const FilmPlace& place = places_[mirrored ? v ^ 1U : v];
        if (!place.is_there || missing[v]) continue;
        const std::span<const std::uint8_t> view = film.view(frame, place.camera);
        changed.assign(view.begin(), view.end());
        if (augment != nullptr) {
          show_as(looks[v], changed, side, memory);
          spoil_view(changed, side, *augment);
        }
        auto shown = headset::NetworkView::create(place.view);
        shown->make({.width = side, .height = side, .pixels = changed},
                    std::span(batch.condition).subspan(begin + v * pixels, pixels));
        batch.condition[begin + kViews * pixels + v] = 1;
      }
      batch.condition[begin + each - 1] = known ? 1 : 0;
      const auto wanted = wanted_of(film.truth(frame));
      const auto asked = mirrored ? mirrored_answer(wanted) : wanted;
      batch.clean.insert(batch.clean.end(), asked.begin(), asked.end());
    }
    batch.level.push_back(0);
    batch.held.push_back(0);
    ++batch.windows;
  }

  synthetic::HeadsetFilms films_;
  FilmPlaces places_;
  std::vector<Donning> training_, validation_;
};

}  // namespace

Result<std::unique_ptr<Task>> make_views_task(Recipe recipe, synthetic::HeadsetFilms films,
                                              const sensor::Rig& rig, std::string rig_text) {
  if (recipe.architecture.kind != model::NetworkKind::views)
    return fail(ErrorCode::bad_usage, "a headset's network is one of pictures", "[network] architecture",
                "write architecture = \"views\"");
  recipe.architecture.outputs = kAnswerOutputs;
  recipe.gaze_outputs = gaze_outputs();
  MIEN_TRY(model::check(recipe.architecture));
  MIEN_TRY_ASSIGN(const FilmPlaces places, film_places(films, rig, recipe.architecture.side));
  const auto is_empty = [](const synthetic::HeadsetFilm& film) { return film.frames() == 0; };
  if (std::ranges::all_of(films.train, is_empty) || std::ranges::all_of(films.validation, is_empty))
    return fail(ErrorCode::bad_usage, "there are no films to learn from", "[data] wearers");
  return std::make_unique<ViewsTask>(std::move(recipe), std::move(films), places, std::move(rig_text));
}

}  // namespace mien::train
