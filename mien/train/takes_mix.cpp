#include "mien/train/takes_mix.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <set>

#include "mien/core/time.h"

namespace mien::train {
namespace {

constexpr double kFramesAMinute = 60 * kFrameRateHz;

}  // namespace

Result<double> takes_share(const Recipe& recipe, bool takes_given, const std::string& where) {
  const double share = recipe.takes_share.value_or(takes_given ? kUsualTakesShare : 0);
  if (share > 0 && !takes_given)
    return fail(
        ErrorCode::bad_usage,
        fmt::format("the recipe draws a share of {} of its windows from takes, and none are given", share),
        where, "name their folder with --takes, or take [takes] out of the recipe");
  if (share == 0 && takes_given)
    return fail(ErrorCode::bad_usage, "the recipe draws no window from the takes that are given", where,
                "raise takes.share, or leave --takes away");
  return share;
}

Result<dataset::TrainingData> as_takes(dataset::TrainingData takes, std::size_t window) {
  for (dataset::Dataset* part : {&takes.train, &takes.validation}) {
    std::erase_if(part->sequences, [&](const dataset::Sequence& s) { return s.frames < window; });
    for (dataset::Sequence& s : part->sequences) s.from_take = true;
  }
  if (takes.train.sequences.empty())
    return fail(ErrorCode::bad_usage,
                fmt::format("no take to train on has {} frames in a row whose truth counts", window), "takes",
                "record longer ones, or name more people to train on in --splits");
  if (takes.validation.sequences.empty()) takes.validation.sensors = takes.train.sensors;
  return takes;
}

double minutes_of(const dataset::Dataset& dataset) {
  double frames = 0;
  for (const dataset::Sequence& s : dataset.sequences) frames += static_cast<double>(s.frames);
  return frames / kFramesAMinute;
}

TakesAmount takes_in(const dataset::Dataset& dataset) {
  TakesAmount amount;
  std::set<std::uint32_t> people;
  for (const dataset::Sequence& s : dataset.sequences) {
    if (!s.from_take) continue;
    people.insert(s.performer);
    amount.minutes += static_cast<double>(s.frames) / kFramesAMinute;
  }
  amount.people = people.size();
  return amount;
}

FrameWeights as_drawn(const dataset::Dataset& dataset, double share) {
  double performed = 0, taken = 0;
  for (const dataset::Sequence& s : dataset.sequences)
    (s.from_take ? taken : performed) += static_cast<double>(s.frames);
  if (performed == 0 || taken == 0) return {};
  if (share == 1) return {.performed = 0, .taken = 1};
  return {.performed = 1, .taken = share / (1 - share) * performed / taken};
}

bool is_from_take(std::size_t index, double share, double phase) {
  const auto until = [&](std::size_t windows) {
    return std::floor(share * static_cast<double>(windows) + phase);
  };
  return until(index + 1) > until(index);
}

}  // namespace mien::train
