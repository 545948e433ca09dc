#include "mien/train/tasks.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "mien/core/logistic.h"
#include "mien/core/sha256.h"
#include "mien/core/time.h"
#include "mien/headset/answer.h"
#include "mien/headset/headset_model.h"
#include "mien/headset/mirrored_eye.h"
#include "mien/headset/moment_features.h"
#include "mien/headset/views_file.h"
#include "mien/model/causal_network.h"
#include "mien/model/views_network.h"
#include "mien/sensor/rig.h"
#include "mien/solve/reliability.h"
#include "mien/synthetic/headset/headset_dataset.h"
#include "mien/synthetic/logistic_fit.h"
#include "mien/train/film_answers.h"
#include "mien/train/shown_donning.h"
#include "mien/virtual/performers.h"

namespace mien::train {
namespace {

using headset::kAnswerOutputs;
using model::kViews;

/// Ways in which each donning of training is shown: as it is and mirrored, and both once more as other
/// mountings and cameras show it. Raising: other headsets work better, for more minutes and memory.
constexpr std::size_t kWays = 4;

// Of a window: that all cameras are slow; that frames are lost, up to which share, in bursts up to how long.
// Of each view: that it is slow, missing, away for a while.
constexpr double kAllSlow = 0.15, kLossy = 0.3, kMostLost = 0.3;
constexpr std::uint64_t kLongestBurst = 10;
constexpr double kSlow = 0.05, kMissing = 0.04, kAway = 0.06, kMouthAway = 0.03;
/// How much later than usual a view may come, shares of a tick.
constexpr double kLatest = 0.6;

/// A validation frame of what is seen counts as so many where judgements become probabilities: half of the
/// donnings are hidden for a while, so that much is learnt of it, but hardly a seventh of a session's.
constexpr double kSeenCounts = 4;

/// A donning, and what was found in it.
struct DonningSequence {
  std::size_t film = 0;  ///< Whose it is.
  std::size_t frames = 0, rest_end = 0;
  double rate_hz = 0;
  std::vector<float> features;                ///< frames x kViews x features.
  headset::RestFeatures rest, mirrored_rest;  ///< The second of eyes that are shown mirrored.
  std::vector<float> wanted;                  ///< frames x kAnswerOutputs; NaN: nobody can know it.
  /// Of each frame, whether upper and lower face can be seen.
  std::vector<std::array<bool, 2>> visible;

  /// Of kFrameRateHz.
  [[nodiscard]] std::size_t ticks() const {
    return static_cast<std::size_t>(static_cast<double>(frames - 1) * kFrameRateHz / rate_hz) + 1;
  }
  /// What is wanted at a time between two frames.
  void wanted_at(double frame, std::span<float> out) const {
    const auto first = static_cast<std::size_t>(frame);
    const std::size_t second = std::min(first + 1, frames - 1);
    const auto part = static_cast<float>(frame - static_cast<double>(first));
    for (std::size_t i = 0; i < kAnswerOutputs; ++i)
      out[i] = std::lerp(wanted[first * kAnswerOutputs + i], wanted[second * kAnswerOutputs + i], part);
  }
  /// Whether what a judgement is about can be seen.
  [[nodiscard]] bool is_visible(double frame, std::size_t judgement) const {
    return visible[static_cast<std::size_t>(std::round(frame))][headset::half_of_face(judgement)];
  }
};

TaskData data_of(const std::vector<DonningSequence>& sequences) {
  Sha256 hash;
  std::size_t frames = 0;
  for (const DonningSequence& s : sequences) {
    hash.add_value(s.rate_hz);
    hash.add(std::as_bytes(std::span(s.features)));
    hash.add(std::as_bytes(std::span(s.wanted)));
    hash.add(std::as_bytes(std::span(s.visible)));
    frames += s.frames;
  }
  return {.hash = hash.hex(), .frames = frames};
}

/// What arrives of a view in a window: which of the film's frames, and how much later than the first could.
struct Delivery {
  std::vector<bool> lost;  // Of each frame of the sequence.
  double late_ticks = 0;
  bool missing = false;
};

/// What is found in the eyes at rest, as they are or mirrored.
std::vector<std::vector<float>> eyes_at_rest(const std::vector<DonningSequence>& sequences, bool mirrored,
                                             std::size_t features) {
  std::vector<std::vector<float>> eyes;
  for (const DonningSequence& s : sequences)
    for (std::size_t eye = 0; eye < 2; ++eye) {
      const headset::RestFeatures& rest = mirrored ? s.mirrored_rest : s.rest;
      if (!rest.present[eye]) continue;
      const auto of = std::span(rest.features).subspan(eye * features, features);
      eyes.emplace_back(of.begin(), of.end());
    }
  return eyes;
}

/// What a network of pictures finds, frame by frame, to the face.
class MemoryTask final : public Task {
 public:
  MemoryTask(Recipe recipe, headset::ViewsFile views, model::ViewsNetwork network,
             std::vector<DonningSequence> training, std::vector<DonningSequence> validation)
      : Task(std::move(recipe), data_of(training), data_of(validation)),
        views_(std::move(views)),
        network_(std::move(network)),
        training_(std::move(training)),
        validation_(std::move(validation)) {}

