#include "mien/face/rig_constraints.h"

#include <algorithm>
#include <cmath>

namespace mien::face {
namespace {

float mean_of(const TogetherGroup& group, const BlendshapeWeights& w) noexcept {
  double sum = 0;
  for (const std::size_t i : group.shapes) sum += static_cast<double>(w[i]);
  return static_cast<float>(sum / static_cast<double>(group.shapes.size()));
}

/// How far the farthest of the group is beyond its band; at most 0 where all are within.
float beyond(const TogetherGroup& group, const BlendshapeWeights& w) noexcept {
  const float mean = mean_of(group, w);
  float most = 0;
  for (const std::size_t i : group.shapes) most = std::max(most, std::abs(w[i] - mean));
  return most - group.within;
}

/// Clipping moves the mean too, by less each time.
void draw_together(const TogetherGroup& group, BlendshapeWeights& w) noexcept {
  constexpr int kClips = 64;
  for (int k = 0; k < kClips && beyond(group, w) > 0.5F * kRuleTolerance; ++k) {
    const float mean = mean_of(group, w);
    for (const std::size_t i : group.shapes)
      w[i] = std::clamp(w[i], mean - group.within, mean + group.within);
  }
  // What has not come within by then is where all are.
  if (beyond(group, w) <= kRuleTolerance) return;
  const float mean = mean_of(group, w);
  for (const std::size_t i : group.shapes) w[i] = mean;
}

}  // namespace

bool ExclusivePair::obeyed(const BlendshapeWeights& w) const noexcept {
  return std::min(w[a], w[b]) <= kRuleTolerance;
}
bool TogetherGroup::obeyed(const BlendshapeWeights& w) const noexcept {
  return beyond(*this, w) <= kRuleTolerance;
}
bool Condition::obeyed(const BlendshapeWeights& w) const noexcept {
  return static_cast<double>(w[a]) <= most(w[b]) + kRuleTolerance;
}

double Condition::most(double b_weight) const noexcept {
  const auto after = std::ranges::find_if(at_most, [&](const Point& p) { return p.b >= b_weight; });
  if (after == at_most.end()) return at_most.back().a;
  if (after == at_most.begin()) return after->a;
  const Point &low = *(after - 1), &high = *after;
  return low.a + (high.a - low.a) * (b_weight - low.b) / (high.b - low.b);
}

bool RigConstraints::pass(BlendshapeWeights& w) const noexcept {
  bool moved = false;
  for (const ExclusivePair& pair : exclusive_)
    if (!pair.obeyed(w)) {
      w[w[pair.a] < w[pair.b] ? pair.a : pair.b] = 0;
      moved = true;
    }
  for (const TogetherGroup& group : together_)
    if (!group.obeyed(w)) {
      draw_together(group, w);
      moved = true;
    }
  for (const Condition& condition : conditions_)
    if (!condition.obeyed(w)) {
      w[condition.a] = static_cast<float>(condition.most(w[condition.b]));
      moved = true;
    }
  return moved;
}

void RigConstraints::project(BlendshapeWeights& w) const noexcept {
  for (int i = 0; i < kPasses; ++i)
    if (!pass(w)) return;
  // Nothing but zeros obeys every rule, whatever the others are.
  for (bool moved = true; moved;) {
    moved = false;
    const auto give_up = [&](std::size_t i) {
      moved = moved || w[i] != 0;
      w[i] = 0;
    };
    for (const ExclusivePair& pair : exclusive_)
      if (!pair.obeyed(w)) give_up(pair.b);
    for (const TogetherGroup& group : together_)
      if (!group.obeyed(w)) std::ranges::for_each(group.shapes, give_up);
    for (const Condition& condition : conditions_)
      if (!condition.obeyed(w)) give_up(condition.a);
  }
}

bool RigConstraints::obeyed(const BlendshapeWeights& w) const noexcept {
  const auto one = [&](const auto& rule) { return rule.obeyed(w); };
  return std::ranges::all_of(exclusive_, one) && std::ranges::all_of(together_, one) &&
         std::ranges::all_of(conditions_, one);
}

}  // namespace mien::face
