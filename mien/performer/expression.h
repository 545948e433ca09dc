#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "mien/performer/canvas.h"
#include "mien/performer/script.h"
#include "mien/performer/style.h"

namespace mien::performer {

/// A pose with a name: "joy", "wink_L", "jawOpen".
struct Expression {
  std::string_view name;
  Pose pose;
  float tongue_out = 0;
};

/// How people show an emotion, after the action units of EMFACS (Ekman and Friesen 1983) written in ARKit's
/// shapes. neutral is empty.
[[nodiscard]] const Expression& emotion_expression(Emotion emotion);

/// Everything that the block `expressions` draws from: emotions, other looks of daily life, every shape
/// alone, both sides together and each side.
[[nodiscard]] std::span<const Expression> expression_library();

/// The person's own variant of an expression: other strengths, a shape left out, one side ahead. The same
/// style gives the same variant of the same expression.
[[nodiscard]] Pose personal_variant(const Expression& expression, const Style& style);

/// Adds classified expressions one after the other: neutral, ramp, hold, ramp.
void perform_expressions(Canvas& canvas, const Style& style, Random random);

/// Adds one emotion that comes and goes in waves, mouth shapes at less strength since the mouth speaks.
void perform_emotion(Canvas& canvas, Emotion emotion, double intensity, const Style& style, Random random);

}  // namespace mien::performer
