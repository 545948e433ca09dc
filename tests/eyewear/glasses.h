#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "mien/builtin_face/markers.h"
#include "mien/core/random.h"
#include "mien/core/time.h"
#include "mien/eyewear/light_model.h"
#include "mien/eyewear/marker_regressor.h"
#include "mien/sensor/rig.h"
#include "mien/sensor/sample.h"
#include "tests/project_path.h"
#include "tests/tracker/tiny_model.h"

// A pair of glasses without skin, wire and markers of a real set: lights that are given by formula.
namespace mien::eyewear::test {

inline sensor::Rig glasses_rig(std::size_t sensors) {
  sensor::Rig rig;
  rig.name = "glasses";
  rig.reference = "s0";
  for (std::size_t i = 0; i < sensors; ++i) {
    sensor::Mount mount;
    mount.name = "s" + std::to_string(i);
    mount.kind = "eyewear";
    mount.role = "face";
    rig.sensors.push_back(mount);
  }
  return rig;
}

inline constexpr double kPairs_hz = 230;
/// The board's clock stands at this when the host's stands at 0.
inline constexpr double kBoard_s = 7;

/// What one sensor reads at a board's time: LED on and LED off.
inline sensor::Sample reading(std::uint16_t sensor, double board_s, double on, double off) {
  sensor::Sample sample;
  sample.sensor = sensor;
  sample.kind = sensor::SampleKind::eyewear_light;
  sample.sequence = static_cast<std::uint32_t>(std::lround(board_s * kPairs_hz));
  sample.time = DeviceTime(from_seconds(board_s));
  sample.count = 2;
  sample.values[0] = static_cast<float>(std::min(on, 1.0));
  sample.values[1] = static_cast<float>(std::min(off, 1.0));
  return sample;
}

/// Glasses that are played into something with add(arrival, sample) and a frame of the grid by `frame`.
/// `log_light(sensor, seconds)` is what comes back; a sensor for which it is not finite says nothing.
class Glasses {
 public:
  using LogLight = std::function<double(std::size_t sensor, double seconds)>;
  explicit Glasses(std::size_t sensors) : sensors_(sensors) {}

  template <class Taker, class Frame>
  void play(Taker& taker, double seconds, const LogLight& log_light, const Frame& frame) {
    const double end_s = now_s_ + seconds;
    while (now_s_ < end_s - 1e-9) {
      const double frame_s = now_s_ + 1 / kFrameRateHz;
      for (; next_ / kPairs_hz <= frame_s + 1 / kPairs_hz; ++next_) {
        const double at_s = static_cast<double>(next_) / kPairs_hz;
        for (std::size_t s = 0; s < sensors_; ++s) {
          const double light = log_light(s, at_s);
          if (!std::isfinite(light)) continue;
          taker.add(HostTime(from_seconds(at_s + 0.002)),
                    reading(static_cast<std::uint16_t>(s), kBoard_s + at_s, std::exp(light) + 0.05, 0.05));
        }
      }
      frame(DeviceTime(from_seconds(kBoard_s + frame_s)));
      now_s_ = frame_s;
    }
  }
  [[nodiscard]] double now_s() const { return now_s_; }
  /// The frame time that is so many seconds after the beginning.
  [[nodiscard]] static DeviceTime at(double seconds) { return DeviceTime(from_seconds(kBoard_s + seconds)); }

 private:
  std::size_t sensors_;
  std::int64_t next_ = 0;
  double now_s_ = 0;
};

/// A grid of light beside the clock models that a session keeps for it.
class ClockedGrid : public LightGrid {
 public:
  explicit ClockedGrid(const sensor::Rig& rig)
      : LightGrid(rig), lines_(rig.sensors.size(), rig.find(rig.reference)) {}
  void add(HostTime arrival, const sensor::Sample& sample) {
    lines_.add(arrival, sample);
    LightGrid::add(sample);
  }
  void tick(DeviceTime frame, GridLight& out) const { LightGrid::tick(frame, lines_, out); }

 private:
  sensor::TimeLines lines_;
};

/// Markers of lips and jaw, which tell how far a jaw is open and a mouth smiles.
inline builtin_face::MarkerSet mouth_markers() {
  builtin_face::MarkerSet set = builtin_face::read_markers(project_path("rigs/markers.toml")).value();
  const std::vector<std::size_t> mouth = set.of(builtin_face::MarkerRegion::mouth);
  builtin_face::MarkerSet kept;
  kept.name = "mouth";
  for (const std::size_t i : mouth) kept.markers.push_back(set.markers[i]);
  return kept;
}

inline MarkedFace marked_mouth() {
  return MarkedFace::create("mouth", mark_builtin(mouth_markers()).value()).value();
}

/// Markers straight from features: a column a sensor. It claims of every shape what it sees of its sensors.
class LinearRegressor final : public MarkerRegressor {
 public:
  explicit LinearRegressor(Eigen::MatrixXd gain_m) : gain_m_(std::move(gain_m)) {}
  void step(const LightFrame& light, Eigen::VectorXd& displacement_m) override {
    displacement_m.setZero(gain_m_.rows());
    for (Eigen::Index i = 0; i < gain_m_.cols(); ++i)
      displacement_m += double{light.values[static_cast<std::size_t>(i)]} * gain_m_.col(i);
    ++steps;
    coverage_ = static_cast<float>(std::ranges::count(light.present, std::uint8_t{1})) /
                static_cast<float>(gain_m_.cols());
  }
  void reset() override { ++resets; }
  [[nodiscard]] std::size_t marker_count() const override {
    return static_cast<std::size_t>(gain_m_.rows()) / 3;
  }
  [[nodiscard]] const model::ConfidenceTable* confidence() const override {
    return table ? &*table : nullptr;
  }
  [[nodiscard]] float coverage() const override { return coverage_; }
  std::optional<model::ConfidenceTable> table = tracker::test::coverage_as_confidence();
  int steps = 0;
  int resets = 0;

 private:
  Eigen::MatrixXd gain_m_;
  float coverage_ = 0;
};

}  // namespace mien::eyewear::test
