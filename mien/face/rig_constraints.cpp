#include "mien/face/rig_constraints.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace mien::face {
namespace {

/// From here on a shape is outside of its band. Narrower than what is promised: floats round by 6e-8.
constexpr double kBandRounding = kRuleTolerance / 2;
/// A mean that is right to this is right.
constexpr double kMeanRounding = 1e-9;
/// Halvings of an interval of 1 to below kMeanRounding.
constexpr int kHalvings = 30;

/// A face on its way to the rules. What a pair or a condition has lowered is not raised again by a group,
/// which would only be lowered anew, by half in each pass, and never end.
struct Moving {
  BlendshapeWeights& weights;
  std::array<float, kShapeCount> most;

  explicit Moving(BlendshapeWeights& face) noexcept : weights(face), most() { most.fill(1); }
  void lower(std::size_t i, float to) noexcept {
    weights[i] = to;
    most[i] = std::min(most[i], to);
  }
};

float bound_of(const Condition& condition, const BlendshapeWeights& w) noexcept {
  return static_cast<float>(condition.most(w[condition.b]));
}

double mean_of(const TogetherGroup& group, const BlendshapeWeights& w) noexcept {
  double sum = 0;
  for (const std::size_t i : group.shapes) sum += static_cast<double>(w[i]);
  return sum / static_cast<double>(group.shapes.size());
}

double clipped(const TogetherGroup& group, float weight, double middle) noexcept {
  const auto within = static_cast<double>(group.within);
  return std::clamp(static_cast<double>(weight), middle - within, middle + within);
}

void clip(const TogetherGroup& group, BlendshapeWeights& w, double middle) noexcept {
  for (const std::size_t i : group.shapes) w[i] = static_cast<float>(clipped(group, w[i], middle));
}

/// Of a group that was clipped to the band of its mean: where clipping it to the band of what is the mean
/// now, and so on, ends. Found at once: the middle nearest to the mean that is itself the mean of what is
/// clipped to it. What the clipped mean is above its middle never rises with the middle, so halving finds it.
double band_middle(const TogetherGroup& group, const BlendshapeWeights& w) noexcept {
  const auto above = [&](double middle) {
    double sum = 0;
    for (const std::size_t i : group.shapes) sum += clipped(group, w[i], middle);
    return sum / static_cast<double>(group.shapes.size()) - middle;
  };
  const double mean = mean_of(group, w);
  const double at_mean = above(mean);
  if (std::abs(at_mean) <= kMeanRounding) return mean;
  const bool up = at_mean > 0;
  double near = mean, far = mean;
  for (const std::size_t i : group.shapes) {
    const auto weight = static_cast<double>(w[i]);
    far = up ? std::max(far, weight) : std::min(far, weight);
  }
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (near + far);
    const double now = above(middle);
    const bool on_the_way = up ? now > kMeanRounding : now < -kMeanRounding;
    (on_the_way ? near : far) = middle;
  }
  return far;
}

/// To the band of a group of which one may not be above `most`: the lower ones become `most`, the upper ones
/// as much as leaves the mean within reach of both. The higher they are, the worse for both: halving.
void clip_to_lowered(const TogetherGroup& group, BlendshapeWeights& w, double most) noexcept {
  const auto within = static_cast<double>(group.within);
  double low = most, high = 1;
  for (int i = 0; i < kHalvings; ++i) {
    const double top = 0.5 * (low + high);
    double sum = 0;
    for (const std::size_t k : group.shapes) sum += std::clamp(static_cast<double>(w[k]), most, top);
    const double mean = sum / static_cast<double>(group.shapes.size());
    (top - mean <= within && mean - most <= within ? low : high) = top;
  }
  for (const std::size_t k : group.shapes)
    w[k] = static_cast<float>(std::clamp(static_cast<double>(w[k]), most, low));
}

// Each brings a face to one rule and says whether it had to.

bool settle(const ExclusivePair& pair, Moving& face) noexcept {
  if (pair.obeyed(face.weights)) return false;
  face.lower(face.weights[pair.a] < face.weights[pair.b] ? pair.a : pair.b, 0);
  return true;
}

