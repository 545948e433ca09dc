#include "mien/performer/rapid.h"

#include <algorithm>
#include <array>

#include "mien/core/units.h"

namespace mien::performer {

using face::shape;

namespace {

constexpr double kShortestRiseS = 0.07;  // A blink's; nothing on a face is much faster.

/// From `begin_s`; each bout gives its end.
double laugh(Canvas& canvas, double begin_s, Random& random) {
  const auto notes = 4 + random.below(8);
  const double strength = random.uniform(0.5, 1);
  double now_s = begin_s;
  double loudness = strength;
  for (std::uint64_t n = 0; n < notes; ++n) {
    const double note_s = 0.21 * random.log_normal(0.1);
    const Envelope note{now_s, 0.09, 0, 0.12};
    canvas.add(shape("jawOpen"), note, 0.45 * loudness * random.uniform(0.6, 1.2));
    canvas.add(pose_of({{"mouthUpperUp", 0.5F}, {"mouthStretch", 0.3F}}), note, 0.5 * loudness);
    loudness *= random.uniform(0.85, 1.0);  // A laugh dies away.
    now_s += note_s;
  }
  const Envelope whole{begin_s - 0.1, 0.15, now_s - begin_s, 0.4};
  canvas.add(pose_of({{"mouthSmile", 1}, {"cheekSquint", 0.7F}, {"eyeSquint", 0.5F}, {"jawOpen", 0.15F}}),
             whole, strength);
  return now_s + 0.2;
}

double start(Canvas& canvas, double begin_s, Random& random) {
  const Envelope shock{begin_s, random.uniform(kShortestRiseS, 0.12), random.uniform(0.05, 0.5),
                       random.uniform(0.12, 0.35)};
  canvas.add(pose_of({{"browInnerUp", 0.9F}, {"browOuterUp", 1}, {"eyeWide", 0.8F}}), shock,
             random.uniform(0.5, 1));
  canvas.add(pose_of({{"jawOpen", 0.8F}, {"mouthStretch", 0.5F}, {"mouthLowerDown", 0.3F}}), shock,
             random.uniform(0.3, 1));
  const double back_rad = random.uniform(2, 6) * kRadPerDeg;
  for (std::size_t i = 0; i < canvas.frame_count(); ++i)
    canvas.head_rad[i].x() -= back_rad * shock.at(static_cast<double>(i) / kFrameRateHz);
  return shock.end_s();
}

/// Two poses in turn.
double alternate(Canvas& canvas, double begin_s, Random& random) {
  struct Pair {
    Pose one, other;
  };
  static const std::array kPairs = {
      Pair{pose_of({{"mouthLeft", 0.9F}}), pose_of({{"mouthRight", 0.9F}})},
      Pair{pose_of({{"jawLeft", 0.8F}}), pose_of({{"jawRight", 0.8F}})},
      Pair{pose_of({{"mouthPucker", 1}}), pose_of({{"mouthSmile", 1}})},
      Pair{pose_of({{"browInnerUp", 1}, {"browOuterUp", 0.9F}}), pose_of({{"browDown", 1}})},
      Pair{pose_of({{"cheekPuff_L", 0.9F}}), pose_of({{"cheekPuff_R", 0.9F}})},
      Pair{pose_of({{"noseSneer", 1}, {"mouthUpperUp", 0.5F}}), pose_of({{"mouthFrown", 0.8F}})},
      Pair{pose_of({{"jawOpen", 0.8F}}), pose_of({{"mouthPress", 0.8F}})},
      Pair{pose_of({{"mouthFunnel", 0.9F}, {"jawOpen", 0.3F}}), pose_of({{"mouthStretch", 0.9F}})},
  };
  const Pair& pair = kPairs[random.below(kPairs.size())];
  const double turn_s = 1 / random.uniform(2, 4.5);
  const double size = random.uniform(0.4, 1);
  const auto turns = 4 + random.below(6);
  double now_s = begin_s;
  for (std::uint64_t t = 0; t < turns; ++t) {
    const double rise_s = std::max(kShortestRiseS, 0.45 * turn_s);
    canvas.add(t % 2 == 0 ? pair.one : pair.other, {now_s, rise_s, 0.1 * turn_s, rise_s},
               size * random.log_normal(0.15));
    now_s += turn_s * random.log_normal(0.05);
  }
  return now_s;
}

double flutter(Canvas& canvas, double begin_s, Random& random) {
  const auto blinks = 3 + random.below(5);
  double now_s = begin_s;
  for (std::uint64_t b = 0; b < blinks; ++b) {
    canvas.add(pose_of({{"eyeBlink", 1}, {"eyeSquint", 0.15F}}), {now_s, 0.08, 0.02, 0.12},
               random.uniform(0.7, 1));
    now_s += random.uniform(0.22, 0.34);
  }
  return now_s;
}

/// "Papapa": lips meet and part, the jaw with them.
double patter(Canvas& canvas, double begin_s, Random& random) {
  const double syllable_s = 1 / random.uniform(5, 7);
  const auto syllables = 5 + random.below(10);
  const double opening = random.uniform(0.15, 0.4);
  double now_s = begin_s;
  for (std::uint64_t s = 0; s < syllables; ++s) {
    canvas.add(pose_of({{"jawOpen", 1}, {"mouthLowerDown", 0.4F}}),
               {now_s, kShortestRiseS, 0, std::max(kShortestRiseS, 0.6 * syllable_s)},
               opening * random.uniform(0.7, 1.2));
    const Envelope meeting{now_s + 0.72 * syllable_s, 0.05, 0.02, 0.05};
    for (std::size_t i = 0; i < canvas.frame_count(); ++i)
      canvas.lip_closure[i] = std::max(canvas.lip_closure[i],
                                       static_cast<float>(meeting.at(static_cast<double>(i) / kFrameRateHz)));
    now_s += syllable_s * random.log_normal(0.05);
  }
  return now_s;
}

}  // namespace

void perform_rapid(Canvas& canvas, Random random) {
  constexpr std::array kBouts = {laugh, start, start, alternate, alternate, alternate, flutter, patter};
  double now_s = random.uniform(0, 0.4);
  while (now_s < canvas.duration_s()) {
    now_s = kBouts[random.below(kBouts.size())](canvas, now_s, random);
    now_s += random.uniform(0.05, 0.6);
  }
}

}  // namespace mien::performer
