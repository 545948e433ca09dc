#include "mien/train/trainer.h"

#include <ATen/Parallel.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <future>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <thread>

#include "mien/core/files.h"
#include "mien/core/sha256.h"
#include "mien/train/checkpoint.h"
#include "mien/train/diffusion.h"
#include "mien/train/network.h"
#include "mien/train/optimiser.h"

namespace mien::train {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
constexpr const char* kCurveHead =
    "step,seconds,windows,learning_rate,training_loss,validation_loss,validation_mse\n";
/// Share of the whole that choosing the sampler is shown as.
constexpr double kAssessShare = 0.02;

double now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::string sha256(std::string_view text) {
  Sha256 hash;
  hash.add(std::as_bytes(std::span(text)));
  return hash.hex();
}

Result<torch::Device> find_device(const std::string& name) {
  try {
    const torch::Device device(name);
    (void)torch::zeros({1}, device);
    return device;
  } catch (const std::exception&) {
    return fail(ErrorCode::bad_usage, fmt::format("libtorch has no device {:?} here", name), "--device",
                "use cpu");
  }
}

void use_threads(int threads) {
  // libtorch starts with one thread where OpenMP's own default is unset.
  at::set_num_threads(threads > 0 ? threads
                                  : static_cast<int>(std::max(1U, std::thread::hardware_concurrency())));
}

/// The rate at a step: warm-up, then a half cosine down to a hundredth over the budget.
double learning_rate(const Recipe& recipe, std::int64_t step, double fraction) {
  const double warm =
      recipe.warm_up_steps == 0
          ? 1.0
          : std::min(1.0, static_cast<double>(step + 1) / static_cast<double>(recipe.warm_up_steps));
  const double decay = recipe.cosine_decay
                           ? 0.01 + 0.99 * 0.5 * (1 + std::cos(std::numbers::pi * std::min(fraction, 1.0)))
                           : 1.0;
  return recipe.learning_rate * warm * decay;
}

/// One optimisation step on a batch; the loss.
double take_step(const Recipe& recipe, const torch::Device& device, const NoiseMixer& mixer,
                 const Batch& batch, bool batch_norm, std::int64_t step, double rate, Parameters& weights,
                 Adam& adam, MovingAverage& average) {
  // Noise and dropout start anew from the step's number, so nothing needs to be remembered across a restart.
  torch::manual_seed(Random(recipe.seed).fork("step", static_cast<std::uint64_t>(step)).bits());
  const DeviceBatch windows = to_device(batch, recipe, device);
  const Pass pass{.dropout = recipe.dropout, .bf16 = recipe.bf16, .batch_norm = batch_norm};
  torch::Tensor predicted;
  if (recipe.architecture.kind != model::NetworkKind::window) {
    predicted = answer_at_once(recipe, weights, windows.condition, pass);
  } else {
    const torch::Tensor noisy = mixer.mix(windows, torch::randn_like(windows.clean));
    predicted = predict(recipe.architecture, weights, noisy, windows.condition, windows.level, pass);
  }
  const torch::Tensor loss = loss_of(recipe, predicted, windows);
  loss.backward();
  adam.step(weights, rate, recipe.clip_norm);
  if (static_cast<std::size_t>(adam.steps) % recipe.ema_every == 0) average.add(weights, recipe.ema);
  return loss.item<double>();
}

/// Batches of the steps to come, made while the device computes. Each is a function of the recipe's seed and
/// of its step's number alone.
class BatchStream {
 public:
  /// Keeps the task. `ahead`: batches that are made before they are asked for.
  BatchStream(const Task& task, std::int64_t first_step, std::size_t ahead)
      : task_(task), next_step_(first_step), ahead_(ahead) {}

  /// That of the next step. Waits for it.
  Batch next() {
    while (coming_.size() <= ahead_)
      coming_.push_back(std::async(std::launch::async, [this, step = next_step_++] {
        const Recipe& recipe = task_.recipe();
        return task_.random_batch(recipe.batch,
                                  Random(recipe.seed).fork("batch", static_cast<std::uint64_t>(step)));
      }));
    Batch batch = coming_.front().get();
    coming_.pop_front();
    return batch;
  }

 private:
  const Task& task_;
  std::int64_t next_step_;
  std::size_t ahead_;
  std::deque<std::future<Batch>> coming_;
};

class Training {
 public:
  Training(Task& task, const TrainOptions& options, const Progress& progress)
      : task_(task), recipe_(task.recipe()), options_(options), progress_(progress) {
    checkpoint_path_ = options.out;
    checkpoint_path_ += ".checkpoint";
    curve_path_ = fs::path(options.out).replace_extension(".csv");
  }

