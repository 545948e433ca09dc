#include <benchmark/benchmark.h>

#include <cmath>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "mien/core/sha256.h"
#include "mien/eyewear/eyewear_tracker.h"

namespace {

using namespace mien;

constexpr std::size_t kSensors = 20;
constexpr double kScan_s = 1 / 230.0;

sensor::Rig rig() {
  sensor::Rig rig;
  rig.name = "glasses";
  rig.reference = "s0";
  for (std::size_t s = 0; s < kSensors; ++s) {
    sensor::Mount& mount = rig.sensors.emplace_back();
    mount.name = "s" + std::to_string(s);
    mount.kind = "photo";
    mount.role = "face";
  }
  return rig;
}

/// Markers down the face's middle.
eyewear::MarkerSet markers() {
  eyewear::MarkerSet set;
  set.name = "middle";
  for (int i = 0; i < 37; ++i)
    set.markers.push_back({"m" + std::to_string(i), eyewear::MarkerRegion::mouth,
                           Vec3(0.002 * (i % 7 - 3), 0.06 - 0.0035 * i, 0.12)});
  return set;
}

/// As cheap as a regressor can be: what is measured is all the rest.
class Straight final : public eyewear::MarkerRegressor {
 public:
  void step(const eyewear::LightFrame& light, Eigen::VectorXd& displacement_m) override {
    displacement_m.setZero(3 * 37);
    for (std::size_t s = 0; s < light.values.size(); ++s)
      displacement_m.segment<5>(static_cast<Eigen::Index>(5 * s)).array() += 0.003 * double{light.values[s]};
  }
  void reset() override {}
  [[nodiscard]] std::size_t marker_count() const override { return 37; }
};

/// Plays scans up to each frame of the grid, and asks for the frame.
class Player {
 public:
  Player()
      : tracker_(eyewear::EyewearTracker::create(rig(), markers(), std::make_unique<Straight>()).value()) {
    for (int i = 0; i < 180; ++i) frame();  // It finds its neutral.
  }
  const face::OutputFrame& frame() {
    ++frames_;
    const double frame_s = static_cast<double>(frames_) / kFrameRateHz;
    for (; static_cast<double>(scans_) * kScan_s < frame_s + kScan_s; ++scans_) {
      const double at_s = static_cast<double>(scans_) * kScan_s;
      sensor::Sample sample;
      sample.kind = sensor::SampleKind::photo_reflective;
      sample.sequence = static_cast<std::uint32_t>(scans_);
      sample.time = DeviceTime(from_seconds(at_s));
      sample.count = 2;
      sample.values[1] = 0.05F;
      for (std::uint16_t s = 0; s < kSensors; ++s) {
        const double wave = at_s < 2.5 ? 0 : 0.1 * std::sin(at_s * (1 + 0.3 * s));
        sample.sensor = s;
        sample.values[0] = static_cast<float>(0.3 + wave);
        tracker_->add(HostTime(from_seconds(at_s + 0.002)), sample);
      }
    }
    tracker_->tick(DeviceTime(from_seconds(frame_s)), out_);
    return out_;
  }

 private:
  std::unique_ptr<eyewear::EyewearTracker> tracker_;
  face::OutputFrame out_;
  std::int64_t frames_ = 0;
  std::int64_t scans_ = 0;
};

// Light of twenty sensors to weights by 37 markers, a frame with its 77 samples.
void eyewear_frame(benchmark::State& state) {
  Player player;
  for (auto step : state) {
    (void)step;
    benchmark::DoNotOptimize(player.frame());
  }
  Player again;
  Sha256 hash;
  for (int i = 0; i < 600; ++i) hash.add(std::as_bytes(std::span(again.frame().weights.values)));
  state.SetLabel("sha256 " + hash.hex().substr(0, 16));
}
BENCHMARK(eyewear_frame)->Unit(benchmark::kMicrosecond);

}  // namespace
