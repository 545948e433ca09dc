#include "mien/performer/rapid.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mien/core/time.h"
#include "mien/performer/performer.h"
#include "mien/performer/script.h"

namespace mien::performer::rapid_test {
namespace {

/// RMS speed of all weights, 1/s.
double speed(Block block, std::uint64_t seed) {
  const auto motion = perform(default_script(block, 60), plain_style(), Random(seed));
  double squares = 0;
  for (std::size_t i = 1; i < motion.frames.size(); ++i)
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      squares += std::pow(motion.frames[i].weights[k] - motion.frames[i - 1].weights[k], 2);
  return kFrameRateHz *
         std::sqrt(squares / static_cast<double>((motion.frames.size() - 1) * face::kShapeCount));
}

TEST(Rapid, IsFasterThanWhatPeopleDoOtherwise) {
  for (std::uint64_t seed = 0; seed < 3; ++seed)
    for (const Block other : {Block::reading, Block::expressions, Block::range_of_motion, Block::eating})
      EXPECT_GT(speed(Block::rapid, seed), 1.3 * speed(other, seed)) << block_name(other);
}

TEST(Rapid, HardlyRests) {
  Canvas canvas(3600);
  perform_rapid(canvas, Random(1));
  std::size_t still = 0, longest = 0;
  for (std::size_t i = 1; i < canvas.frame_count(); ++i) {
    double moved = canvas.lip_closure[i];
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      moved += std::abs(canvas.weights[i][k] - canvas.weights[i - 1][k]);
    still = moved < 1e-4 ? still + 1 : 0;
    longest = std::max(longest, still);
  }
  EXPECT_LT(longest, 75U);
}

}  // namespace
}  // namespace mien::performer::rapid_test
