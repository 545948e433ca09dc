#include "mien/train/tasks.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <utility>

#include "mien/core/sha256.h"
#include "mien/core/units.h"
#include "mien/eyewear/marker_network.h"
#include "mien/model/ridge.h"
#include "mien/synthetic/eyewear/eyewear_dataset.h"

namespace mien::train {
namespace {

using synthetic::LightDataset;
using synthetic::LightSequence;

constexpr double kRidgePenalty = 1e-3;

Result<void> check(const LightDataset& dataset) {
  const std::size_t n = dataset.sensors.size(), v = dataset.markers.size();
  if (n == 0 || v == 0) return fail(ErrorCode::mismatch, "the data set has no sensors or no markers");
  for (std::size_t i = 0; i < dataset.sequences.size(); ++i) {
    const LightSequence& s = dataset.sequences[i];
    const std::string where = fmt::format("sequence {}", i);
    if (s.values.size() != s.frames * n || s.present.size() != s.frames * n ||
        s.displacement_m.size() != s.frames * 3 * v)
      return fail(ErrorCode::mismatch, fmt::format("its arrays do not fit {} frames", s.frames), where);
    if (!all_finite(s.values) || !all_finite(s.displacement_m))
      return fail(ErrorCode::out_of_range, "it holds a number that is not finite", where);
  }
  return {};
}

TaskData data_of(const LightDataset& dataset) {
  Sha256 hash;
  std::size_t frames = 0;
  for (const auto* names : {&dataset.sensors, &dataset.markers})
    for (const std::string& name : *names) {
      hash.add(std::as_bytes(std::span(name)));
      hash.add_value('\n');
    }
  for (const LightSequence& s : dataset.sequences) {
    hash.add_value(s.wearer);
    hash.add_value(static_cast<std::uint64_t>(s.frames));
    hash.add(std::as_bytes(std::span(s.values)));
    hash.add(std::as_bytes(std::span(s.present)));
    hash.add(std::as_bytes(std::span(s.displacement_m)));
    frames += s.frames;
  }
  return {.hash = hash.hex(), .frames = frames};
}

WindowPlaces places_in(const LightDataset& dataset, std::size_t window) {
  std::vector<std::size_t> frames;
  for (const LightSequence& s : dataset.sequences) frames.push_back(s.frames);
  return {std::move(frames), window};
}

/// One frame of a sequence, without the sensors that are lost.
void read_light(const LightSequence& sequence, std::size_t frame, std::span<const std::uint8_t> lost,
                eyewear::LightFrame& light) {
  const std::size_t n = light.values.size();
  for (std::size_t s = 0; s < n; ++s) {
    light.values[s] = sequence.values[frame * n + s];
    light.present[s] = lost.empty() || lost[s] == 0 ? sequence.present[frame * n + s] : 0;
  }
}

eyewear::LightFrame frame_of(std::size_t sensors) {
  return {.values = std::vector<float>(sensors), .present = std::vector<std::uint8_t>(sensors)};
}

std::vector<float> condition_of(const LightSequence& sequence, std::size_t sensors) {
  eyewear::LightFrame light = frame_of(sensors);
  std::vector<float> condition(sequence.frames * 2 * sensors);
  for (std::size_t f = 0; f < sequence.frames; ++f) {
    read_light(sequence, f, {}, light);
    eyewear::encode_light(light, std::span(condition).subspan(f * 2 * sensors, 2 * sensors));
  }
  return condition;
}

/// Sum of the distances of all markers of a frame, mm.
double distances_mm(const Eigen::VectorXd& estimate_m, std::span<const float> truth_m) {
  double sum = 0;
  for (Eigen::Index m = 0; m < estimate_m.size(); m += 3) {
    Eigen::Vector3d off;
    for (Eigen::Index i = 0; i < 3; ++i)
      off[i] = estimate_m[m + i] - double{truth_m[static_cast<std::size_t>(m + i)]};
    sum += kMmPerM * off.norm();
  }
  return sum;
}

/// Light of photo-reflective sensors to markers.
class MarkerTask final : public FileTask<eyewear::MarkerNetworkFile, eyewear::read_marker_network,
                                         eyewear::write_marker_network> {
 public:
  MarkerTask(Recipe recipe, LightDataset training, LightDataset validation, std::string rig)
      : FileTask(std::move(recipe), data_of(training), data_of(validation)),
        training_(std::move(training)),
        validation_(std::move(validation)) {
    model_.sensors = training_.sensors;
    model_.markers = training_.markers;
    model_.face = training_.face;
    model_.scale_m = kScaleM;
    model_.rig = std::move(rig);
  }

  [[nodiscard]] Batch random_batch(std::size_t count, Random random) const override {
    const WindowPlaces places = places_in(training_, recipe_.architecture.window);
    Batch batch;
    std::vector<std::uint8_t> lost(training_.sensors.size());
    for (std::size_t i = 0; i < count; ++i) {
      const WindowPlaces::Place place = places.draw(random);
      const double chance = random.chance(recipe_.many_lost) ? random.uniform(0, 0.9) : recipe_.sensor_loss;
      for (std::uint8_t& sensor : lost) sensor = random.chance(chance) ? 1 : 0;
      append_window(training_.sequences[place.sequence], place.first, lost, batch);
    }
    return batch;
  }

  [[nodiscard]] Batch validation_batch(Random) const override {
    Batch batch;
    for (const WindowPlaces::Place& place :
         places_in(validation_, recipe_.architecture.window).even(recipe_.windows))
      append_window(validation_.sequences[place.sequence], place.first, {}, batch);
    return batch;
  }

  [[nodiscard]] Result<std::vector<model::Tensor>> begin_with(const std::filesystem::path& model) override {
    MIEN_TRY_ASSIGN(eyewear::MarkerNetworkFile standing, eyewear::read_marker_network(model));
    if (standing.architecture.kind != recipe_.architecture.kind ||
        model::network_tensors(standing.architecture) != model::network_tensors(recipe_.architecture) ||
        standing.sensors != model_.sensors || standing.markers != model_.markers ||
        standing.scale_m != model_.scale_m)
      return fail(ErrorCode::mismatch, "it is a network of another size or of other sensors", model.string(),
                  "start from a model of the recipe's own architecture and rig");
    return std::move(standing.network);
  }

  /// "markers": mean distance over validation, of the network frame by frame, of a ridge on the same frames,
  /// and of neutral, mm.
  [[nodiscard]] Result<std::string> assess(std::span<const model::Tensor> network,
                                           const Progress& progress) override {
    model_.network.assign(network.begin(), network.end());
    MIEN_TRY_ASSIGN(const auto regressor, eyewear::NetworkRegressor::create(model_, model_.sensors));
    const std::size_t n = training_.sensors.size(), outputs = recipe_.architecture.outputs;
    model::RidgeFit fit(2 * n, outputs);
    for (const LightSequence& s : training_.sequences) fit.add(condition_of(s, n), s.displacement_m);
    MIEN_TRY_ASSIGN(const model::RidgeBaseline ridge, fit.solve(kRidgePenalty));
    using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    const Eigen::Map<const RowMajor> matrix(ridge.matrix.data(), static_cast<Eigen::Index>(outputs),
                                            static_cast<Eigen::Index>(2 * n + 1));

    double network_mm = 0, ridge_mm = 0, neutral_mm = 0;
    eyewear::LightFrame light = frame_of(n);
    Eigen::VectorXd estimate_m;
    Eigen::VectorXf condition = Eigen::VectorXf::Ones(static_cast<Eigen::Index>(2 * n + 1));
    for (std::size_t i = 0; i < validation_.sequences.size(); ++i) {
      if (!progress(static_cast<double>(i) / static_cast<double>(validation_.sequences.size()), "measuring"))
        return fail(ErrorCode::cancelled, "stopped while measuring the model");
      const LightSequence& s = validation_.sequences[i];
      regressor->reset();
      for (std::size_t f = 0; f < s.frames; ++f) {
        const std::span<const float> truth_m = std::span(s.displacement_m).subspan(f * outputs, outputs);
        read_light(s, f, {}, light);
        regressor->step(light, estimate_m);
        network_mm += distances_mm(estimate_m, truth_m);
        eyewear::encode_light(light, std::span(condition.data(), 2 * n));
        ridge_mm += distances_mm((matrix * condition).cast<double>(), truth_m);
        neutral_mm += distances_mm(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(outputs)), truth_m);
      }
    }
    const auto count = static_cast<double>(validation_data().frames * training_.markers.size());
    return nlohmann::json{{"markers",
                           {{"mean_mm", network_mm / count},
                            {"ridge_mean_mm", ridge_mm / count},
                            {"neutral_mean_mm", neutral_mm / count}}}}
        .dump();
  }