  Result<TrainReport> run() {
    MIEN_TRY(prepare());
    MIEN_TRY(standing_score());  // Refuses to replace one that it cannot be compared with.
    MIEN_TRY(start());
    MIEN_TRY(loop());
    return finish();
  }

 private:
  Result<void> prepare() {
    MIEN_TRY_ASSIGN(device_, find_device(options_.device));
    use_threads(options_.threads);
    mixer_.emplace(recipe_.schedule, *device_);
    std::string from;
    if (!options_.from.empty()) {
      MIEN_TRY_ASSIGN(begin_with_, task_.begin_with(options_.from));
      Sha256 hash;
      for (const model::Tensor& tensor : begin_with_) hash.add(std::as_bytes(std::span(tensor.values)));
      from = " " + hash.hex();
    }
    validation_ = task_.validation_parts(Random(recipe_.seed).fork("validation"));
    validation_hash_ = sha256(fmt::format("{} {} {} {}", task_.validation_data().hash, recipe_.windows,
                                          recipe_.seed, recipe_.score == Score::mse ? "mse" : "loss"));
    run_ = sha256(fmt::format("{} {} {} {}{}", recipe_.text, task_.training_data().hash, validation_hash_,
                              options_.device, from));
    return {};
  }

  /// The score of the model that stands at `out`, if it was measured on the same validation data.
  Result<std::optional<double>> standing_score() const {
    std::error_code code;
    if (!fs::exists(options_.out, code) || options_.force) return std::nullopt;
    MIEN_TRY_ASSIGN(const std::string text, task_.results_of(options_.out));
    const Json results = Json::parse(text, nullptr, false);
    const Json validation =
        results.is_object() && results.contains("validation") ? results["validation"] : Json();
    if (!validation.is_object() || !validation.contains("hash") || validation["hash"] != validation_hash_ ||
        !validation.contains("score") || !validation["score"].is_number())
      return fail(ErrorCode::mismatch,
                  "the model that stands here was measured on other data, so it cannot be compared",
                  options_.out.string(), "name another file, or use --force");
    return validation["score"].get<double>();
  }

  Result<void> start() {
    if (options_.from.empty()) {
      weights_ = fresh_parameters(recipe_.architecture, recipe_.seed, recipe_.near_first, *device_);
      // What is added to an answer begins at nothing: the last layer's weight and bias.
      if (recipe_.addition) {
        const at::NoGradGuard no_gradients;
        for (auto last = weights_.end() - 2; last != weights_.end(); ++last) last->zero_();
      }
    } else {
      weights_ = from_tensors(begin_with_, *device_);
      for (torch::Tensor& weight : weights_) weight.requires_grad_();
    }
    // A standing network's normalisation is folded into its weights, and stays as it was.
    batch_norm_ = recipe_.architecture.kind == model::NetworkKind::views && options_.from.empty();
    adam_.emplace(weights_, recipe_.muon ? matrices_of_backbones(recipe_.architecture) : std::vector<bool>());
    average_.emplace(weights_);
    state_.run = run_;
    state_.curve = kCurveHead;
    std::error_code code;
    if (!fs::exists(checkpoint_path_, code) || options_.force) return {};
    if (!options_.resume)
      return fail(ErrorCode::bad_usage, "an unfinished run stands here", checkpoint_path_.string(),
                  "use --resume to go on with it, or --force to begin anew");
    MIEN_TRY_ASSIGN(state_, read_checkpoint(checkpoint_path_, recipe_.architecture));
    if (state_.run != run_)
      return fail(ErrorCode::mismatch, "the checkpoint belongs to another recipe, data set or device",
                  checkpoint_path_.string(), "use --force to begin anew");
    weights_ = from_tensors(state_.weights, *device_);
    for (torch::Tensor& p : weights_) p.requires_grad_();
    adam_->mean = from_tensors(state_.adam_mean, *device_);
    adam_->square = from_tensors(state_.adam_square, *device_);
    adam_->steps = state_.step;
    average_->average = from_tensors(state_.average, *device_);
    average_->count = state_.averagings;
    return {};
  }

  [[nodiscard]] double fraction() const {
    const double by_steps =
        recipe_.steps == 0 ? 0 : static_cast<double>(state_.step) / static_cast<double>(recipe_.steps);
    const double by_time = recipe_.seconds == 0 ? 0 : state_.seconds / recipe_.seconds;
    return std::max(by_steps, by_time);
  }