  /// Of cameras that are slow, late or away, and of frames that are lost; one window in six without a face at
  /// rest.
  [[nodiscard]] Batch random_batch(std::size_t count, Random random) const override {
    Batch batch;
    model::ViewsNetwork::Workspace memory(network_);
    while (batch.windows < count) {
      const DonningSequence& s = training_[random.below(training_.size())];
      append(s, random.below(s.ticks() - recipe_.architecture.window + 1), &random, memory, batch);
    }
    return batch;
  }

  /// With all of them.
  [[nodiscard]] Batch validation_batch(Random) const override {
    Batch batch;
    model::ViewsNetwork::Workspace memory(network_);
    const std::size_t count = std::min(recipe_.windows, validation_.size());
    for (std::size_t i = 0; i < count; ++i)
      append(validation_[i * validation_.size() / count], 0, nullptr, memory, batch);
    return batch;
  }

  [[nodiscard]] Result<std::string> results_of(const std::filesystem::path& model) const override {
    MIEN_TRY_ASSIGN(const headset::ViewsFile standing, headset::read_views_file(model));
    return standing.memory ? standing.memory->results : std::string();
  }

  [[nodiscard]] Result<std::vector<model::Tensor>> begin_with(const std::filesystem::path& model) override {
    MIEN_TRY_ASSIGN(headset::ViewsFile standing, headset::read_views_file(model));
    if (!standing.memory ||
        model::network_tensors(standing.memory->architecture) != model::network_tensors(recipe_.architecture))
      return fail(ErrorCode::mismatch, "it has no memory of this size", model.string(),
                  "start from a model of the recipe's own architecture");
    return std::move(standing.memory->network);
  }