 private:
  /// An output of 1, metres: farther than any marker moves.
  static constexpr double kScaleM = 0.06;

  void append_window(const LightSequence& sequence, std::size_t first, const std::vector<std::uint8_t>& lost,
                     Batch& batch) const {
    const std::size_t n = training_.sensors.size(), outputs = recipe_.architecture.outputs;
    eyewear::LightFrame light = frame_of(n);
    std::size_t at = batch.condition.size();
    batch.condition.resize(at + recipe_.architecture.window * 2 * n);
    for (std::size_t f = first; f < first + recipe_.architecture.window; ++f, at += 2 * n) {
      read_light(sequence, f, lost, light);
      eyewear::encode_light(light, std::span(batch.condition).subspan(at, 2 * n));
      for (std::size_t o = 0; o < outputs; ++o)
        batch.clean.push_back(static_cast<float>(double{sequence.displacement_m[f * outputs + o]} / kScaleM));
    }
    batch.level.push_back(0);
    batch.held.push_back(0);
    ++batch.windows;
  }

  LightDataset training_;
  LightDataset validation_;
};

}  // namespace

Result<std::unique_ptr<Task>> make_marker_task(Recipe recipe, LightDataset training, LightDataset validation,
                                               std::string rig) {
  if (recipe.architecture.kind != model::NetworkKind::causal)
    return fail(ErrorCode::bad_usage, "smart eyewear's network is a causal one", "[network] architecture",
                "write architecture = \"causal\"");
  MIEN_TRY(check(training));
  MIEN_TRY(check(validation));
  if (training.sensors != validation.sensors || training.markers != validation.markers)
    return fail(ErrorCode::mismatch, "training and validation have different sensors or markers", "data set");
  std::set<std::uint32_t> trained_on;
  for (const LightSequence& s : training.sequences) trained_on.insert(s.wearer);
  for (const LightSequence& s : validation.sequences)
    if (trained_on.contains(s.wearer))
      return fail(ErrorCode::mismatch, fmt::format("wearer {} is both trained and validated on", s.wearer),
                  "data set");
  recipe.architecture.condition = 2 * training.sensors.size();
  recipe.architecture.outputs = 3 * training.markers.size();
  MIEN_TRY(model::check(recipe.architecture));
  for (const LightDataset* data : {&training, &validation})
    if (places_in(*data, recipe.architecture.window).count() == 0)
      return fail(ErrorCode::bad_usage, fmt::format("training or validation has no sequence of {} frames",
                                                    recipe.architecture.window));
  return std::make_unique<MarkerTask>(std::move(recipe), std::move(training), std::move(validation),
                                      std::move(rig));
}

}  // namespace mien::train
