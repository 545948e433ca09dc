#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "mien/core/random.h"
#include "mien/face/profile.h"
#include "mien/virtual/eyewear/marker_poses.h"

namespace mien::lab {

/// The kinds of test expressions of Asano et al. 2017, section 5.1: neutral, (A) poses of the six components,
/// (B) the six universal expressions, (C) asymmetric ones.
enum class SensorsTestSet : std::uint8_t { neutral, components, universal, asymmetric };
inline constexpr std::size_t kTestSets = 4;
/// "neutral", "A", "B", "C".
[[nodiscard]] std::string_view sensors_test_set_name(SensorsTestSet set);

/// One expression that a wearer is to make.
struct SensorsTest {
  SensorsTestSet set = SensorsTestSet::neutral;
  face::BlendshapeWeights target;
};
inline constexpr std::size_t kTests = 19;

/// The tests in the order in which they are made: kTests of them. Components' poses are drawn.
[[nodiscard]] std::vector<SensorsTest> make_sensors_tests(const virt::MarkerPoses& poses, Random random);

}  // namespace mien::lab
