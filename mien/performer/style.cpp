#include "mien/performer/style.h"

#include <algorithm>
#include <string_view>

#include "mien/performer/tables.h"

namespace mien::performer {

using face::kShapeCount;
using face::kShapeNames;
using face::shape;

namespace {

void draw_gains(Style& style, Random random) {
  for (std::size_t k = 0; k < kShapeCount; ++k) {
    const std::size_t twin = other_side(k);
    const bool second_side = twin < k;
    const double strength = second_side ? style.gain[twin] : std::clamp(random.log_normal(0.25), 0.5, 1.7);
    // A face is seldom even: one side leads by about an eighth.
    const double side = twin == k ? 1 : random.log_normal(second_side ? 0.12 : 0.0);
    style.gain[k] = static_cast<float>(std::clamp(strength * side, 0.4, 1.9));
    style.side_leak[k] = second_side ? style.side_leak[twin] : static_cast<float>(random.uniform(0.0, 0.5));
  }
  // A blink and the jaw reach their ends in everybody.
  for (const std::size_t k : {shape("eyeBlink_L"), shape("eyeBlink_R")}) style.gain[k] = 1;
  // Lids and brows hardly move alone in many people.
  const auto tie = static_cast<float>(random.uniform(0.1, 0.9));
  for (const std::string_view stem : {"browInnerUp", "browOuterUp", "browDown", "eyeWide"})
    for (std::size_t k = 0; k < kShapeCount; ++k)
      if (kShapeNames[k].starts_with(stem)) style.side_leak[k] = tie;
}

void draw_rest(Style& style, Random random) {
  // Most shapes rest near nothing, some well above: how people's faces hang, and how trackers see them.
  const double level = 0.035 * random.log_normal(0.5);
  for (std::size_t k = 0; k < kShapeCount; ++k) {
    if (is_driven_by_others(k)) continue;
    const std::size_t twin = other_side(k);
    if (twin < k) {
      style.rest[k] = static_cast<float>(style.rest[twin] * random.log_normal(0.15));
      continue;
    }
    double rest = std::min(0.25, random.exponential(level));
    // Shapes that skin sensors hardly observe must not be estimated as zero, so their rest is drawn widest.
    const bool hidden = kShapeNames[k].starts_with("eyeWide") || kShapeNames[k].starts_with("eyeBlink") ||
                        kShapeNames[k].starts_with("eyeSquint") || kShapeNames[k].starts_with("mouthShrug");
    if (random.chance(hidden ? 0.5 : 0.12)) rest = random.uniform(0.0, 0.4);
    style.rest[k] = static_cast<float>(rest);
  }
  // Lids that rest half closed are not wide open too.
  for (const auto& [blink, wide] : {std::pair{shape("eyeBlink_L"), shape("eyeWide_L")},
                                    std::pair{shape("eyeBlink_R"), shape("eyeWide_R")}}) {
    const float both = 0.7F * std::min(style.rest[blink], style.rest[wide]);
    style.rest[blink] -= both;
    style.rest[wide] -= both;
  }
  style.rest_gaze_rad = {static_cast<float>(random.normal(0, 0.06)),
                         static_cast<float>(random.normal(-0.05, 0.1))};
}

void add_habit(Style& style, std::size_t from, std::size_t to, double amount) {
  style.habits.push_back(
      {static_cast<std::uint8_t>(from), static_cast<std::uint8_t>(to), static_cast<float>(amount)});
}

void draw_habits(Style& style, Random random) {
  for (const Coupling& coupling : tables().couplings) {
    const double amount = coupling.amount * random.uniform(0, 2);
    if (coupling.from.size() == 1)
      add_habit(style, coupling.from[0].shape, coupling.to[0].shape, amount);
    else
      for (std::size_t side = 0; side < 2; ++side)
        add_habit(style, coupling.from[side].shape, coupling.to[side].shape,
                  amount * random.log_normal(0.15));
  }
  // Slight random couplings, most of them about the mouth, where all muscles pull at the same ring.
  const auto count = 20 + random.below(40);
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::size_t from = random.below(kShapeCount);
    const std::size_t to = random.below(kShapeCount);
    const double amount = random.uniform(0, 0.22);
    const bool near = is_mouth_or_jaw(from) == is_mouth_or_jaw(to);
    if (from == to || is_driven_by_others(from) || is_driven_by_others(to) ||
        kShapeNames[to].starts_with("eyeBlink"))
      continue;
    if (!near && !random.chance(0.3)) continue;
    add_habit(style, from, to, amount);
    if (other_side(from) != from && other_side(to) != to)
      add_habit(style, other_side(from), other_side(to), amount);
  }
}

}  // namespace

Style draw_style(Random& random) {
  const Random root(random.bits());
  Style style;
  draw_gains(style, root.fork("gain"));
  draw_rest(style, root.fork("rest"));
  draw_habits(style, root.fork("habits"));
  Random traits = root.fork("traits");
  const auto factor = [&](double sigma, double low, double high) {
    return static_cast<float>(std::clamp(traits.log_normal(sigma), low, high));
  };
  style.expressiveness = factor(0.25, 0.5, 1.6);
  style.tempo = factor(0.25, 0.55, 1.8);
  style.blink_rate_per_min = static_cast<float>(traits.uniform(10, 25));
  style.blink_peak = static_cast<float>(traits.uniform(0.75, 1.0));
  style.lid_follow = static_cast<float>(traits.uniform(0.1, 0.6));
  style.micro_motion = static_cast<float>(std::clamp(0.005 * traits.log_normal(0.5), 0.001, 0.02));
  style.head_liveliness = factor(0.35, 0.4, 2.0);
  style.gaze_range = factor(0.3, 0.5, 1.8);
  style.articulation = factor(0.25, 0.55, 1.7);
  style.speech_rate = factor(0.15, 0.7, 1.4);
  style.taste = traits.bits();
  return style;
}

Style plain_style() {
  Style style;
  style.gain.fill(1);
  style.micro_motion = 0;
  style.lid_follow = 0;
  style.blink_peak = 1;
  return style;
}

bool is_mouth_or_jaw(std::size_t shape) {
  return kShapeNames[shape].starts_with("mouth") || kShapeNames[shape].starts_with("jaw");
}

}  // namespace mien::performer
