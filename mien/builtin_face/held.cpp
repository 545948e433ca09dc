#include "mien/builtin_face/held.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace mien::builtin_face {
namespace {

using P = BuiltinParameters;
constexpr double kMost = 3;  // Standard deviations.

constexpr ParameterRange number(std::string_view name, double P::*value) {
  return {name, value, -kMost, kMost};
}

constexpr std::array kRanges = {
    number("head_width", &P::head_width),
    number("face_length", &P::face_length),
    number("jaw_width", &P::jaw_width),
    number("chin_size", &P::chin_size),
    number("nose_length", &P::nose_length),
    number("nose_width", &P::nose_width),
    number("nose_bridge", &P::nose_bridge),
    number("eye_spacing", &P::eye_spacing),
    number("eye_size", &P::eye_size),
    number("mouth_width", &P::mouth_width),
    number("lip_fullness", &P::lip_fullness),
    number("cheekbones", &P::cheekbones),
    number("cheek_fullness", &P::cheek_fullness),
    number("brow_ridge", &P::brow_ridge),
    number("brow_height", &P::brow_height),
    number("forehead_height", &P::forehead_height),
    number("ear_size", &P::ear_size),
    number("neck_width", &P::neck_width),
    number("face_fullness", &P::face_fullness),
    number("jaw_angle", &P::jaw_angle),
    number("chin_width", &P::chin_width),
    number("nose_tip", &P::nose_tip),
    number("nose_root", &P::nose_root),
    number("alar_width", &P::alar_width),
    number("lip_projection", &P::lip_projection),
    number("philtrum_length", &P::philtrum_length),
    number("eye_slant", &P::eye_slant),
    number("eye_fold", &P::eye_fold),
    number("lid_opening", &P::lid_opening),
    number("ear_protrusion", &P::ear_protrusion),
    number("forehead_slope", &P::forehead_slope),
    number("temple_width", &P::temple_width),
    number("brow_fullness", &P::brow_fullness),
    ParameterRange{"age_years", &P::age_years, 18, 90},
    ParameterRange{"sex", &P::sex, -2, 2},
    ParameterRange{"asymmetry", &P::asymmetry, 0, 3},
    ParameterRange{"skin_tone", &P::skin_tone, 0, 1},
    ParameterRange{"skin_undertone", &P::skin_undertone, -1, 1},
    ParameterRange{"hair_tone", &P::hair_tone, 0, 1},
    ParameterRange{"hair_red", &P::hair_red, 0, 1},
    ParameterRange{"hair_grey", &P::hair_grey, 0, 1},
    ParameterRange{"eye_tone", &P::eye_tone, 0, 1},
    ParameterRange{"beard", &P::beard, 0, 1},
};
static_assert(kRanges[kIdentityNumbers - 1].name == "brow_fullness");

}  // namespace

std::span<const ParameterRange> parameter_ranges() {
  return kRanges;
}

BuiltinParameters held(BuiltinParameters parameters, std::vector<std::string>* said) {
  for (const ParameterRange& range : kRanges) {
    double& value = parameters.*range.value;
    const double before = value;
    value = std::isnan(value) ? BuiltinParameters().*range.value : std::clamp(value, range.least, range.most);
    if (value != before && said != nullptr)
      said->push_back(
          fmt::format("{} {:g} is beyond what people have, held to {:g}", range.name, before, value));
  }
  return parameters;
}

}  // namespace mien::builtin_face
