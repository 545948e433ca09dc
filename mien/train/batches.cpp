#include "mien/train/batches.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "mien/core/rotation.h"
#include "mien/core/sha256.h"
#include "mien/face/profile.h"
#include "mien/model/schedule.h"

namespace mien::train {
namespace {

/// A scale is never taken for smaller than this: a value that hardly changes must not be blown up into noise.
constexpr double kSmallestScale = 1e-3;

/// Turns a rotation (w, x, y, z) by a rotation vector, both in the frame that it is given in.
void turn_by(const Vec3& turn, float* wxyz) {
  const Quat q = canonical(exp_rotation(turn) * Quat(wxyz[0], wxyz[1], wxyz[2], wxyz[3]));
  wxyz[0] = static_cast<float>(q.w());
  wxyz[1] = static_cast<float>(q.x());
  wxyz[2] = static_cast<float>(q.y());
  wxyz[3] = static_cast<float>(q.z());
}

/// Turns it by a random vector of `sigma` radians an axis.
void disturb(float* wxyz, double sigma, Random& random) {
  const double x = random.normal(0, sigma), y = random.normal(0, sigma), z = random.normal(0, sigma);
  turn_by({x, y, z}, wxyz);
}

template <class T>
void add_array(Sha256& hash, const std::vector<T>& values) {
  hash.add(std::as_bytes(std::span(values)));
}

/// All but whose it is.
void add_sequence(Sha256& hash, const dataset::Sequence& s) {
  hash.add_value(static_cast<std::uint8_t>((s.lab ? 1 : 0) + (s.from_take ? 2 : 0)));
  hash.add_value(static_cast<std::uint64_t>(s.frames));
  add_array(hash, s.slopes);
  add_array(hash, s.values);
  add_array(hash, s.present);
  add_array(hash, s.weights);
}

}  // namespace

bool all_finite(std::span<const float> values) {
  return std::ranges::all_of(values, [](float v) { return std::isfinite(v); });
}

Result<void> check(const dataset::Dataset& dataset) {
  const std::size_t n = dataset.sensors.size();
  if (n == 0) return fail(ErrorCode::mismatch, "the data set has no sensors");
  if (!dataset.standard_slopes.empty() &&
      (dataset.standard_slopes.size() != 3 * n * face::kShapeCount || !all_finite(dataset.standard_slopes)))
    return fail(ErrorCode::mismatch, "the standard skin does not fit the sensors", "data set");
  for (std::size_t i = 0; i < dataset.sequences.size(); ++i) {
    const dataset::Sequence& s = dataset.sequences[i];
    const std::string where = fmt::format("sequence {}", i);
    if (s.values.size() != s.frames * 7 * n || s.present.size() != s.frames * 2 * n ||
        s.weights.size() != s.frames * face::kShapeCount ||
        (!s.slopes.empty() && s.slopes.size() != 3 * n * face::kShapeCount))
      return fail(ErrorCode::mismatch,
                  fmt::format("its arrays do not fit {} frames of {} sensors", s.frames, n), where);
    if (!all_finite(s.values) || !all_finite(s.weights) || !all_finite(s.slopes))
      return fail(ErrorCode::out_of_range, "it holds a number that is not finite", where);
  }
  return {};
}

std::string hash_of(const dataset::Dataset& dataset) {
  Sha256 hash;
  for (const std::string& sensor : dataset.sensors) {
    hash.add(std::as_bytes(std::span(sensor)));
    hash.add_value('\n');
  }
  for (const dataset::Sequence& s : dataset.sequences) {
    hash.add_value(s.performer);
    add_sequence(hash, s);
  }
  add_array(hash, dataset.standard_slopes);
  return hash.hex();
}

std::string hash_of_takes(const dataset::Dataset& training, const dataset::Dataset& validation) {
  Sha256 hash;
  for (const dataset::Dataset* dataset : {&training, &validation}) {
    for (const dataset::Sequence& s : dataset->sequences)
      if (s.from_take) add_sequence(hash, s);
    hash.add_value('\n');
  }
  return hash.hex();
}

Result<void> check_apart(const dataset::Dataset& training, const dataset::Dataset& validation) {
  if (training.sensors != validation.sensors)
    return fail(ErrorCode::mismatch, "training and validation have different sensors", "data set");
  std::set<std::uint32_t> trained_on;
  for (const dataset::Sequence& s : training.sequences) trained_on.insert(s.performer);
  for (const dataset::Sequence& s : validation.sequences)
    if (trained_on.contains(s.performer))
      return fail(ErrorCode::mismatch,
                  fmt::format("performer {} is both trained and validated on", s.performer), "data set");
  return {};
}

model::FeatureNormalisation normalisation_of(const dataset::Dataset& dataset, double lab_noise_rad,
                                             const FrameWeights& weights) {
  const std::size_t n = dataset.sensors.size();
  std::vector<double> sum(7 * n), squares(7 * n), count(7 * n);
  for (const dataset::Sequence& s : dataset.sequences) {
    const double weight = weights.of(s);
    for (std::size_t f = 0; f < s.frames; ++f)
      for (std::size_t sensor = 0; sensor < n; ++sensor)
        for (std::size_t v = 0; v < 7; ++v) {
          if (s.present[f * 2 * n + (v < 3 ? n + sensor : sensor)] == 0) continue;
          const std::size_t at = 7 * sensor + v;
          const double value = s.values[f * 7 * n + at];
          // A turn by `noise` moves a quaternion's vector part by half of it.
          const double noise = s.lab && v > 3 ? lab_noise_rad / 2 : 0;
          sum[at] += weight * value;
          squares[at] += weight * (value * value + noise * noise);
          count[at] += weight;
        }
  }
  model::FeatureNormalisation result;
  for (std::size_t at = 0; at < 7 * n; ++at) {
    const double mean = count[at] > 0 ? sum[at] / count[at] : 0;
    const double variance = count[at] > 0 ? squares[at] / count[at] - mean * mean : 1;
    result.mean.push_back(static_cast<float>(mean));
    result.scale.push_back(static_cast<float>(std::max(std::sqrt(std::max(variance, 0.0)), kSmallestScale)));
  }
  return result;
}

BatchMaker::BatchMaker(const dataset::Dataset& dataset, const Recipe& recipe,
                       const model::FeatureLayout& layout, const model::FeatureNormalisation& normalisation,
                       const std::optional<model::Skin>& skin, const std::vector<float>& mean_pose)
    : dataset_(dataset),
      recipe_(recipe),
      layout_(layout),
      normalisation_(normalisation),
      skin_(skin),
      mean_pose_(mean_pose) {}

std::optional<model::SkinMap> BatchMaker::draw_skin(std::size_t sequence, Random& random) const {
  const std::vector<float>& slopes = dataset_.sequences[sequence].slopes;
  if (!skin_ || slopes.empty() || recipe_.known_skin == 0 || !random.chance(recipe_.known_skin))
    return std::nullopt;
  model::Skin known = *skin_;
  known.wearer = slopes;
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    const double gain = 1 + random.normal(0, recipe_.skin_gain_error);
    for (std::size_t s = 0; s < layout_.sensors.size(); ++s) {
      float* slope[3];
      double square = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        slope[axis] = &known.wearer[(3 * s + axis) * face::kShapeCount + k];
        square += *slope[axis] * *slope[axis] / 3;
      }
      const double error = recipe_.skin_slope_error * std::sqrt(square);
      for (float* value : slope) *value = static_cast<float>(*value * gain + random.normal(0, error));
    }
  }
  return model::SkinMap(known, mean_pose_);
}