  /// "headset": over validation, frame by frame after the rest: squared error of the weights beside the mean
  /// answer's and that of the network of pictures alone, the gaze's median error and its 90th percentile, how
  /// well closed lids are told, how restless the answer is (third differences over the truth's), and of the
  /// judgements calibration error and area under the ROC of each half of the wearers with what was fitted on
  /// the other (the model's own are fitted on all); and how well eyes that are shown mirrored are told.
  [[nodiscard]] Result<std::string> assess(std::span<const model::Tensor> network,
                                           const Progress& progress) override {
    headset::ViewsMemory& made = views_.memory.emplace();
    made.architecture = recipe_.architecture;
    made.network.assign(network.begin(), network.end());
    made.recipe = recipe_.text;
    MIEN_TRY_ASSIGN(const model::CausalNetwork runs,
                    model::CausalNetwork::create(recipe_.architecture, made.network));
    model::CausalNetwork::State state(runs);
    headset::MomentFeatures moment;
    moment.features.resize(kViews * views_.architecture.features);
    std::vector<float> condition(recipe_.architecture.condition);
    model::ViewsNetwork::Workspace memory(network_);
    std::array<float, headset::kMemoryOutputs> outputs{};
    std::array<float, kAnswerOutputs> wanted{};
    struct Judged {
      std::size_t half = 0;  // Every second wearer.
      std::size_t judgement = 0;
      float logit = 0;
      bool hit = false;
      double counts = 1;
    };
    std::vector<Judged> judged;
    double squares = 0, mean_squares = 0, moment_squares = 0, weights = 0, rough = 0, true_rough = 0;
    EyeScore eye_score;
    for (std::size_t n = 0; n < validation_.size(); ++n) {
      const DonningSequence& s = validation_[n];
      if (!progress(static_cast<double>(n) / static_cast<double>(validation_.size()), "measuring"))
        return fail(ErrorCode::cancelled, "stopped while measuring the model");
      state.reset();
      std::vector<std::array<float, face::kShapeCount>> answered, truth;
      for (std::size_t tick = 0; tick < s.ticks(); ++tick) {
        const double frame = static_cast<double>(tick) * s.rate_hz / kFrameRateHz;
        moment_at(s, frame, {}, moment);
        headset::read_moment(network_, moment, s.rest, memory, condition);
        runs.step(condition, state, outputs);
        headset::add_moment_answer(condition, outputs);
        if (frame < static_cast<double>(s.rest_end)) continue;
        s.wanted_at(frame, wanted);
        const std::span<const float> moments_answer = std::span(condition).last(kAnswerOutputs);
        auto& answer = answered.emplace_back();
        auto& real = truth.emplace_back();
        for (std::size_t k = 0; k < face::kShapeCount; ++k) {
          // Half the distance in [-1, 1] is the distance of weights.
          answer[k] = 0.5F * (std::clamp(outputs[k], -1.0F, 1.0F) + 1);
          real[k] = 0.5F * (wanted[k] + 1);
          const double error = double{answer[k] - real[k]};
          const double of_mean = 0.5 * double{views_.mean_answer[k] - wanted[k]};
          squares += error * error;
          mean_squares += of_mean * of_mean;
          const float by_itself = std::clamp(moments_answer[k], -1.0F, 1.0F);
          moment_squares += 0.25 * double{by_itself - wanted[k]} * double{by_itself - wanted[k]};
          ++weights;
        }
        const headset::Answer seen = headset::decode_answer(std::span(outputs).first<kAnswerOutputs>());
        const headset::Answer is = headset::decode_answer(wanted);
        for (std::size_t e = 0; e < 2; ++e) {
          if (!std::isnan(wanted[headset::kGazeOutput + 2 * e]))
            eye_score.add_gaze(seen.gaze_rad, is.gaze_rad, e);
          eye_score.add_openness(seen.openness[e], is.openness[e]);
        }
        for (std::size_t j = 0; j < headset::kJudgements; ++j) {
          double sum = 0, count = 0;
          for (const std::size_t i : headset::judged_outputs()[j]) {
            if (std::isnan(wanted[i])) continue;
            sum += std::abs(std::clamp(double{outputs[i]}, -1.0, 1.0) - double{wanted[i]});
            ++count;
          }
          const bool visible = s.is_visible(frame, j);
          judged.push_back(
              {.half = s.film % 2,
               .judgement = j,
               .logit = outputs[kAnswerOutputs + j],
               .hit = visible && count > 0 && sum <= count * double{headset::right_output_error(j)},
               .counts = visible ? kSeenCounts : 1});
        }
      }
      for (std::size_t f = 3; f < answered.size(); ++f)
        for (std::size_t k = 0; k < face::kShapeCount; ++k) {
          const auto third = [&](const auto& of) {
            return std::abs(double{of[f][k] - 3 * of[f - 1][k] + 3 * of[f - 2][k] - of[f - 3][k]});
          };
          rough += third(answered);
          true_rough += third(truth);
        }
    }
    // Of wearers without a rest nothing is known.
    const std::size_t features = views_.architecture.features;
    if (auto fitted = headset::fit_mirrored_eye(eyes_at_rest(training_, false, features),
                                                eyes_at_rest(training_, true, features)))
      made.mirrored_eye = *std::move(fitted);
    solve::RocArea mirrored;
    std::array<double, 2> eyes{}, said{};  // Of eyes as they are and mirrored; of those that are said to be.
    for (const bool is : {false, true})
      for (const std::vector<float>& eye : eyes_at_rest(validation_, is, features)) {
        const float log_odds = made.mirrored_eye.logit(eye);
        mirrored.add(logistic(log_odds), is);
        ++eyes[is ? 1 : 0];
        said[is ? 1 : 0] += log_odds > headset::kSurelyMirrored ? 1 : 0;
      }
    // The model's by all wearers; each half is judged by what the other half alone would have made.
    std::array<std::array<synthetic::LogisticFit, headset::kJudgements>, 2> halves;
    for (const Judged& one : judged) halves[one.half][one.judgement].add(one.logit, one.hit, one.counts);
    // Where all wearers are of one half nothing judges them.
    const bool apart = halves[0][0].frames() > 0 && halves[1][0].frames() > 0;
    std::array<std::array<model::LogisticMap, headset::kJudgements>, 2> others;
    for (std::size_t j = 0; j < headset::kJudgements; ++j) {
      for (std::size_t half = 0; half < 2; ++half) others[half][j] = halves[1 - half][j].solve();
      halves[0][j].add(halves[1][j]);
      made.judgements[j] = halves[0][j].solve();
    }
    std::array<solve::Reliability, headset::kJudgements> reliability;
    std::array<solve::RocArea, headset::kJudgements> roc;
    for (const Judged& one : judged) {
      const float p = others[one.half][one.judgement].at(one.logit);
      reliability[one.judgement].add(p, one.hit, one.counts);
      roc[one.judgement].add(p, one.hit);
    }
    nlohmann::json judgements = nlohmann::json::array();
    for (std::size_t j = 0; j < headset::kJudgements; ++j)
      judgements.push_back(
          {{"ece", apart ? nlohmann::json(reliability[j].expected_error()) : nlohmann::json()},
           {"auc", apart ? nlohmann::json(roc[j].area()) : nlohmann::json()}});
    return nlohmann::json{{"headset",
                           {{"mse", squares / std::max(1.0, weights)},
                            {"mean_pose_mse", mean_squares / std::max(1.0, weights)},
                            {"moment_mse", moment_squares / std::max(1.0, weights)},
                            {"gaze_median_deg", eye_score.gaze_deg(0.5)},
                            {"gaze_p90_deg", eye_score.gaze_deg(0.9)},
                            {"closed_f1", eye_score.closed_f1()},
                            {"jitter_ratio", rough / std::max(1e-9, true_rough)},
                            {"mirrored_eye",
                             {{"auc", mirrored.area()},
                              {"false_alarms", said[0] / std::max(1.0, eyes[0])},
                              {"found", said[1] / std::max(1.0, eyes[1])}}},
                            {"judgements", judgements}}}}
        .dump();
  }