  Result<void> loop() {
    const std::size_t ahead = device_->is_cpu() ? 1 : 8;
    BatchStream stream(task_, state_.step, ahead);
    double mark_s = now_s(), last_validation_s = mark_s;
    while (fraction() < 1) {
      const double rate = learning_rate(recipe_, state_.step, fraction());
      const double loss = take_step(recipe_, *device_, *mixer_, stream.next(), batch_norm_, state_.step, rate,
                                    weights_, *adam_, *average_);
      if (!std::isfinite(loss))
        return fail(ErrorCode::internal, fmt::format("the loss is no longer finite at step {}", state_.step),
                    options_.out.string(), "lower optimiser.learning_rate; the last checkpoint is sound");
      ++state_.step;
      shown_loss_ = shown_loss_ == 0 ? loss : 0.98 * shown_loss_ + 0.02 * loss;
      state_.loss_sum += loss;
      ++state_.losses;
      const double at_s = now_s();
      state_.seconds += at_s - mark_s;
      const double speed = static_cast<double>(recipe_.batch) / (at_s - mark_s);
      shown_speed_ = shown_speed_ == 0 ? speed : 0.95 * shown_speed_ + 0.05 * speed;
      const bool go_on = progress_((1 - kAssessShare) * std::min(fraction(), 1.0), status());
      const bool due = recipe_.every_steps > 0
                           ? state_.step % static_cast<std::int64_t>(recipe_.every_steps) == 0
                           : at_s - last_validation_s > recipe_.every_s;
      const bool looks = due || fraction() >= 1;
      // Before a stop, too: who goes on from there does not come by this step again.
      if (looks) look(rate);
      if (looks || !go_on) MIEN_TRY(save());
      if (!go_on)
        return fail(ErrorCode::cancelled, fmt::format("stopped after {} steps", state_.step),
                    checkpoint_path_.string(), "go on with --resume");
      if (looks) last_validation_s = now_s();
      mark_s = now_s();  // Validation and checkpoint do not count as training.
    }
    return {};
  }

  [[nodiscard]] std::string status() const {
    std::string text =
        fmt::format("step {}, loss {:.4f}, {:.0f} windows/s", state_.step, shown_loss_, shown_speed_);
    if (last_score_)
      text += fmt::format(", validation loss {:.4f}, mse {:.5f}", last_score_->loss, last_score_->mse);
    return text;
  }

  /// The averaged weights as a model file has them: batch normalisation by the statistics that they have
  /// themselves, on training windows, and folded.
  [[nodiscard]] Parameters averaged() {
    if (!batch_norm_) return average_->average;
    constexpr std::size_t kWindows = 128;
    if (statistics_windows_.windows == 0)
      statistics_windows_ = task_.random_batch(kWindows, Random(recipe_.seed).fork("statistics"));
    return fold_batch_norm(recipe_.architecture, average_->average,
                           to_device(statistics_windows_, recipe_, *device_).condition);
  }

  /// Validates the averaged weights, keeps the best, and adds a row to the curve.
  void look(double rate) {
    const Parameters weights = averaged();
    last_score_ = validate_parts(recipe_, weights, validation_, *mixer_, *device_).whole;
    state_.curve +=
        fmt::format("{},{:.1f},{},{:.3g},{:.6f},{:.6f},{:.7f}\n", state_.step, state_.seconds,
                    state_.step * static_cast<std::int64_t>(recipe_.batch), rate,
                    state_.losses > 0 ? state_.loss_sum / static_cast<double>(state_.losses) : 0.0,
                    last_score_->loss, last_score_->mse);
    state_.loss_sum = 0;
    state_.losses = 0;
    if (last_score_->by(recipe_.score) < state_.best_score) {
      state_.best_score = last_score_->by(recipe_.score);
      state_.best_step = state_.step;
      state_.best = to_tensors(recipe_.architecture, weights);
    }
  }

  Result<void> save() {
    const model::Architecture& a = recipe_.architecture;
    state_.weights = to_tensors(a, weights_);
    state_.adam_mean = to_tensors(a, adam_->mean);
    state_.adam_square = to_tensors(a, adam_->square);
    state_.average = to_tensors(a, average_->average);
    state_.averagings = average_->count;
    if (state_.best.empty()) state_.best = to_tensors(a, averaged());
    MIEN_TRY(write_checkpoint(checkpoint_path_, state_));
    return write_file(curve_path_, state_.curve);
  }

