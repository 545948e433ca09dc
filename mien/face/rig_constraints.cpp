#include "mien/face/rig_constraints.h"

#include <array>

namespace mien::face {
namespace {

using Kind = ShapeRule::Kind;

constexpr std::array kNatural = {
    ShapeRule{Kind::exclusive, shape("jawLeft"), shape("jawRight")},
    ShapeRule{Kind::exclusive, shape("mouthLeft"), shape("mouthRight")},
    ShapeRule{Kind::exclusive, shape("mouthSmile_L"), shape("mouthFrown_L")},
    ShapeRule{Kind::exclusive, shape("mouthSmile_R"), shape("mouthFrown_R")},
    ShapeRule{Kind::exclusive, shape("mouthPucker"), shape("mouthStretch_L")},
    ShapeRule{Kind::exclusive, shape("mouthPucker"), shape("mouthStretch_R")},
    ShapeRule{Kind::exclusive, shape("browDown_L"), shape("browOuterUp_L")},
    ShapeRule{Kind::exclusive, shape("browDown_R"), shape("browOuterUp_R")},
    ShapeRule{Kind::exclusive, shape("eyeBlink_L"), shape("eyeWide_L")},
    ShapeRule{Kind::exclusive, shape("eyeBlink_R"), shape("eyeWide_R")},
    ShapeRule{Kind::exclusive, shape("eyeLookUp_L"), shape("eyeLookDown_L")},
    ShapeRule{Kind::exclusive, shape("eyeLookUp_R"), shape("eyeLookDown_R")},
    ShapeRule{Kind::exclusive, shape("eyeLookIn_L"), shape("eyeLookOut_L")},
    ShapeRule{Kind::exclusive, shape("eyeLookIn_R"), shape("eyeLookOut_R")},
    ShapeRule{Kind::together, shape("eyeBlink_L"), shape("eyeBlink_R")},
    ShapeRule{Kind::together, shape("browInnerUp_L"), shape("browInnerUp_R")},
    ShapeRule{Kind::at_most, shape("mouthClose"), shape("jawOpen")},
};

}  // namespace

std::span<const ShapeRule> natural_rules() {
  return kNatural;
}

}  // namespace mien::face
