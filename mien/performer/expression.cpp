#include "mien/performer/expression.h"

#include <algorithm>

#include "mien/performer/tables.h"

namespace mien::performer {

using face::kShapeCount;
using face::kShapeNames;
using face::shape;

namespace {

std::vector<Expression> make_library() {
  std::vector<Expression> all(tables().emotions.begin() + 1, tables().emotions.end());
  all.insert(all.end(), tables().looks.begin(), tables().looks.end());
  for (std::size_t k = 0; k < kShapeCount; ++k) {
    // Eyes are moved by the gaze model; mouthClose alone is no pose: it closes what jawOpen opens.
    if (kShapeNames[k].starts_with("eyeLook")) continue;
    Pose one = {{static_cast<std::uint8_t>(k), 0.9F}};
    if (k == shape("mouthClose")) one.push_back({static_cast<std::uint8_t>(shape("jawOpen")), 0.9F});
    const std::size_t twin = other_side(k);
    if (twin > k)
      all.push_back({std::string(kShapeNames[k].substr(0, kShapeNames[k].size() - 2)),
                     {{static_cast<std::uint8_t>(k), 0.9F}, {static_cast<std::uint8_t>(twin), 0.9F}}});
    all.push_back({std::string(kShapeNames[k]), std::move(one)});
  }
  return all;
}

}  // namespace

const Expression& emotion_expression(Emotion emotion) {
  return tables().emotions[static_cast<std::size_t>(emotion)];
}

std::span<const Expression> expression_library() {
  static const auto library = make_library();
  return library;
}

Pose personal_variant(const Expression& expression, const Style& style) {
  if (style.taste == 0) return expression.pose;
  Random random = Random(style.taste).fork(expression.name);
  Pose pose = expression.pose;
  const double lead = random.normal(0, 0.12);
  for (PosePart& part : pose) {
    const double own = std::clamp(random.log_normal(0.3), 0.4, 1.5);
    const bool left_out = pose.size() > 3 && random.chance(0.12);
    const double side = kShapeNames[part.shape].ends_with("_L") ? 1 + lead : 1 - lead;
    part.weight = left_out ? 0.0F : static_cast<float>(std::min(1.05, part.weight * own * side));
  }
  return pose;
}

void perform_expressions(Canvas& canvas, const Style& style, Random random) {
  const auto library = expression_library();
  constexpr std::size_t kEmotions = kEmotionCount - 1;
  double now_s = random.uniform(0.1, 0.8);
  while (now_s < canvas.duration_s()) {
    // A third emotions, the rest looks and single shapes.
    const std::size_t which = random.chance(0.33) ? random.below(kEmotions) : random.below(library.size());
    const Expression& expression = library[which];
    Pose pose = personal_variant(expression, style);
    float tongue = expression.tongue_out;
    if (random.chance(0.2)) {
      // Two at once, each less.
      const Expression& second = library[random.below(library.size())];
      for (PosePart& part : pose) part.weight *= 0.75F;
      for (PosePart part : personal_variant(second, style)) {
        part.weight *= 0.6F;
        pose.push_back(part);
      }
      tongue = std::max(tongue, second.tongue_out);
    }
    const double peak = random.chance(0.25) ? random.uniform(0.25, 0.6) : random.uniform(0.6, 1.15);
    const double rise_s = random.uniform(0.2, 0.9) / style.tempo;
    const double hold_s = random.uniform(0.5, 2.2);
    const double fall_s = random.uniform(0.3, 1.1) / style.tempo;
    for (const PosePart& part : pose) {
      // Muscles do not start together.
      const double lag_s = random.uniform(0, 0.12);
      const double pace = std::clamp(random.log_normal(0.15), 0.7, 1.4);
      canvas.add(part.shape, {now_s + lag_s, rise_s * pace, hold_s, fall_s * pace}, peak * part.weight);
      // A held look slackens a little.
      canvas.add(part.shape, {now_s + lag_s + rise_s * pace, hold_s + 0.01, 0, fall_s * pace},
                 -peak * part.weight * random.uniform(0, 0.15));
    }
    if (tongue > 0) canvas.add_tongue({now_s + 0.5 * rise_s, rise_s, 0.6 * hold_s, fall_s}, tongue);
    now_s += rise_s + hold_s + fall_s + random.uniform(0.05, 1.0);
  }
}

void perform_emotion(Canvas& canvas, Emotion emotion, double intensity, const Style& style, Random random) {
  const Pose pose = personal_variant(emotion_expression(emotion), style);
  if (pose.empty()) return;
  // A level that stays, and waves that rise with the lines.
  SmoothNoise level(0.15, random);
  std::vector<SmoothNoise> own(pose.size(), SmoothNoise(0.4, random));
  for (std::size_t i = 0; i < canvas.frame_count(); ++i) {
    const double now = intensity * std::clamp(0.65 + 0.3 * level.next(random), 0.1, 1.1);
    for (std::size_t p = 0; p < pose.size(); ++p) {
      const double share = is_mouth_or_jaw(pose[p].shape) ? 0.5 : 1.0;
      const double wave = std::max(0.0, 1 + 0.25 * own[p].next(random));
      canvas.weights[i][pose[p].shape] += static_cast<float>(share * now * wave * pose[p].weight);
    }
  }
}

}  // namespace mien::performer
