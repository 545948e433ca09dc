#include "mien/train/diffusion.h"

#include <algorithm>
#include <cmath>

namespace mien::train {
namespace {

/// Windows that go through the network at once while validating.
constexpr std::int64_t kValidationBatch = 64;
constexpr std::uint64_t kValidationSeed = 20240601;
/// Of a network's judgement of itself beside its answers: it should learn to judge, not to answer worse.
constexpr double kJudgementWeight = 0.02;
/// Added to a squared distance under its root, so that its slope is finite where nothing is wrong.
constexpr double kLeastSquare = 1e-6;

torch::Tensor error_of(LossKind kind, const torch::Tensor& difference) {
  if (kind == LossKind::l1) return difference.abs();
  if (kind == LossKind::l2) return difference.square();
  return (difference.view({difference.size(0), difference.size(1), -1, 3}).square().sum(-1) + kLeastSquare)
      .sqrt();
}

}  // namespace

DeviceBatch to_device(const Batch& batch, const Recipe& recipe, const torch::Device& device) {
  const auto windows = static_cast<std::int64_t>(batch.windows);
  const auto frames = static_cast<std::int64_t>(recipe.architecture.window);
  return {.condition = torch::tensor(batch.condition).view({windows, frames, -1}).to(device),
          .clean = torch::tensor(batch.clean).view({windows, frames, -1}).to(device),
          .level = torch::tensor(batch.level).to(device),
          .held = torch::tensor(batch.held).to(device)};
}

NoiseMixer::NoiseMixer(const model::ScheduleSettings& schedule, const torch::Device& device) {
  std::vector<float> keep, add;
  for (const double signal : model::cosine_signal(schedule)) {
    keep.push_back(static_cast<float>(std::sqrt(signal)));
    add.push_back(static_cast<float>(std::sqrt(1 - signal)));
  }
  keep_ = torch::tensor(keep).to(device);
  add_ = torch::tensor(add).to(device);
}

torch::Tensor NoiseMixer::mix(const DeviceBatch& batch, const torch::Tensor& noise) const {
  const torch::Tensor mixed = keep_.index_select(0, batch.level).view({-1, 1, 1}) * batch.clean +
                              add_.index_select(0, batch.level).view({-1, 1, 1}) * noise;
  const torch::Tensor frame = torch::arange(batch.clean.size(1), batch.held.options()).view({1, -1, 1});
  return torch::where(frame < batch.held.view({-1, 1, 1}), batch.clean, mixed);
}

torch::Tensor answer_at_once(const Recipe& recipe, const Parameters& parameters,
                             const torch::Tensor& condition, const Pass& pass) {
  const torch::Tensor outputs = predict_at_once(recipe.architecture, parameters, condition, pass);
  if (!recipe.addition) return outputs;
  const auto judged = static_cast<std::int64_t>(recipe.judgements.size()), answers = outputs.size(2) - judged;
  const torch::Tensor judgements = outputs.narrow(2, answers, judged);
  // The judgements learn whether the answer is right, not to make it so.
  const torch::Tensor wrong =
      torch::sigmoid(judgements.detach().neg())
          .index_select(2, torch::tensor(recipe.addition->doubted_by).to(outputs.device()));
  return torch::cat(
      {condition.narrow(2, recipe.addition->to, answers) + wrong * outputs.narrow(2, 0, answers), judgements},
      2);
}

torch::Tensor difference_of(const torch::Tensor& predicted, const torch::Tensor& clean) {
  return torch::where(clean.isnan(), torch::zeros_like(clean), predicted - clean);
}

namespace {

/// Those outputs, or what is asked of them, that are no judgements.
torch::Tensor answers_of(const Recipe& recipe, const torch::Tensor& outputs) {
  return outputs.narrow(2, 0, outputs.size(2) - static_cast<std::int64_t>(recipe.judgements.size()));
}
/// The others.
torch::Tensor judgements_of(const Recipe& recipe, const torch::Tensor& outputs) {
  const auto count = static_cast<std::int64_t>(recipe.judgements.size());
  return outputs.narrow(2, outputs.size(2) - count, count);
}

torch::Tensor judgement_loss(const Recipe& recipe, const torch::Tensor& predicted,
                             const torch::Tensor& asked) {
  const torch::Tensor clean = answers_of(recipe, asked);
  const torch::Tensor error = difference_of(answers_of(recipe, predicted).detach().clamp(-1, 1), clean).abs();
  const torch::Tensor known = clean.isnan().logical_not().to(torch::kFloat);
  std::vector<torch::Tensor> right;
  for (const Recipe::Judgement& judgement : recipe.judgements) {
    const torch::Tensor which = torch::tensor(judgement.outputs).to(clean.device());
    const torch::Tensor count = known.index_select(2, which).sum(2);
    right.push_back((count > 0)
                        .logical_and(error.index_select(2, which).sum(2) <= count * judgement.most_error)
                        .to(torch::kFloat));
  }
  return torch::binary_cross_entropy_with_logits(judgements_of(recipe, predicted),
                                                 torch::stack(right, 2) * judgements_of(recipe, asked));
}

torch::Tensor answer_loss(const Recipe& recipe, const torch::Tensor& predicted, const DeviceBatch& batch) {
  const torch::Tensor difference =
      difference_of(answers_of(recipe, predicted), answers_of(recipe, batch.clean));
  torch::Tensor error = error_of(recipe.loss, difference);
  if (recipe.gaze_weight != 1 && !recipe.gaze_outputs.empty()) {
    const torch::Tensor weights = torch::ones({error.size(2)}, error.options());
    weights.index_fill_(0, torch::tensor(recipe.gaze_outputs).to(error.device()), recipe.gaze_weight);
    error = error * weights;
  }
  if (recipe.difference_weight > 0) {
    torch::Tensor change = difference.slice(1, 1) - difference.slice(1, 0, -1);
    if (!recipe.quick_outputs.empty())
      change = change.index_fill(2, torch::tensor(recipe.quick_outputs).to(change.device()), 0);
    return error.mean() + recipe.difference_weight * change.square().mean();
  }
  if (recipe.t_weight == 0) return error.mean();
  const torch::Tensor weight =
      ((batch.level.to(torch::kFloat) + 1) / static_cast<double>(recipe.schedule.levels))
          .pow(recipe.t_weight);
  return (error.mean(at::IntArrayRef{1, 2}) * weight / weight.mean()).mean();
}

}  // namespace

torch::Tensor loss_of(const Recipe& recipe, const torch::Tensor& predicted, const DeviceBatch& batch) {
  const torch::Tensor loss = answer_loss(recipe, predicted, batch);
  if (recipe.judgements.empty()) return loss;
  return loss + kJudgementWeight * judgement_loss(recipe, predicted, batch.clean);
}

ValidationScore validate(const Recipe& recipe, const Parameters& parameters, const Batch& windows,
                         const NoiseMixer& mixer, const torch::Device& device) {
  const at::NoGradGuard no_gradients;
  DeviceBatch all = to_device(windows, recipe, device);
  if (recipe.architecture.kind != model::NetworkKind::window) {
    const torch::Tensor predicted =
        answer_at_once(recipe, parameters, all.condition, {.dropout = 0, .bf16 = recipe.bf16});
    const torch::Tensor error =
        difference_of(answers_of(recipe, predicted).clamp(-1, 1), answers_of(recipe, all.clean));
    // Half the distance in [-1, 1] is the distance of weights.
    return {.loss = error.abs().mean().item<double>(), .mse = error.square().mean().item<double>() / 4};
  }
  // Noise from our own generator: a device's would differ from another's.
  Random random(kValidationSeed);
  std::vector<float> values(windows.clean.size());
  for (float& v : values) v = static_cast<float>(random.normal());
  const torch::Tensor noise = torch::tensor(values).view(all.clean.sizes()).to(device);

  const auto count = static_cast<std::int64_t>(windows.windows);
  const auto levels = static_cast<std::int64_t>(recipe.schedule.levels);
  const std::int64_t looked_at[] = {levels / 4, levels / 2, levels * 3 / 4, levels - 1};
  ValidationScore score;
  for (const std::int64_t level : looked_at)
    for (std::int64_t at = 0; at < count; at += kValidationBatch) {
      const std::int64_t end = std::min(count, at + kValidationBatch);
      DeviceBatch part = {.condition = all.condition.slice(0, at, end),
                          .clean = all.clean.slice(0, at, end),
                          .level = torch::full_like(all.level.slice(0, at, end), level),
                          .held = all.held.slice(0, at, end)};
      const torch::Tensor predicted =
          predict(recipe.architecture, parameters, mixer.mix(part, noise.slice(0, at, end)), part.condition,
                  part.level, {.dropout = 0, .bf16 = recipe.bf16});
      const double share = static_cast<double>(end - at) / static_cast<double>(count);
      score.loss += share * (predicted - part.clean).abs().mean().item<double>() / std::size(looked_at);
      // Half the distance in [-1, 1] is the distance of weights.
      if (level == levels - 1)
        score.mse += share * (predicted.clamp(-1, 1) - part.clean).square().mean().item<double>() / 4;
    }
  return score;
}

PartScores validate_parts(const Recipe& recipe, const Parameters& parameters,
                          std::span<const ValidationPart> parts, const NoiseMixer& mixer,
                          const torch::Device& device) {
  PartScores scores;
  for (const ValidationPart& part : parts) {
    const ValidationScore score = validate(recipe, parameters, part.windows, mixer, device);
    scores.whole.loss += part.share * score.loss;
    scores.whole.mse += part.share * score.mse;
    scores.parts.push_back(score);
  }
  return scores;
}

}  // namespace mien::train
