#include "mien/performer/free.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace mien::performer {

using face::kShapeCount;
using face::kShapeNames;
using face::shape;

namespace {

/// Shapes that lie together on the face.
constexpr std::size_t kRegionCount = 6;

std::size_t region_of(std::size_t k) {
  const std::string_view name = kShapeNames[k];
  if (name.starts_with("brow")) return 0;
  if (name.starts_with("eye")) return 1;
  if (name.starts_with("cheek") || name.starts_with("nose")) return 2;
  if (name.starts_with("jaw")) return 3;
  for (const std::string_view corner :
       {"mouthSmile", "mouthFrown", "mouthDimple", "mouthStretch", "mouthLeft", "mouthRight"})
    if (name.starts_with(corner)) return 4;
  return 5;
}

const std::array<std::vector<std::size_t>, kRegionCount>& region_shapes() {
  static const auto all = [] {
    std::array<std::vector<std::size_t>, kRegionCount> shapes;
    for (std::size_t k = 0; k < kShapeCount; ++k)
      if (!is_driven_by_others(k)) shapes[region_of(k)].push_back(k);
    return shapes;
  }();
  return all;
}

/// Lips carry most shapes and most of what is lost, so most draws fall there.
std::size_t draw_region(Random& random) {
  constexpr std::array<double, kRegionCount> kShare = {0.16, 0.10, 0.14, 0.14, 0.23, 0.23};
  double u = random.uniform();
  for (std::size_t r = 0; r + 1 < kRegionCount; ++r) {
    if (u < kShare[r]) return r;
    u -= kShare[r];
  }
  return kRegionCount - 1;
}

/// The jaw mostly opens; few people push it forward or aside unless they are asked to.
constexpr double kJawOpens = 0.7;

std::size_t draw_shape(std::size_t region, Random& random) {
  const auto& shapes = region_shapes()[region];
  if (region == region_of(shape("jawOpen")) && random.chance(kJawOpens)) return shape("jawOpen");
  return shapes[random.below(shapes.size())];
}

void add_part(Pose& pose, std::size_t k, double weight) {
  pose.push_back({static_cast<std::uint8_t>(k), static_cast<float>(weight)});
}

/// A combination of shapes that go together for a while. The first has loading 1.
Pose draw_combination(Random& random) {
  Pose pose;
  const std::size_t home = draw_region(random);
  const double width = random.uniform();
  std::size_t count = 1;
  if (width > 0.25) count += 1 + random.below(3);
  if (width > 0.75) count += random.below(7);
  const double even = random.uniform();  // This much of it is the same on both sides.
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t region = i == 0 || random.chance(0.65) ? home : draw_region(random);
    const std::size_t k = draw_shape(region, random);
    const double loading = i == 0 ? 1.0 : random.uniform(0.1, 1.0);
    add_part(pose, k, loading);
    const std::size_t twin = other_side(k);
    if (twin == k) continue;
    if (random.chance(0.75)) {
      add_part(pose, twin, loading * (even > 0.5 ? random.log_normal(0.1) : random.uniform(0.2, 1.0)));
    }
  }
  // Lips that stay together over an open jaw.
  for (const PosePart part : Pose(pose))
    if (part.shape == shape("jawOpen") && random.chance(0.25))
      add_part(pose, shape("mouthClose"), part.weight * random.uniform(0.4, 1.0));
  return pose;
}

/// Mostly slight and middling, sometimes to the end and a little beyond.
double draw_peak(Random& random) {
  if (random.chance(0.15)) return random.uniform(0.8, 1.1);
  return 0.9 * std::pow(random.uniform(), 1.4);
}

/// What a regime has in common.
struct Regime {
  std::size_t begin;  // Frames.
  std::size_t end;
  double strength;
  double slowness;  // Factor on times.
  std::vector<Pose> combinations;

  [[nodiscard]] double begin_s() const { return static_cast<double>(begin) / kFrameRateHz; }
  [[nodiscard]] double end_s() const { return static_cast<double>(end) / kFrameRateHz; }
  [[nodiscard]] const Pose& pick(Random& random) const {
    return combinations[random.below(combinations.size())];
  }
};