void BatchMaker::encode_with(std::size_t sequence, std::size_t first, std::size_t count, const Loss& loss,
                             Random& random, std::span<float> out) const {
  const dataset::Sequence& s = dataset_.sequences[sequence];
  const std::size_t n = layout_.sensors.size(), width = layout_.width();
  std::vector<float> values(7 * n);
  std::vector<std::uint8_t> present(2 * n);
  std::vector<float> on_standard(7 * n);
  std::optional<model::SkinMap> skin = draw_skin(sequence, random);
  for (std::size_t f = 0; f < count; ++f) {
    const float* read = s.values.data() + (first + f) * 7 * n;
    const std::uint8_t* there = s.present.data() + (first + f) * 2 * n;
    for (std::size_t sensor = 0; sensor < n; ++sensor) {
      if (f > 0 && !loss.held.empty() && loss.held[f * n + sensor] != 0) continue;  // As it was.
      std::copy_n(read + 7 * sensor, 7, values.data() + 7 * sensor);
      present[sensor] = there[sensor];
      present[n + sensor] = there[n + sensor];
      if (!loss.sensor.empty() && loss.sensor[sensor] != 0) present[sensor] = present[n + sensor] = 0;
      if (loss.acceleration) present[n + sensor] = 0;
      if (s.lab && present[sensor] != 0)
        disturb(values.data() + 7 * sensor + 3, recipe_.lab_noise_rad, random);
      else if (!loss.heading_rad.empty() && present[sensor] != 0)
        turn_by(loss.heading_rad[sensor] * Vec3::UnitY(), values.data() + 7 * sensor + 3);
    }
    for (const Loss::Stretch& away : loss.away)
      if (f >= away.begin && f < away.end) present[away.sensor] = present[n + away.sensor] = 0;
    // What is held is what the sensor said, so the map does not come upon its own answer.
    on_standard = values;
    if (skin) skin->apply(on_standard, present);
    model::encode_values(layout_, normalisation_, on_standard, present, out.subspan(f * width, width));
  }
}

void BatchMaker::encode(std::size_t sequence, std::size_t first, std::size_t count, Random& random,
                        std::span<float> out) const {
  encode_with(sequence, first, count, {}, random, out);
}