  [[nodiscard]] Result<void> write(const std::filesystem::path& path,
                                   const std::string& results) const override {
    headset::ViewsFile whole = views_;
    whole.memory->results = results;
    return headset::write_views_file(path, whole);
  }

 private:
  void append(const DonningSequence& sequence, std::size_t first_tick, Random* random,
              model::ViewsNetwork::Workspace& memory, Batch& batch) const {
    const std::size_t window = recipe_.architecture.window, each = recipe_.architecture.condition;
    static const headset::RestFeatures kNothing;
    bool told = sequence.rest_end > 0;
    std::vector<Delivery> delivery;
    if (random != nullptr) {
      told = told && !random->chance(kNotTold);
      const bool slow = random->chance(kAllSlow), mouth_away = random->chance(kMouthAway);
      const double lost = random->chance(kLossy) ? random->uniform(0, kMostLost) : 0;
      const auto away_from = random->below(sequence.frames), away_for = random->below(sequence.frames);
      delivery.resize(kViews);
      for (std::size_t v = 0; v < kViews; ++v) {
        Delivery& of = delivery[v];
        of.late_ticks = random->uniform(0, kLatest);
        of.missing = random->chance(kMissing);
        of.lost.assign(sequence.frames, false);
        if (slow || random->chance(kSlow)) {
          const std::uint64_t every = 2 + random->below(3), phase = random->below(every);
          for (std::size_t i = 0; i < sequence.frames; ++i) of.lost[i] = i % every != phase;
        }
        const double bursts = lost / (0.5 * static_cast<double>(kLongestBurst + 1));
        for (std::size_t i = 0; lost > 0 && i < sequence.frames; ++i)
          if (random->chance(bursts))
            for (std::uint64_t n = 1 + random->below(kLongestBurst); n > 0 && i < sequence.frames; --n, ++i)
              of.lost[i] = true;
        if ((mouth_away && v >= 2) || random->chance(kAway))
          for (std::size_t i = away_from; i < std::min(sequence.frames, away_from + away_for); ++i)
            of.lost[i] = true;
      }
    }
    headset::MomentFeatures moment;
    moment.features.resize(kViews * views_.architecture.features);
    for (std::size_t tick = first_tick; tick < first_tick + window; ++tick) {
      const double frame = std::min(static_cast<double>(tick) * sequence.rate_hz / kFrameRateHz,
                                    static_cast<double>(sequence.frames - 1));
      moment_at(sequence, frame, delivery, moment);
      const std::size_t begin = batch.condition.size(), wanted = batch.clean.size();
      batch.condition.resize(begin + each);
      headset::read_moment(network_, moment, told ? sequence.rest : kNothing, memory,
                           std::span(batch.condition).subspan(begin));
      batch.clean.resize(wanted + headset::kMemoryOutputs);
      sequence.wanted_at(frame, std::span(batch.clean).subspan(wanted));
      for (std::size_t j = 0; j < headset::kJudgements; ++j)
        batch.clean[wanted + kAnswerOutputs + j] = sequence.is_visible(frame, j) ? 1 : 0;
    }
    batch.level.push_back(0);
    batch.held.push_back(0);
    ++batch.windows;
  }