double log_uniform(double low, double high, Random& random) {
  return std::exp(random.uniform(std::log(low), std::log(high)));
}

/// A pose whose parts do not keep step: each its own delay and pace.
void add_loose(Canvas& canvas, const Pose& pose, const Envelope& envelope, double peak, double looseness,
               Random& random) {
  for (const PosePart& part : pose) {
    Envelope own = envelope;
    own.begin_s += looseness * random.uniform(0, 0.5) * envelope.rise_s;
    own.rise_s = std::max(0.07, own.rise_s * (1 + looseness * random.uniform(-0.3, 0.3)));
    own.fall_s = std::max(0.07, own.fall_s * (1 + looseness * random.uniform(-0.3, 0.3)));
    canvas.add(part.shape, own, peak * part.weight);
  }
}

void bumps(Canvas& canvas, const Regime& regime, Random& random) {
  const double rate_hz = log_uniform(0.5, 5.0, random) / std::sqrt(regime.slowness);
  const double fresh = random.uniform(0, 0.6);  // Share of combinations that never come back.
  const double looseness = random.uniform();
  for (double t = regime.begin_s(); t < regime.end_s(); t += random.exponential(1 / rate_hz)) {
    const double rise_s = std::clamp(regime.slowness * log_uniform(0.08, 1.0, random), 0.08, 2.0);
    const double hold_s =
        random.chance(0.4) ? 0 : std::min(2.0, regime.slowness * log_uniform(0.05, 1.0, random));
    const double fall_s = std::clamp(rise_s * random.uniform(0.7, 2.0), 0.08, 2.0);
    const double peak = regime.strength * draw_peak(random);
    add_loose(canvas, random.chance(fresh) ? draw_combination(random) : regime.pick(random),
              {t, rise_s, hold_s, fall_s}, peak, looseness, random);
  }
}

void processes(Canvas& canvas, const Regime& regime, Random& random) {
  // Sparse loadings on a few smooth latents; what falls below zero rests.
  const std::size_t rank = std::min<std::size_t>(regime.combinations.size(), 2 + random.below(6));
  for (std::size_t r = 0; r < rank; ++r) {
    const double cutoff_hz = log_uniform(0.25, 4.0, random) / regime.slowness;
    SmoothNoise latent(std::clamp(cutoff_hz, 0.05, 6.0), random);
    const double offset = random.uniform(-1.2, 0.6);
    const double scale = regime.strength * random.uniform(0.15, 0.5);
    const Pose& pose = regime.combinations[r];
    // Some parts move against the others.
    std::vector<float> sign(pose.size(), 1.0F);
    for (float& s : sign)
      if (random.chance(0.15)) s = -1;
    const double overlap_s = 0.5;
    const std::size_t end =
        std::min(canvas.frame_count(), regime.end + static_cast<std::size_t>(overlap_s * kFrameRateHz));
    for (std::size_t i = regime.begin; i < end; ++i) {
      const double from_begin = static_cast<double>(i - regime.begin) / kFrameRateHz;
      const double to_end = static_cast<double>(end - i) / kFrameRateHz;
      const double share = minimum_jerk(from_begin / overlap_s) * minimum_jerk(to_end / overlap_s);
      const double x = latent.next(random);
      for (std::size_t p = 0; p < pose.size(); ++p) {
        const double level = sign[p] * x + offset;
        // A soft corner at zero keeps the velocity continuous.
        const double lifted = level > 0.3 ? level : level > -0.3 ? (level + 0.3) * (level + 0.3) / 1.2 : 0;
        canvas.weights[i][pose[p].shape] +=
            static_cast<float>(share * std::min(1.1, scale * lifted * pose[p].weight));
      }
    }
  }
}

