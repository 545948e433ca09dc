#include <benchmark/benchmark.h>

#include <array>
#include <cmath>
#include <vector>

#include "mien/core/random.h"
#include "mien/face/frame_hash.h"
#include "mien/shaping/merge.h"

namespace {

using namespace mien;

/// A tracker's frames of ten seconds: every shape its own wave, sure of itself now and then.
std::vector<face::OutputFrame> frames(std::uint64_t seed, bool hovers) {
  Random random(seed);
  std::vector<face::OutputFrame> out(600);
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i].time = DeviceTime(frame_offset(static_cast<std::int64_t>(i) + 1));
    for (std::size_t k = 0; k < face::kShapeCount; ++k) {
      out[i].weights[k] =
          static_cast<float>(0.5 + 0.5 * std::sin(0.1 * static_cast<double>(i) + static_cast<double>(k)));
      out[i].confidence[k] = hovers ? static_cast<float>(random.uniform(0, 1)) : 1.0F;
    }
    out[i].head = exp_rotation({0, 0.01 * std::sin(0.1 * static_cast<double>(i)), 0});
    out[i].head_confidence = 1;
    out[i].head_provenance = face::Provenance::measured;
  }
  return out;
}

// One frame of two trackers made one; `hovers`: shapes change hands all the time, and are eased over.
void merge_of_two(benchmark::State& state) {
  const bool hovers = state.range(0) != 0;
  std::vector<face::OutputFrame> imu = frames(1, hovers), eyewear = frames(2, hovers);
  shaping::Merge merge({"imu", "eyewear"});
  face::FrameHash hash;
  face::OutputFrame out;
  std::size_t i = 0;
  bool first = true;
  for (auto step : state) {
    (void)step;
    const std::array<shaping::Merge::Source, 2> sources = {shaping::Merge::Source{&imu[i], 12},
                                                           shaping::Merge::Source{&eyewear[i], 16}};
    benchmark::DoNotOptimize(merge.apply(sources, out));
    if (++i == imu.size()) {
      i = 0;
      first = false;
    }
    if (first) {
      state.PauseTiming();
      hash.add(out);
      state.ResumeTiming();
    }
  }
  state.SetLabel("sha256 " + hash.hex().substr(0, 16));
}
BENCHMARK(merge_of_two)->Arg(0)->Arg(1)->Iterations(60'000);

}  // namespace