  /// The moment at a tick, of views that are there as `delivery` says (empty: all are).
  void moment_at(const DonningSequence& sequence, double frame, std::span<const Delivery> delivery,
                 headset::MomentFeatures& moment) const {
    const std::size_t count = views_.architecture.features;
    const double ticks_per_frame = kFrameRateHz / sequence.rate_hz;
    for (std::size_t v = 0; v < kViews; ++v) {
      const auto begin = static_cast<std::ptrdiff_t>(v * count);
      const auto leave_out = [&] {
        moment.present[v] = false;
        std::ranges::copy(network_.missing(v), moment.features.begin() + begin);
      };
      const Delivery* const of = delivery.empty() ? nullptr : &delivery[v];
      if (!sequence.rest.present[v] || (of != nullptr && of->missing)) {
        leave_out();
        continue;
      }
      const double newest = frame - (of != nullptr ? of->late_ticks / ticks_per_frame : 0);
      auto at = static_cast<std::ptrdiff_t>(std::floor(newest + 1e-6));
      while (at >= 0 && of != nullptr && of->lost[static_cast<std::size_t>(at)]) --at;
      const double age_s = (frame - static_cast<double>(at)) / sequence.rate_hz;
      if (at < 0 || age_s > double{headset::kOldest_s}) {
        leave_out();
        continue;
      }
      moment.present[v] = true;
      moment.age_s[v] = static_cast<float>(age_s);
      std::copy_n(sequence.features.begin() + at * static_cast<std::ptrdiff_t>(kViews * count) + begin, count,
                  moment.features.begin() + begin);
    }
  }

