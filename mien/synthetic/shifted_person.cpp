#include "mien/synthetic/shifted_person.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include "mien/performer/canvas.h"
#include "mien/performer/performer.h"
#include "mien/performer/script.h"
#include "mien/virtual/performance.h"

namespace mien::synthetic {
namespace {

using performer::Block;

/// How another capture system reports a weight w: rest + (1 - rest) w^exponent.
struct Response {
  float rest = 0;
  float exponent = 1;
};
using Responses = std::array<Response, face::kShapeCount>;

/// The same in every system: where the eyes look, closed lids, teeth that meet, lips over an open jaw.
bool is_anchored(std::size_t shape) {
  const std::string_view name = face::kShapeNames[shape];
  return name.starts_with("eyeLook") || name.starts_with("eyeBlink") || name == "jawOpen" ||
         name == "mouthClose";
}

Responses draw_responses(bool bent, Random random) {
  Responses out;
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    if (is_anchored(k)) continue;
    const std::size_t twin = performer::other_side(k);
    if (twin < k) {
      out[k] = {std::min(0.4F, static_cast<float>(out[twin].rest * random.log_normal(0.15))),
                out[twin].exponent};
      continue;
    }
    if (random.chance(0.3)) out[k].rest = static_cast<float>(random.uniform(0.0, 0.4));
    if (bent) out[k].exponent = static_cast<float>(random.log_normal(0.5));
  }
  return out;
}

face::Motion reported(face::Motion motion, const Responses& responses) {
  for (face::MotionFrame& frame : motion.frames)
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      if (!is_anchored(k))
        frame.weights[k] =
            responses[k].rest +
            (1 - responses[k].rest) * std::pow(std::max(0.0F, frame.weights[k]), responses[k].exponent);
  return motion;
}

}  // namespace

ShiftedPerson draw_shifted_person(std::size_t index, double seconds, const Random& root) {
  virt::VirtualPerson person = virt::draw_person(root);
  const std::size_t kind = index % kShiftKinds;
  if (kind == 0) {
    const Block block = index / kShiftKinds % 2 == 0 ? Block::eating : Block::rapid;
    return {std::move(person.face),
            performer::perform(performer::default_script(block, seconds), person.style, root.fork("motion"))};
  }
  return {std::move(person.face), reported(virt::draw_motion(seconds, person.style, root),
                                           draw_responses(kind == 2, root.fork("response")))};
}

}  // namespace mien::synthetic