bool settle(const TogetherGroup& group, Moving& face) noexcept {
  if (group.obeyed(face.weights)) return false;
  float most = 1;
  for (const std::size_t i : group.shapes) most = std::min(most, face.most[i]);
  BlendshapeWeights drawn = face.weights;
  clip(group, drawn, mean_of(group, drawn));
  const double middle = band_middle(group, drawn);  // Clipping has moved the mean.
  if (middle - static_cast<double>(group.within) <= static_cast<double>(most)) {
    clip(group, drawn, middle);
    face.weights = drawn;
  } else {
    clip_to_lowered(group, face.weights, static_cast<double>(most));
  }
  return true;
}

bool settle(const Condition& condition, Moving& face) noexcept {
  if (condition.obeyed(face.weights)) return false;
  face.lower(condition.a, bound_of(condition, face.weights));
  return true;
}

template <class Rule>
bool settle_all(const std::vector<Rule>& rules, Moving& face) noexcept {
  bool moved = false;
  for (const Rule& rule : rules) moved = settle(rule, face) || moved;
  return moved;
}

/// Nothing but zeros obeys every rule, whatever the others are.
void give_up_what_is_broken(const RuleSet& rules, BlendshapeWeights& w) noexcept {
  for (bool moved = true; moved;) {
    moved = false;
    const auto give_up = [&](std::size_t i) {
      moved = moved || w[i] != 0;
      w[i] = 0;
    };
    for (const ExclusivePair& pair : rules.exclusive)
      if (!pair.obeyed(w)) give_up(pair.b);
    for (const TogetherGroup& group : rules.together)
      if (!group.obeyed(w)) std::ranges::for_each(group.shapes, give_up);
    for (const Condition& condition : rules.conditions)
      if (!condition.obeyed(w)) give_up(condition.a);
  }
}

}  // namespace

bool ExclusivePair::obeyed(const BlendshapeWeights& w) const noexcept {
  return !(w[a] > 0 && w[b] > 0);
}

bool TogetherGroup::obeyed(const BlendshapeWeights& w) const noexcept {
  const double mean = mean_of(*this, w);
  return std::ranges::all_of(shapes, [&](std::size_t i) {
    return std::abs(static_cast<double>(w[i]) - mean) <= static_cast<double>(within) + kBandRounding;
  });
}

bool Condition::obeyed(const BlendshapeWeights& w) const noexcept {
  return w[a] <= bound_of(*this, w);
}

double Condition::most(double b_weight) const noexcept {
  const auto after = std::ranges::find_if(at_most, [&](const Point& p) { return p.b >= b_weight; });
  if (after == at_most.end()) return at_most.back().a;
  if (after == at_most.begin()) return after->a;
  const Point &low = *(after - 1), &high = *after;
  const double between = low.a + (high.a - low.a) * (b_weight - low.b) / (high.b - low.b);
  // Rounding must not lead beyond the points, least of all below 0.
  return std::clamp<double>(between, std::min(low.a, high.a), std::max(low.a, high.a));
}

bool RuleSet::settles(BlendshapeWeights& w) const noexcept {
  Moving face(w);
  for (int pass = 0; pass < kPasses; ++pass) {
    bool moved = settle_all(exclusive, face);
    moved = settle_all(together, face) || moved;
    moved = settle_all(conditions, face) || moved;
    if (!moved) return true;
  }
  return obeyed(w);
}

void RuleSet::project(BlendshapeWeights& w) const noexcept {
  for (float& x : w.values) x = x >= 0 ? std::min(x, 1.0F) : 0.0F;
  if (!settles(w)) give_up_what_is_broken(*this, w);
}

bool RuleSet::obeyed(const BlendshapeWeights& w) const noexcept {
  const auto one = [&](const auto& rule) { return rule.obeyed(w); };
  return std::ranges::all_of(w.values, [](float x) { return x >= 0 && x <= 1; }) &&
         std::ranges::all_of(exclusive, one) && std::ranges::all_of(together, one) &&
         std::ranges::all_of(conditions, one);
}

}  // namespace mien::face