BatchMaker::Loss BatchMaker::draw_loss(Random& random) const {
  Loss loss{.sensor = std::vector<std::uint8_t>(layout_.sensors.size()),
            .acceleration = random.chance(recipe_.acceleration_loss)};
  const double chance = random.chance(recipe_.many_lost) ? random.uniform(0, 0.9) : recipe_.sensor_loss;
  for (std::uint8_t& lost : loss.sensor) lost = random.chance(chance) ? 1 : 0;
  if (recipe_.stretch_loss > 0) draw_stretches(random, loss);
  if (recipe_.held_readings > 0 && random.chance(recipe_.held_readings)) draw_held(random, loss);
  if (recipe_.heading_drift > 0 && random.chance(recipe_.heading_drift)) {
    const double sigma_rad = random.uniform(0, recipe_.heading_drift_rad);
    for (std::size_t s = 0; s < layout_.sensors.size(); ++s)
      loss.heading_rad.push_back(random.normal(0, sigma_rad));
  }
  return loss;
}

void BatchMaker::draw_stretches(Random& random, Loss& loss) const {
  const std::size_t frames = recipe_.architecture.window, n = layout_.sensors.size();
  // Lengths of every order are equally likely, and a stretch may have begun before the window.
  const auto draw = [&](std::size_t sensor) {
    const auto length =
        static_cast<std::size_t>(std::exp(random.uniform(0, std::log(static_cast<double>(frames)))));
    const std::size_t end = 1 + static_cast<std::size_t>(random.below(frames + length - 1));
    return Loss::Stretch{.sensor = sensor, .begin = end > length ? end - length : 0, .end = end};
  };
  for (std::size_t sensor = 0; sensor < n; ++sensor)
    if (random.chance(recipe_.stretch_loss)) loss.away.push_back(draw(sensor));
  if (!random.chance(recipe_.stretch_loss)) return;
  Loss::Stretch all = draw(0);
  for (; all.sensor < n; ++all.sensor) loss.away.push_back(all);
}

void BatchMaker::draw_held(Random& random, Loss& loss) const {
  constexpr double kMostShare = 0.4;
  constexpr std::uint64_t kLongest = 6;  // Frames: a tenth of a second, after which a sensor is missing.
  const std::size_t frames = recipe_.architecture.window, n = layout_.sensors.size();
  const double share = random.uniform(0, kMostShare);
  loss.held.resize(frames * n);
  for (std::size_t sensor = 0; sensor < n; ++sensor)
    for (std::size_t f = 0; f < frames; ++f) {
      if (!random.chance(share / (static_cast<double>(kLongest) / 2))) continue;
      for (std::uint64_t left = 1 + random.below(kLongest); left > 0 && f < frames; --left)
        loss.held[f++ * n + sensor] = 1;
    }
}

void BatchMaker::append_window(std::size_t sequence, std::size_t first, const Loss& loss, Random& random,
                               Batch& batch) const {
  const std::size_t window = recipe_.architecture.window, outputs = recipe_.architecture.outputs,
                    width = layout_.width();
  const std::size_t at = batch.condition.size();
  batch.condition.resize(at + window * width);
  encode_with(sequence, first, window, loss, random, std::span(batch.condition).subspan(at));
  const float* weights = dataset_.sequences[sequence].weights.data() + first * outputs;
  for (std::size_t i = 0; i < window * outputs; ++i) batch.clean.push_back(model::to_network(weights[i]));
  ++batch.windows;
}

WindowPlaces BatchMaker::window_places(WindowsOf whose) const {
  std::vector<std::size_t> frames;  // None of those who are not meant.
  for (const dataset::Sequence& s : dataset_.sequences)
    frames.push_back(s.from_take == (whose == WindowsOf::takes) ? s.frames : 0);
  return {std::move(frames), recipe_.architecture.window};
}

std::size_t BatchMaker::places(WindowsOf whose) const {
  return window_places(whose).count();
}

Batch BatchMaker::random_batch(std::size_t count, Random random) const {
  const WindowPlaces performed = window_places(WindowsOf::virtual_performers),
                     taken = window_places(WindowsOf::takes);
  const double share = taken.count() == 0       ? 0
                       : performed.count() == 0 ? 1
                                                : recipe_.takes_share.value_or(kUsualTakesShare);
  const double phase = random.fork("takes").uniform();
  Batch batch;
  for (std::size_t i = 0; i < count; ++i) {
    const WindowPlaces::Place place = (is_from_take(i, share, phase) ? taken : performed).draw(random);
    append_window(place.sequence, place.first, draw_loss(random), random, batch);
    // One level from each equal part of the range: evenly drawn with less scatter from step to step.
    const double u = (static_cast<double>(i) + random.uniform()) / static_cast<double>(count);
    const auto levels = static_cast<double>(recipe_.schedule.levels);
    batch.level.push_back(
        static_cast<std::int64_t>(std::min(levels - 1, levels * std::pow(u, 1 / (1 + recipe_.t_bias)))));
    batch.held.push_back(
        random.chance(recipe_.held_overlap) ? static_cast<std::int64_t>(recipe_.architecture.window / 2) : 0);
  }
  return batch;
}

Batch BatchMaker::even_batch(std::size_t count, Random random, WindowsOf whose) const {
  Batch batch;
  for (const WindowPlaces::Place& place : window_places(whose).even(count))
    append_window(place.sequence, place.first, {}, random, batch);
  batch.level.assign(batch.windows, 0);
  batch.held.assign(batch.windows, 0);
  return batch;
}

}  // namespace mien::train
