#include "mien/performer/expression.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace mien::performer {

using face::kShapeCount;
using face::kShapeNames;
using face::shape;

namespace {

std::array<Expression, kEmotionCount> make_emotions() {
  return {{
      {"neutral", {}},
      // AU 6 + 12 + 25.
      {"joy", pose_of({{"mouthSmile", 0.8F},
                       {"cheekSquint", 0.6F},
                       {"eyeSquint", 0.35F},
                       {"mouthUpperUp", 0.2F},
                       {"mouthDimple", 0.15F},
                       {"jawOpen", 0.12F}})},
      // AU 1 + 4 + 15 + 17.
      {"sadness", pose_of({{"browInnerUp", 0.7F},
                           {"browDown", 0.2F},
                           {"mouthFrown", 0.6F},
                           {"mouthShrugLower", 0.4F},
                           {"mouthShrugUpper", 0.2F},
                           {"eyeSquint", 0.2F},
                           {"eyeBlink", 0.15F}})},
      // AU 4 + 5 + 7 + 23 + 24.
      {"anger", pose_of({{"browDown", 0.85F},
                         {"eyeSquint", 0.45F},
                         {"eyeWide", 0.2F},
                         {"noseSneer", 0.4F},
                         {"mouthPress", 0.5F},
                         {"mouthRollLower", 0.2F},
                         {"jawForward", 0.2F},
                         {"mouthFrown", 0.2F}})},
      // AU 1 + 2 + 4 + 5 + 20 + 25.
      {"fear", pose_of({{"browInnerUp", 0.8F},
                        {"browOuterUp", 0.45F},
                        {"browDown", 0.2F},
                        {"eyeWide", 0.7F},
                        {"mouthStretch", 0.55F},
                        {"mouthLowerDown", 0.3F},
                        {"jawOpen", 0.22F}})},
      // AU 9 + 10 + 15 + 17.
      {"disgust", pose_of({{"noseSneer", 0.8F},
                           {"mouthUpperUp", 0.5F},
                           {"browDown", 0.5F},
                           {"cheekSquint", 0.45F},
                           {"eyeSquint", 0.4F},
                           {"mouthFrown", 0.3F},
                           {"mouthShrugLower", 0.35F}})},
      // AU 1 + 2 + 5 + 26.
      {"surprise", pose_of({{"browInnerUp", 0.8F},
                            {"browOuterUp", 0.8F},
                            {"eyeWide", 0.6F},
                            {"jawOpen", 0.5F},
                            {"mouthFunnel", 0.15F}})},
      // AU 14, one side.
      {"contempt", pose_of({{"mouthDimple_L", 0.6F},
                            {"mouthSmile_L", 0.35F},
                            {"mouthPress_L", 0.3F},
                            {"browOuterUp_L", 0.4F},
                            {"eyeSquint_L", 0.25F},
                            {"cheekSquint_L", 0.2F}})},
  }};
}

const std::array<Expression, kEmotionCount>& emotions() {
  static const auto all = make_emotions();
  return all;
}

void add_looks(std::vector<Expression>& all) {
  const auto look = [&](std::string_view name, std::initializer_list<NamedPart> parts, float tongue = 0) {
    all.push_back({name, pose_of(parts), tongue});
  };
  look("smile_closed", {{"mouthSmile", 0.7F}, {"mouthPress", 0.25F}, {"cheekSquint", 0.3F}});
  look("smile_open",
       {{"mouthSmile", 0.9F}, {"jawOpen", 0.3F}, {"mouthUpperUp", 0.4F}, {"cheekSquint", 0.6F}});
  look("laugh", {{"mouthSmile", 1.0F},
                 {"jawOpen", 0.6F},
                 {"mouthUpperUp", 0.5F},
                 {"mouthLowerDown", 0.3F},
                 {"cheekSquint", 0.8F},
                 {"eyeSquint", 0.6F},
                 {"browInnerUp", 0.2F}});
  look("smirk_L", {{"mouthSmile_L", 0.7F}, {"mouthDimple_L", 0.4F}, {"mouthLeft", 0.2F}});
  look("smirk_R", {{"mouthSmile_R", 0.7F}, {"mouthDimple_R", 0.4F}, {"mouthRight", 0.2F}});
  look("snarl_L", {{"noseSneer_L", 0.8F}, {"mouthUpperUp_L", 0.7F}, {"cheekSquint_L", 0.5F}});
  look("snarl_R", {{"noseSneer_R", 0.8F}, {"mouthUpperUp_R", 0.7F}, {"cheekSquint_R", 0.5F}});
  look("bare_teeth",
       {{"mouthUpperUp", 0.7F}, {"mouthLowerDown", 0.7F}, {"mouthStretch", 0.5F}, {"noseSneer", 0.3F}});
  look("kiss", {{"mouthPucker", 0.95F}, {"mouthFunnel", 0.15F}, {"jawOpen", 0.05F}});
  look("whistle", {{"mouthPucker", 0.8F}, {"mouthFunnel", 0.4F}, {"jawOpen", 0.1F}});
  look("shout", {{"jawOpen", 0.95F},
                 {"mouthStretch", 0.4F},
                 {"mouthLowerDown", 0.5F},
                 {"mouthUpperUp", 0.4F},
                 {"browDown", 0.4F},
                 {"eyeSquint", 0.3F}});
  look("yawn", {{"jawOpen", 1.0F},
                {"mouthFunnel", 0.4F},
                {"eyeBlink", 0.8F},
                {"browInnerUp", 0.4F},
                {"eyeSquint", 0.5F}});
  look("pain", {{"browDown", 0.7F},
                {"eyeSquint", 0.8F},
                {"cheekSquint", 0.7F},
                {"noseSneer", 0.5F},
                {"mouthStretch", 0.5F},
                {"mouthUpperUp", 0.4F},
                {"eyeBlink", 0.5F}});
  look("pout",
       {{"mouthShrugLower", 0.8F}, {"mouthFrown", 0.4F}, {"mouthPucker", 0.3F}, {"browInnerUp", 0.3F}});
  look("doubt", {{"browDown_R", 0.5F},
                 {"browOuterUp_L", 0.7F},
                 {"browInnerUp_L", 0.3F},
                 {"mouthLeft", 0.3F},
                 {"eyeSquint_R", 0.4F}});
  look("thought", {{"mouthLeft", 0.4F}, {"mouthPress", 0.4F}, {"browDown", 0.3F}, {"mouthRollLower", 0.2F}});
  look("shrug", {{"mouthShrugLower", 0.7F},
                 {"mouthShrugUpper", 0.5F},
                 {"mouthFrown", 0.5F},
                 {"browInnerUp", 0.4F},
                 {"browOuterUp", 0.4F}});
  look("puffed", {{"cheekPuff", 0.9F}, {"mouthPress", 0.3F}, {"mouthPucker", 0.2F}});
  look("puffed_L", {{"cheekPuff_L", 0.9F}, {"mouthPress", 0.3F}, {"mouthRight", 0.15F}});
  look("puffed_R", {{"cheekPuff_R", 0.9F}, {"mouthPress", 0.3F}, {"mouthLeft", 0.15F}});
  look("lips_in", {{"mouthRollLower", 0.8F}, {"mouthRollUpper", 0.7F}, {"mouthPress", 0.3F}});
  look("bite_lip", {{"mouthRollLower", 0.7F}, {"mouthUpperUp", 0.25F}, {"jawOpen", 0.06F}});
  look("squeezed_shut", {{"eyeBlink", 1.0F},
                         {"eyeSquint", 0.9F},
                         {"cheekSquint", 0.6F},
                         {"browDown", 0.5F},
                         {"noseSneer", 0.3F}});
  look("wink_L",
       {{"eyeBlink_L", 1.0F}, {"eyeSquint_L", 0.5F}, {"cheekSquint_L", 0.5F}, {"mouthSmile_L", 0.25F}});
  look("wink_R",
       {{"eyeBlink_R", 1.0F}, {"eyeSquint_R", 0.5F}, {"cheekSquint_R", 0.5F}, {"mouthSmile_R", 0.25F}});
  look("sleepy", {{"eyeBlink", 0.6F}, {"browInnerUp", 0.25F}, {"jawOpen", 0.08F}});
  look("attention", {{"eyeWide", 0.5F}, {"browInnerUp", 0.4F}, {"browOuterUp", 0.5F}});
  look("jaw_thrust", {{"jawForward", 0.9F}, {"mouthShrugLower", 0.3F}, {"browDown", 0.3F}});
  look("tongue_out", {{"jawOpen", 0.4F}, {"mouthLowerDown", 0.3F}}, 1.0F);
  look("oh", {{"mouthFunnel", 0.8F}, {"jawOpen", 0.35F}});
  look("ee",
       {{"mouthStretch", 0.5F}, {"mouthSmile", 0.4F}, {"mouthLowerDown", 0.3F}, {"mouthUpperUp", 0.2F}});
}

std::vector<Expression> make_library() {
  std::vector<Expression> all(emotions().begin() + 1, emotions().end());
  add_looks(all);
  for (std::size_t k = 0; k < kShapeCount; ++k) {
    // Eyes are moved by the gaze model; mouthClose alone is no pose: it closes what jawOpen opens.
    if (kShapeNames[k].starts_with("eyeLook")) continue;
    Pose one = {{static_cast<std::uint8_t>(k), 0.9F}};
    if (k == shape("mouthClose")) one.push_back({static_cast<std::uint8_t>(shape("jawOpen")), 0.9F});
    const std::size_t twin = other_side(k);
    if (twin > k)
      all.push_back({kShapeNames[k].substr(0, kShapeNames[k].size() - 2),
                     {{static_cast<std::uint8_t>(k), 0.9F}, {static_cast<std::uint8_t>(twin), 0.9F}}});
    all.push_back({kShapeNames[k], std::move(one)});
  }
  return all;
}

}  // namespace

const Expression& emotion_expression(Emotion emotion) {
  return emotions()[static_cast<std::size_t>(emotion)];
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
