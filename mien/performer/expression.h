#pragma once

#include <span>
#include <string>

#include "mien/performer/canvas.h"
#include "mien/performer/script.h"
#include "mien/performer/style.h"

namespace mien::performer {

/// A named pose: "joy", "wink_L", "jawOpen".
struct Expression {
  std::string name;
  Pose pose;
  float tongue_out = 0;
};

/// Pose of an emotion: EMFACS action units (Ekman and Friesen 1983) in ARKit's shapes. neutral is empty.
[[nodiscard]] const Expression& emotion_expression(Emotion emotion);

/// The expressions of the block `expressions`: emotions, everyday expressions, every shape alone, both sides
/// and each side.
[[nodiscard]] std::span<const Expression> expression_library();

/// A person's variant of an expression: other strengths, a shape omitted, asymmetry. Deterministic in style
/// and expression.
[[nodiscard]] Pose personal_variant(const Expression& expression, const Style& style);

/// Fills the canvas with expressions in turn: neutral, ramp, hold, ramp.
void perform_expressions(Canvas& canvas, const Style& style, Random random);

/// Adds one emotion in waves over the canvas, mouth shapes weaker, since speech moves the mouth. `intensity`:
/// 0 to 1.
void perform_emotion(Canvas& canvas, Emotion emotion, double intensity, const Style& style, Random random);

}  // namespace mien::performer