void poses(Canvas& canvas, const Regime& regime, Random& random) {
  // Each pose holds until the next has been reached, so shapes pass from one to the other.
  double t = regime.begin_s();
  double move_s = std::max(0.08, regime.slowness * log_uniform(0.1, 1.0, random));
  while (t < regime.end_s()) {
    const double hold_s = random.chance(0.3) ? 0 : regime.slowness * log_uniform(0.1, 2.0, random);
    const double next_move_s = std::max(0.08, regime.slowness * log_uniform(0.1, 1.0, random));
    const auto parts = 1 + random.below(3);
    for (std::uint64_t i = 0; i < parts; ++i)
      add_loose(canvas, random.chance(0.5) ? regime.pick(random) : draw_combination(random),
                {t, move_s, hold_s, next_move_s}, regime.strength * draw_peak(random), 0.4, random);
    t += move_s + hold_s;
    move_s = next_move_s;
  }
}

void chatter(Canvas& canvas, const Regime& regime, Random& random) {
  const double rate_hz = random.uniform(2.5, 7.0);
  const double jaw = regime.strength * random.uniform(0.15, 0.6);
  std::vector<Pose> sounds(4 + random.below(6));
  for (Pose& pose : sounds) {
    const auto count = 1 + random.below(4);
    for (std::uint64_t i = 0; i < count; ++i) {
      const std::size_t k = draw_shape(4 + random.below(2), random);
      const double loading = random.uniform(0.1, 0.8);
      add_part(pose, k, loading);
      if (other_side(k) != k) add_part(pose, other_side(k), loading * random.log_normal(0.1));
    }
  }
  double t = regime.begin_s();
  while (t < regime.end_s()) {
    const double syllable_s = std::clamp(random.log_normal(0.25), 0.6, 1.8) / rate_hz;
    const double rise_s = std::max(0.07, 0.55 * syllable_s);
    const double fall_s = std::max(0.07, 0.7 * syllable_s);
    const double opening = jaw * random.uniform(0.2, 1.2);
    const Envelope open{t, rise_s, 0, fall_s};
    canvas.add(shape("jawOpen"), open, opening);
    if (random.chance(0.25)) canvas.add(shape("mouthClose"), open, opening * random.uniform(0.3, 1.0));
    const Pose& sound = sounds[random.below(sounds.size())];
    const double late_s = random.uniform(0, 0.4) * syllable_s;
    canvas.add(sound, {t + late_s, rise_s, 0, fall_s}, regime.strength * random.uniform(0.2, 0.9));
    t += syllable_s;
    if (random.chance(0.08)) t += random.uniform(0.2, 1.2);
  }
}

/// Offsets that come and stay: a face that rests elsewhere for a while.
void drifts(Canvas& canvas, Random& random) {
  const double strength = random.uniform(0, 1);
  double t = -random.uniform(0, 5);
  while (t < canvas.duration_s()) {
    const double move_s = random.uniform(0.4, 3);
    const double hold_s = random.uniform(1, 15);
    canvas.add(draw_combination(random), {t, move_s, hold_s, move_s}, strength * random.uniform(0.02, 0.35));
    t += random.exponential(5);
  }
}

}  // namespace

void perform_free(Canvas& canvas, Random random) {
  drifts(canvas, random);
  std::size_t begin = 0;
  while (begin < canvas.frame_count()) {
    const auto length = static_cast<std::size_t>(random.uniform(3, 12) * kFrameRateHz);
    Regime regime{begin,
                  std::min(canvas.frame_count(), begin + length),
                  std::clamp(0.9 * random.log_normal(0.35), 0.3, 1.5),
                  std::clamp(random.log_normal(0.5), 0.4, 3.0),
                  {}};
    regime.combinations.resize(3 + random.below(8));
    for (Pose& pose : regime.combinations) pose = draw_combination(random);
    const double kind = random.uniform();
    if (kind < 0.35) {
      bumps(canvas, regime, random);
    } else if (kind < 0.60) {
      processes(canvas, regime, random);
    } else if (kind < 0.85) {
      poses(canvas, regime, random);
    } else {
      chatter(canvas, regime, random);
    }
    // Layers of two kinds at once.
    if (random.chance(0.25)) {
      regime.strength *= 0.6;
      bumps(canvas, regime, random);
    }
    if (random.chance(0.15)) begin += static_cast<std::size_t>(random.uniform(0.3, 2) * kFrameRateHz);
    begin += length;
  }
}

}  // namespace mien::performer
