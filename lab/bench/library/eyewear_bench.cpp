#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "mien/core/files.h"
#include "mien/eyewear/eyewear_tracker.h"
#include "mien/eyewear/marker_network.h"
#include "mien/face/frame_hash.h"
#include "mien/sensor/clock_model.h"
#include "mien/sensor/rig.h"

namespace {

using namespace mien;

constexpr double kPairsHz = 230;
constexpr double kLoopS = 4;

/// Glasses of twenty sensors whose light waves, each at its own pace, in an order as it would arrive.
std::vector<sensor::Sample> wave(std::size_t sensors) {
  std::vector<sensor::Sample> samples;
  for (std::uint32_t pair = 0; pair < static_cast<std::uint32_t>(kLoopS * kPairsHz); ++pair)
    for (std::size_t s = 0; s < sensors; ++s) {
      const double time_s = static_cast<double>(pair) / kPairsHz;
      sensor::Sample& sample = samples.emplace_back();
      sample.sensor = static_cast<std::uint16_t>(s);
      sample.kind = sensor::SampleKind::eyewear_light;
      sample.sequence = pair;
      sample.time = DeviceTime(from_seconds(time_s));
      sample.count = 2;
      sample.values[1] = 0.05F;
      // Two seconds of neutral, by which the tracker calibrates itself.
      const double moved = time_s < 2.5 ? 0.0 : std::sin(3 * time_s + static_cast<double>(s));
      sample.values[0] = static_cast<float>(0.05 + 0.2 * std::exp(0.3 * moved));
    }
  return samples;
}

/// A whole frame of a live session at full rate: 77 samples, filters, grid, features, network and weights.
void eyewear_frame(benchmark::State& state) {
  const sensor::Rig rig = sensor::read_rig(find_resource("rigs/eyewear.toml").value()).value();
  const builtin_face::MarkerSet set =
      builtin_face::read_markers(find_resource("rigs/markers.toml").value()).value();
  eyewear::MarkerNetworkFile file =
      eyewear::read_marker_network(find_resource("models/eyewear.safetensors").value()).value();
  const auto tracker =
      eyewear::EyewearTracker::create(
          rig, set,
          eyewear::NetworkRegressor::create(std::move(file), eyewear::photo_sensor_names(rig)).value())
          .value();
  const std::vector<sensor::Sample> samples = wave(rig.sensors.size());
  sensor::TimeLines lines(rig.sensors.size(), rig.find(rig.reference));
  face::FrameHash hash;
  face::OutputFrame out;
  std::size_t next = 0;
  std::int64_t frame = 0;
  Duration loop{};  // Of the loops that are over.
  const auto step = [&] {
    const DeviceTime time{from_seconds(static_cast<double>(++frame) / kFrameRateHz)};
    for (;; ++next) {
      if (next == samples.size()) {
        next = 0;
        loop += from_seconds(kLoopS);
      }
      sensor::Sample sample = samples[next];
      sample.time += loop;
      if (sample.time > time) break;
      const HostTime arrival(sample.time.time_since_epoch());
      lines.add(arrival, sample);
      tracker->add(arrival, sample);
    }
    return tracker->tick(time, lines, out).sensors_present;
  };
  for (int i = 0; i < 600; ++i) {
    step();
    hash.add(out);
  }
  const bool calibrated = tracker->calibration_state().phase == tracker::CalibrationState::Phase::done;
  std::size_t there = 0;
  for (auto turn : state) {
    (void)turn;
    there = step();
    benchmark::DoNotOptimize(out);
  }
  state.SetLabel(std::string(calibrated ? "calibrated, " : "NOT CALIBRATED, ") + std::to_string(there) +
                 " sensors at the end, sha256 of 600 frames " + hash.hex().substr(0, 16));
}
BENCHMARK(eyewear_frame)->Unit(benchmark::kMicrosecond);

}  // namespace