  Result<TrainReport> finish() {
    MIEN_TRY_ASSIGN(const std::string assessed,
                    task_.assess(state_.best, [&](double part, std::string_view what) {
                      return progress_(1 - kAssessShare * (1 - part), what);
                    }));
    const PartScores scores =
        validate_parts(recipe_, from_tensors(state_.best, *device_), validation_, *mixer_, *device_);
    Json whole = results(scores.whole);
    if (validation_.size() > 1)
      for (std::size_t i = 0; i < validation_.size(); ++i)
        whole["validation"]["parts"][validation_[i].name] = {{"share", validation_[i].share},
                                                             {"windows", validation_[i].windows.windows},
                                                             {"loss", scores.parts[i].loss},
                                                             {"mse", scores.parts[i].mse}};
    whole.merge_patch(Json::parse(assessed));

    TrainReport report{.model = options_.out, .replaced = true, .results = whole.dump()};
    MIEN_TRY_ASSIGN(const std::optional<double> standing, standing_score());
    if (standing && *standing <= state_.best_score) {
      report.replaced = false;
      report.model.replace_extension(".worse.safetensors");
    }
    // A run that was killed behind its last checkpoint has not written it.
    MIEN_TRY(write_file(curve_path_, state_.curve));
    MIEN_TRY(task_.write(report.model, report.results));
    std::error_code code;
    fs::remove(checkpoint_path_, code);
    progress_(1, report.replaced ? "trained" : "trained, but the model that stands here is better and stays");
    return report;
  }

  [[nodiscard]] Json results(const ValidationScore& score) const {
    Json out = {{"validation",
                 {{"hash", validation_hash_},
                  {"score", state_.best_score},
                  {"loss", score.loss},
                  {"mse", score.mse},
                  {"frames", task_.validation_data().frames}}},
                {"training",
                 {{"steps", state_.step},
                  {"best_step", state_.best_step},
                  {"windows", state_.step * static_cast<std::int64_t>(recipe_.batch)},
                  {"frames", task_.training_data().frames},
                  {"seconds", std::round(state_.seconds)},
                  {"device", options_.device},
                  {"parameters", model::parameter_count(recipe_.architecture)}}}};
    if (!recipe_.recorded.empty()) out["training"]["recorded"] = recipe_.recorded;
    return out;
  }

  Task& task_;
  std::vector<model::Tensor> begin_with_;  // Empty: weights drawn anew.
  const Recipe& recipe_;
  const TrainOptions& options_;
  const Progress& progress_;
  fs::path checkpoint_path_, curve_path_;
  std::optional<torch::Device> device_;
  std::optional<NoiseMixer> mixer_;
  std::vector<ValidationPart> validation_;
  Batch statistics_windows_;  ///< Those that batch normalisation is folded by; drawn when first asked for.
  bool batch_norm_ = false;
  std::string validation_hash_, run_;
  Parameters weights_;
  std::optional<Adam> adam_;
  std::optional<MovingAverage> average_;
  Checkpoint state_;
  std::optional<ValidationScore> last_score_;
  double shown_loss_ = 0, shown_speed_ = 0;
};

}  // namespace

Result<TrainReport> train(Task& task, const TrainOptions& options, const Progress& progress) {
  try {
    return Training(task, options, progress).run();
  } catch (const c10::Error& error) {
    return fail(ErrorCode::internal, error.what_without_backtrace(), "libtorch");
  }
}

Result<double> measure_speed(const Recipe& given, std::size_t sensors, std::size_t steps,
                             const std::string& device_name, int threads) {
  MIEN_TRY_ASSIGN(const torch::Device device, find_device(device_name));
  use_threads(threads);
  Recipe recipe = given;
  recipe.architecture.condition = (recipe.presence_flags ? 9 : 7) * sensors;
  const model::Architecture& a = recipe.architecture;
  Random random(1);
  Batch batch{.windows = recipe.batch,
              .condition = {},
              .clean = {},
              .level = {},
              .held = std::vector<std::int64_t>(recipe.batch)};
  for (std::size_t i = 0; i < recipe.batch * a.window * a.condition; ++i)
    batch.condition.push_back(static_cast<float>(random.normal()));
  for (std::size_t i = 0; i < recipe.batch * a.window * a.outputs; ++i)
    batch.clean.push_back(static_cast<float>(random.uniform(-1, 1)));
  for (std::size_t i = 0; i < recipe.batch; ++i)
    batch.level.push_back(static_cast<std::int64_t>(random.below(recipe.schedule.levels)));
  Parameters weights = fresh_parameters(a, 1, recipe.near_first, device);
  Adam adam(weights);
  MovingAverage average(weights);
  const NoiseMixer mixer(recipe.schedule, device);
  std::vector<double> seconds;
  for (std::size_t i = 0; i <= steps; ++i) {
    const double start_s = now_s();
    take_step(recipe, device, mixer, batch, false, static_cast<std::int64_t>(i), recipe.learning_rate,
              weights, adam, average);
    if (i > 0) seconds.push_back(now_s() - start_s);  // The first one also sets libtorch up.
  }
  std::sort(seconds.begin(), seconds.end());
  return static_cast<double>(recipe.batch) / seconds[seconds.size() / 2];
}

}  // namespace mien::train