  headset::ViewsFile views_;
  model::ViewsNetwork network_;  // That of views_.
  std::vector<DonningSequence> training_, validation_;
};

}  // namespace

Result<std::unique_ptr<Task>> make_memory_task(Recipe recipe, const synthetic::HeadsetFilms& films,
                                               headset::ViewsFile views, const sensor::Rig& rig,
                                               const Progress& progress) {
  if (recipe.architecture.kind != model::NetworkKind::causal)
    return fail(ErrorCode::bad_usage, "a memory is a causal network", "[network] architecture",
                "write architecture = \"causal\"");
  const std::size_t count = views.architecture.features;
  recipe.architecture.condition = headset::moment_condition(count);
  recipe.architecture.outputs = headset::kMemoryOutputs;
  recipe.gaze_outputs = gaze_outputs();
  Addition& addition = recipe.addition.emplace();
  addition.to = static_cast<std::int64_t>(headset::moment_answer(count));
  for (std::size_t output = 0; output < kAnswerOutputs; ++output)
    addition.doubted_by.push_back(static_cast<std::int64_t>(headset::judgement_of(output)));
  MIEN_TRY(model::check(recipe.architecture));
  for (std::size_t j = 0; j < headset::kJudgements; ++j) {
    Recipe::Judgement& judgement = recipe.judgements.emplace_back();
    for (const std::size_t output : headset::judged_outputs()[j])
      judgement.outputs.push_back(static_cast<std::int64_t>(output));
    judgement.most_error = double{headset::right_output_error(j)};
  }
  for (const std::size_t output : {face::shape("eyeBlink_L"), face::shape("eyeBlink_R"),
                                   headset::kOpennessOutput, headset::kOpennessOutput + 1})
    recipe.quick_outputs.push_back(static_cast<std::int64_t>(output));
  MIEN_TRY_ASSIGN(const FilmPlaces places, film_places(films, rig, views.architecture.side));
  FilmPlaces turned_places = places;
  for (std::size_t eye = 0; eye < 2; ++eye) turned_places[eye].view.mirror = !turned_places[eye].view.mirror;
  MIEN_TRY_ASSIGN(model::ViewsNetwork network,
                  model::ViewsNetwork::create(views.architecture, views.network, headset::kHeadsetPrecision));
  const Random root = Random(recipe.seed).fork("ways");
  const std::size_t all = films.train.size() + films.validation.size();
  std::vector<std::vector<DonningSequence>> found(all);
  MIEN_TRY(virt::for_each_performer(all, 0, progress, [&](std::size_t index) -> Result<void> {
    const bool trains = index < films.train.size();
    const std::size_t number = trains ? index : index - films.train.size();
    const synthetic::HeadsetFilm& film = trains ? films.train[number] : films.validation[number];
    model::ViewsNetwork::Workspace memory(network);
    for (std::size_t way = 0; way < (trains ? kWays : 1); ++way)
      for (const synthetic::HeadsetFilm::Donning& donning : film.donnings()) {
        if (donning.end - donning.begin < 2) continue;
        Random random = root.fork("film", index).fork("way", way).fork("donning", donning.begin);
        const Way shown =
            draw_way(way, donning.rest_end - donning.begin, donning.end - donning.begin, random);
        DonningSequence s;
        s.film = number;
        s.frames = donning.end - donning.begin;
        s.rest_end = donning.rest_end - donning.begin;
        s.rate_hz = 1 / double{film.truth(donning.begin + 1).time_s};
        Found of = find_in_donning(film, donning, places, shown, network, memory, random);
        s.features = std::move(of.features);
        s.wanted = std::move(of.wanted);
        s.visible = std::move(of.visible);
        s.rest = rest_of(std::span(s.features).first(s.rest_end * kViews * count), s.rest_end, places, shown);
        Random once_more = random.fork("mirrored eyes");
        const Found turned = find_in_donning(film, {donning.begin, donning.rest_end, donning.rest_end},
                                             turned_places, shown, network, memory, once_more);
        s.mirrored_rest = rest_of(turned.features, s.rest_end, places, shown);
        found[index].push_back(std::move(s));
      }
    return {};
  }));
  std::vector<DonningSequence> training, validation;
  for (std::size_t index = 0; index < all; ++index)
    for (DonningSequence& s : found[index])
      if (s.ticks() >= recipe.architecture.window)
        (index < films.train.size() ? training : validation).push_back(std::move(s));
  if (training.empty() || validation.empty())
    return fail(ErrorCode::bad_usage, fmt::format("no donning lasts {} frames", recipe.architecture.window),
                "[network] window");
  return std::make_unique<MemoryTask>(std::move(recipe), std::move(views), std::move(network),
                                      std::move(training), std::move(validation));
}

}  // namespace mien::train
