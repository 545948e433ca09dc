#include "mien/train/tasks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "mien/core/sha256.h"
#include "mien/core/units.h"
#include "mien/speech/speech_network.h"
#include "mien/synthetic/confidence_fit.h"
#include "mien/synthetic/speech/closure_score.h"
#include "mien/synthetic/speech/speech_dataset.h"
#include "mien/train/mel_augmentation.h"

namespace mien::train {
namespace {

using speech::kConditionOfBlock;
using speech::kMelBands;
using synthetic::SpeechDataset;
using synthetic::SpeechSequence;

/// Share of the windows that are of no speech.
constexpr double kOthersShare = 1.0 / 6;

Result<void> check(const SpeechDataset& dataset) {
  const std::size_t shapes = synthetic::speech_shapes().size();
  for (const SpeechSequence& s : dataset.sequences) {
    if (s.mel.size() != s.blocks * kConditionOfBlock || s.mouth.size() != s.blocks * shapes ||
        s.closure.size() != s.blocks || s.voiced.size() != s.blocks)
      return fail(ErrorCode::mismatch, fmt::format("its arrays do not fit {} blocks", s.blocks),
                  "speech of " + s.voice);
    if (!all_finite(s.mel) || !all_finite(s.mouth))
      return fail(ErrorCode::out_of_range, "it holds a number that is not finite", "speech of " + s.voice);
  }
  return {};
}

TaskData data_of(const SpeechDataset& dataset) {
  Sha256 hash;
  std::size_t blocks = 0;
  hash.add_value(static_cast<std::uint64_t>(dataset.look_ahead));
  for (const std::string& name : synthetic::speech_shapes()) hash.add(std::as_bytes(std::span(name)));
  for (const SpeechSequence& s : dataset.sequences) {
    hash.add(std::as_bytes(std::span(s.voice)));
    hash.add_value(static_cast<std::uint64_t>(s.blocks));
    for (const auto* values : {&s.mel, &s.mouth, &s.closure, &s.voiced})
      hash.add(std::as_bytes(std::span(*values)));
    blocks += s.blocks;
  }
  return {.hash = hash.hex(), .frames = blocks};
}

/// Whether anybody speaks for a whole window.
bool speaks_for(const SpeechDataset& dataset, std::size_t window) {
  return std::ranges::any_of(dataset.sequences,
                             [window](const SpeechSequence& s) { return s.speech && s.blocks >= window; });
}

WindowPlaces places_in(const SpeechDataset& dataset, std::size_t window) {
  std::vector<std::size_t> blocks;
  for (const SpeechSequence& s : dataset.sequences) blocks.push_back(s.blocks);
  return {std::move(blocks), window};
}

/// Sound to the mouth, a step a block.
class SpeechTask final
    : public FileTask<speech::SpeechNetworkFile, speech::read_speech_network, speech::write_speech_network> {
 public:
  SpeechTask(Recipe recipe, SpeechDataset training, SpeechDataset validation)
      : FileTask(std::move(recipe), data_of(training), data_of(validation)),
        training_(std::move(training)),
        validation_(std::move(validation)) {
    for (std::size_t i = 0; i < training_.sequences.size(); ++i)
      if (training_.sequences[i].blocks >= recipe_.architecture.window)
        (training_.sequences[i].speech ? spoken_ : others_).push_back(i);
    model_.shapes = synthetic::speech_shapes();
    model_.look_ahead = training_.look_ahead;
    normalise_by(training_);
  }

  [[nodiscard]] Batch random_batch(std::size_t count, Random random) const override {
    const std::size_t window = recipe_.architecture.window;
    Batch batch;
    while (batch.windows < count) {
      const bool other = !others_.empty() && random.chance(kOthersShare);
      const auto& among = other ? others_ : spoken_;
      const SpeechSequence& sequence = training_.sequences[among[random.below(among.size())]];
      const std::size_t first = random.below(sequence.blocks - window + 1);
      std::vector<float> frames = frames_of(sequence, first);
      // Other people's talk beside noise is talk.
      const std::vector<float> about = other ? std::vector<float>() : draw_other(random);
      augment_mel(frames, about, random);
      append_window(sequence, first, frames, batch);
    }
    return batch;
  }

  /// Half of them through other rooms and microphones, with other sounds about.
  [[nodiscard]] Batch validation_batch(Random random) const override {
    Batch batch;
    for (const WindowPlaces::Place& place :
         places_in(validation_, recipe_.architecture.window).even(recipe_.windows)) {
      const SpeechSequence& sequence = validation_.sequences[place.sequence];
      std::vector<float> frames = frames_of(sequence, place.first);
      if (batch.windows % 2 == 1)
        augment_mel(frames, sequence.speech ? draw_other(random) : std::vector<float>(), random);
      append_window(sequence, place.first, frames, batch);
    }
    return batch;
  }

  [[nodiscard]] Result<std::vector<model::Tensor>> begin_with(const std::filesystem::path& model) override {
    MIEN_TRY_ASSIGN(speech::SpeechNetworkFile standing, speech::read_speech_network(model));
    if (model::network_tensors(standing.architecture) != model::network_tensors(recipe_.architecture) ||
        standing.shapes != model_.shapes || standing.look_ahead != model_.look_ahead)
      return fail(ErrorCode::mismatch, "it is a network of another size, or tells other shapes",
                  model.string(), "start from a model of the recipe's own architecture");
    model_.mean = standing.mean;
    model_.scale = standing.scale;
    return std::move(standing.network);
  }

  /// "speech": over validation, block by block: recall and false share of closures, the correlation of the
  /// jaw while something is said, and how often a voice is told in other sounds.
  [[nodiscard]] Result<std::string> assess(std::span<const model::Tensor> network,
                                           const Progress& progress) override {
    constexpr float kClosed = 0.5F, kVoice = 0.5F;
    model_.network.assign(network.begin(), network.end());
    MIEN_TRY_ASSIGN(speech::SpeechNetwork runs, speech::SpeechNetwork::create(model_));
    const std::size_t shapes = model_.shapes.size();
    const double block_s = to_seconds(speech::kBlockDuration);
    const std::size_t jaw = face::shape("jawOpen");
    const auto jaw_at =
        static_cast<std::size_t>(std::ranges::find(model_.shapes, "jawOpen") - model_.shapes.begin());
    synthetic::ClosureScore closures;
    synthetic::Correlation jaws;
    double other_blocks = 0, talking = 0;
    for (std::size_t i = 0; i < validation_.sequences.size(); ++i) {
      if (!progress(static_cast<double>(i) / static_cast<double>(validation_.sequences.size()), "measuring"))
        return fail(ErrorCode::cancelled, "stopped while measuring the model");
      const SpeechSequence& s = validation_.sequences[i];
      runs.reset();
      std::vector<float> closed;
      speech::HeardMouth mouth;
      for (std::size_t b = 0; b < s.blocks; ++b) {
        std::array<speech::MelFrame, speech::kFramesPerBlock> frames{};
        for (std::size_t f = 0; f < speech::kFramesPerBlock; ++f)
          std::copy_n(s.mel.begin() + static_cast<std::ptrdiff_t>(b * kConditionOfBlock + f * kMelBands),
                      kMelBands, frames[f].begin());
        runs.step(frames, mouth);
        closed.push_back(mouth.closure);
        if (s.voiced[b] > 0) jaws.add(double{s.mouth[b * shapes + jaw_at]}, double{mouth.weights[jaw]});
        if (!s.speech) {
          ++other_blocks;
          talking += mouth.voice >= kVoice ? 1 : 0;
        }
      }
      if (s.speech)
        closures.add(synthetic::score_closures(synthetic::stretches_above(s.closure, kClosed, 0, block_s),
                                               synthetic::stretches_above(closed, kClosed, 0, block_s)));
    }
    return nlohmann::json{{"speech",
                           {{"closure_recall", closures.recall()},
                            {"closure_false", closures.false_share()},
                            {"closures", closures.truths},
                            {"jaw_correlation", jaws.r()},
                            {"voice_in_other_sounds", other_blocks == 0 ? 0 : talking / other_blocks}}}}
        .dump();
  }

 private:
  void normalise_by(const SpeechDataset& dataset) {
    std::array<double, kMelBands> sum{}, squares{};
    double frames = 0;
    for (const SpeechSequence& s : dataset.sequences) {
      if (!s.speech) continue;
      for (std::size_t i = 0; i < s.mel.size(); ++i) {
        sum[i % kMelBands] += double{s.mel[i]};
        squares[i % kMelBands] += double{s.mel[i]} * double{s.mel[i]};
      }
      frames += static_cast<double>(s.mel.size()) / kMelBands;
    }
    frames = std::max(frames, 1.0);
    for (std::size_t b = 0; b < kMelBands; ++b) {
      const double mean = sum[b] / frames;
      model_.mean[b] = static_cast<float>(mean);
      model_.scale[b] = static_cast<float>(std::sqrt(std::max(squares[b] / frames - mean * mean, 0.01)));
    }
  }

  /// What is about in a window: of the training's sounds, or of what one of its voices says.
  [[nodiscard]] std::vector<float> draw_other(Random& random) const {
    constexpr double kSpeech = 0.15;  // Others talk.
    const auto& among = others_.empty() || random.chance(kSpeech) ? spoken_ : others_;
    const SpeechSequence& other = training_.sequences[among[random.below(among.size())]];
    return frames_of(other, random.below(other.blocks - recipe_.architecture.window + 1));
  }

  void append_window(const SpeechSequence& sequence, std::size_t first, std::span<float> frames,
                     Batch& batch) const {
    const std::size_t shapes = model_.shapes.size();
    for (std::size_t i = 0; i < frames.size(); ++i)
      batch.condition.push_back((frames[i] - model_.mean[i % kMelBands]) / model_.scale[i % kMelBands]);
    for (std::size_t b = first; b < first + recipe_.architecture.window; ++b) {
      for (std::size_t s = 0; s < shapes; ++s) batch.clean.push_back(2 * sequence.mouth[b * shapes + s] - 1);
      batch.clean.push_back(2 * sequence.closure[b] - 1);
      batch.clean.push_back(2 * sequence.voiced[b] - 1);
    }
    batch.level.push_back(0);
    batch.held.push_back(0);
    ++batch.windows;
  }

  [[nodiscard]] std::vector<float> frames_of(const SpeechSequence& sequence, std::size_t first) const {
    const auto begin = sequence.mel.begin() + static_cast<std::ptrdiff_t>(first * kConditionOfBlock);
    return {begin, begin + static_cast<std::ptrdiff_t>(recipe_.architecture.window * kConditionOfBlock)};
  }

  SpeechDataset training_;
  SpeechDataset validation_;
  std::vector<std::size_t> spoken_, others_;  // Of the training's sequences.
};

}  // namespace

Result<std::unique_ptr<Task>> make_speech_task(Recipe recipe, SpeechDataset training,
                                               SpeechDataset validation) {
  if (recipe.architecture.kind != model::NetworkKind::causal)
    return fail(ErrorCode::bad_usage, "speech's network is a causal one", "[network] architecture",
                "write architecture = \"causal\"");
  MIEN_TRY(check(training));
  MIEN_TRY(check(validation));
  std::set<std::string> trained_on;
  for (const SpeechSequence& s : training.sequences)
    if (s.speech) trained_on.insert(s.voice);
  for (const SpeechSequence& s : validation.sequences)
    if (trained_on.contains(s.voice))
      return fail(ErrorCode::mismatch, fmt::format("{} speaks in training and in validation", s.voice),
                  "data set");
  if (training.look_ahead != validation.look_ahead)
    return fail(ErrorCode::mismatch, "training and validation look ahead by different blocks", "data set");
  recipe.architecture.condition = kConditionOfBlock;
  recipe.architecture.outputs = synthetic::speech_shapes().size() + 2;
  MIEN_TRY(model::check(recipe.architecture));
  for (const SpeechDataset* data : {&training, &validation})
    if (!speaks_for(*data, recipe.architecture.window))
      return fail(ErrorCode::bad_usage, fmt::format("training or validation has no passage of {} blocks",
                                                    recipe.architecture.window));
  return std::make_unique<SpeechTask>(std::move(recipe), std::move(training), std::move(validation));
}

}  // namespace mien::train
