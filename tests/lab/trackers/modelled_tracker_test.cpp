#include "lab/trackers/modelled_tracker.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>

#include "lab/trackers/openseeface_log.h"
#include "lab/trackers/trackers_study.h"
#include "mien/core/units.h"
#include "mien/performer/head_motion.h"
#include "tests/performer/talking.h"

namespace mien::lab::modelled_tracker_test {
namespace {

face::Motion still_head(int frames) {
  face::Motion motion = performer::test::talking(frames, false);
  motion.has_head = true;
  return motion;
}

double gaps(const TrackerCurves& curves) {
  const auto lost = std::ranges::count_if(curves.rows, [](const TrackerRow& row) { return !row.weights; });
  return static_cast<double>(lost) / static_cast<double>(curves.rows.size());
}

TrackerCurves filmed(TrackerKind kind, const TrackerScene& scene, std::uint64_t seed = 1) {
  return model_tracker(modelled_tracker(kind), scene, Random(seed));
}

constexpr std::size_t kJaw = face::shape("jawOpen");

/// A tracker without any error or smoothing, 60 frames a second.
ModelledTracker perfect() {
  ModelledTracker out{.name = "perfect", .told = ToldShapes().set()};
  out.turned_worse_deg = out.blur_worse_deg = 80;
  return out;
}

/// Five seconds of a face that is the same throughout, all shapes at this weight.
face::Motion still_face(float weight) {
  face::Motion motion = still_head(300);
  for (face::MotionFrame& frame : motion.frames) frame.weights.values.fill(weight);
  return motion;
}

/// Mean and root mean square of some numbers.
struct Spread {
  double count = 0, sum = 0, squares = 0;

  void add(double value) {
    ++count;
    sum += value;
    squares += value * value;
  }
  [[nodiscard]] double mean() const { return sum / count; }
  [[nodiscard]] double rms() const { return std::sqrt(squares / count); }
  [[nodiscard]] double deviation() const { return std::sqrt(squares / count - mean() * mean()); }
};

/// How the jaw that is told agrees with that of so long before.
struct JawAgreement {
  double late_s = 0;
  double correlation = -1;
  double share = 0;  ///< Of the truth's standard deviation.
};

/// The best of 0 to 200 ms, 5 ms apart.
JawAgreement jaw_agreement(const TrackerCurves& curves, const face::MotionCurve& truth) {
  JawAgreement best;
  for (int step = 0; step <= 40; ++step) {
    const double late_s = 5e-3 * step;
    Spread told, true_jaw, both;
    for (const TrackerRow& row : curves.rows) {
      if (!row.weights) continue;
      const double a = double{truth.at(row.time_s - late_s).weights[kJaw]}, b = double{(*row.weights)[kJaw]};
      true_jaw.add(a);
      told.add(b);
      both.add(a + b);
    }
    const double a = true_jaw.deviation(), b = told.deviation(), sum = both.deviation();
    const double correlation = a > 0 && b > 0 ? 0.5 * (sum * sum - a * a - b * b) / (a * b) : -1;
    if (correlation > best.correlation) best = {late_s, correlation, b / a};
  }
  return best;
}

constexpr std::array kKinds = {TrackerKind::truedepth_phone, TrackerKind::mediapipe_webcam,
                               TrackerKind::openseeface_webcam};

TEST(ModelledTrackers, SayWhereEachNumberComesFrom) {
  ASSERT_EQ(modelled_trackers().size(), kTrackerKindCount);
  for (const ModelledTracker& tracker : modelled_trackers()) {
    std::set<std::string> names;
    bool some_assumed = false, some_published = false;
    for (const ModelledNumber& number : tracker.numbers) {
      EXPECT_FALSE(number.value.empty()) << number.what;
      EXPECT_FALSE(number.source.empty()) << number.what;
      EXPECT_TRUE(names.insert(number.what).second) << number.what << " twice";
      some_assumed = some_assumed || number.assumed();
      some_published = some_published || !number.assumed();
    }
    EXPECT_TRUE(some_assumed && some_published) << tracker.name;
    EXPECT_GT(names.size(), 18U) << tracker.name;
    EXPECT_EQ(&modelled_tracker(tracker.kind), &tracker);
  }
}

TEST(ModelledTracker, TellsTheFaceAtItsOwnRate) {
  const face::Motion motion = still_head(600);
  const face::MotionCurve curve(motion);
  const TrackerScene scene{.motion = &motion, .hands = {}};
  for (const TrackerKind kind : kKinds) {
    ModelledTracker tracker = modelled_tracker(kind);
    tracker.losses_per_hour = 0;  // All others have a reason, and there is none here.
    const TrackerCurves curves = model_tracker(tracker, scene, Random(1));
    EXPECT_EQ(curves.told, tracker.told);
    EXPECT_NEAR(curves.period_s(), 1 / tracker.rate_hz, 1e-9);
    EXPECT_EQ(gaps(curves), 0) << tracker.name;
    const auto rows = static_cast<double>(curves.rows.size());
    EXPECT_NEAR(rows / (motion.duration_s() * tracker.rate_hz), 1 - tracker.frames_dropped, 0.03);
    for (std::size_t i = 0; i < curves.rows.size(); ++i) {
      if (i > 0) {
        EXPECT_GT(curves.rows[i].time_s, curves.rows[i - 1].time_s);
      }
      for (std::size_t k = 0; k < face::kShapeCount; ++k) {
        const float weight = (*curves.rows[i].weights)[k];
        ASSERT_TRUE(weight >= 0 && weight <= 1) << weight;
        if (!curves.told[k]) {
          EXPECT_EQ(weight, 0);
        }
      }
    }
    // A jaw at 1.5 Hz, through the noise and, by MediaPipe's filter, bent. Of sixty draws the least
    // correlation was 0.955 and the least share 0.46; filters add up to 22 ms to the lag.
    const JawAgreement jaw = jaw_agreement(curves, curve);
    EXPECT_GT(jaw.correlation, 0.93) << tracker.name;
    EXPECT_GT(jaw.share, 0.4) << tracker.name;
    EXPECT_LT(jaw.share, 1.2) << tracker.name;
    EXPECT_GT(jaw.late_s, 1e-3 * tracker.lag_ms[0] - 0.006) << tracker.name;
    EXPECT_LT(jaw.late_s, 1e-3 * tracker.lag_ms[1] + 0.03) << tracker.name;
  }
}

TEST(ModelledTracker, IsLateByItsLag) {
  const face::Motion motion = still_head(300);
  const face::MotionCurve curve(motion);
  const TrackerScene scene{.motion = &motion, .hands = {}};
  for (const double lag_ms : {0.0, 50.0}) {
    ModelledTracker tracker = perfect();
    tracker.lag_ms = {lag_ms, lag_ms};
    const TrackerCurves curves = model_tracker(tracker, scene, Random(1));
    EXPECT_GE(curves.rows.size(), 299U);
    for (const TrackerRow& row : curves.rows) {
      ASSERT_TRUE(row.weights);
      EXPECT_NEAR((*row.weights)[kJaw], curve.at(row.time_s - 1e-3 * lag_ms).weights[kJaw], 1e-5);
    }
  }
  ModelledTracker drawn = perfect();
  drawn.lag_ms = {20, 100};
  std::set<double> lags;
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    const double late_s = jaw_agreement(model_tracker(drawn, scene, Random(seed)), curve).late_s;
    EXPECT_GT(late_s, 0.016);
    EXPECT_LT(late_s, 0.104);
    lags.insert(late_s);
  }
  EXPECT_GT(lags.size(), 3U) << "drawn anew for each";
}

TEST(ModelledTracker, HasAGainAndARestAShape) {
  const face::Motion half = still_face(0.5F), rest = still_face(0);
  const TrackerScene moved{.motion = &half, .hands = {}}, resting{.motion = &rest, .hands = {}};
  ModelledTracker gains = perfect(), offsets = perfect();
  gains.gain_error = 0.1;
  gains.hardly.set(kJaw);
  gains.hardly_gain = 0.05;
  offsets.resting_offset = 0.04;
  Spread gain, hardly, offset;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const TrackerCurves told = model_tracker(gains, moved, Random(seed));
    EXPECT_EQ(told.rows.front().weights, told.rows.back().weights) << "drawn once";
    const face::BlendshapeWeights at_rest = *model_tracker(offsets, resting, Random(seed)).rows[0].weights;
    for (std::size_t k = 0; k < face::kShapeCount; ++k) {
      (k == kJaw ? hardly : gain).add(double{(*told.rows.front().weights)[k]} / 0.5);
      if (face::kShapeNames[k].starts_with("eyeLook")) {
        EXPECT_EQ(at_rest[k], 0) << face::kShapeNames[k];
      } else {
        offset.add(double{at_rest[k]});
      }
    }
  }
  // Of 1040 draws, and 900: a standard deviation within 2.5 %.
  EXPECT_NEAR(gain.mean(), 1, 0.015);
  EXPECT_NEAR(gain.deviation(), 0.1, 0.01);
  EXPECT_NEAR(hardly.mean(), 0.05, 0.006);
  EXPECT_NEAR(offset.rms(), 0.04, 0.004);
}

TEST(ModelledTracker, IsNoisy) {
  const face::Motion half = still_face(0.5F);
  TrackerScene scene{.motion = &half, .hands = {}};
  ModelledTracker white = perfect(), slow = perfect();
  white.white_noise = slow.slow_noise = 0.02;
  white.dark_noise = 3;
  const auto noise_of = [&](const ModelledTracker& tracker, std::uint64_t seed, Spread& value, Spread& step) {
    const TrackerCurves told = model_tracker(tracker, scene, Random(seed));
    for (std::size_t i = 0; i < told.rows.size(); ++i)
      for (std::size_t k = 0; k < face::kShapeCount; ++k) {
        value.add(double{(*told.rows[i].weights)[k]} - 0.5);
        if (i > 0) step.add(double{(*told.rows[i].weights)[k]} - double{(*told.rows[i - 1].weights)[k]});
      }
  };
  // Of 16 000 numbers: within 1 %.
  Spread value, step;
  noise_of(white, 1, value, step);
  EXPECT_NEAR(value.rms(), 0.02, 0.001);
  EXPECT_NEAR(step.rms(), 0.02 * std::sqrt(2), 0.0015) << "anew each frame";
  // Five seconds of a noise that lasts for ten: of 53 shapes and 10 performers some 600 are independent.
  Spread slow_value, slow_step;
  for (std::uint64_t seed = 0; seed < 10; ++seed) noise_of(slow, seed, slow_value, slow_step);
  EXPECT_NEAR(slow_value.rms(), 0.02, 0.0025);
  EXPECT_NEAR(slow_step.rms(), 0.02 * std::sqrt(2 * (1 - std::exp(-1 / 600.0))), 5e-5) << "worth what it was";
  scene.dark = true;
  Spread dark, dark_step;
  noise_of(white, 1, dark, dark_step);
  EXPECT_NEAR(dark.rms(), 0.06, 0.003);
}

TEST(ModelledTracker, SmoothsAsItsKindDoes) {
  const face::Motion motion = still_head(600);
  const face::MotionCurve curve(motion);
  const TrackerScene scene{.motion = &motion, .hands = {}};
  // A Gaussian of 50 ms leaves exp(-2 (pi f sigma)^2) of a tone of 1.5 Hz, and does not shift it.
  ModelledTracker gaussian = perfect();
  gaussian.smoothing_ms = 50;
  const double left = std::exp(-2 * std::pow(std::numbers::pi * 1.5 * 0.05, 2));
  for (const TrackerRow& row : model_tracker(gaussian, scene, Random(1)).rows) {
    if (row.time_s < 0.2 || row.time_s > motion.duration_s() - 0.2) continue;
    const double tone = 0.5 - 0.5 * left * std::cos(2 * std::numbers::pi * 1.5 * row.time_s);
    EXPECT_NEAR((*row.weights)[kJaw], tone, 0.008) << row.time_s;
  }
  // A first-order low pass of 1 Hz at 60 frames a second leaves |a / (1 - (1 - a) exp(-i w))| of it.
  ModelledTracker filtered = perfect();
  filtered.one_euro = true;
  filtered.filter = {.min_cutoff_hz = 1, .beta = 0};
  Spread told;
  for (const TrackerRow& row : model_tracker(filtered, scene, Random(1)).rows)
    if (row.time_s > 1.9 && row.time_s < 9.9) told.add(double{(*row.weights)[kJaw]});  // Twelve periods.
  EXPECT_NEAR(told.deviation() * std::sqrt(2) / 0.5, 0.536, 0.01);

  // Half of the frame before: what is missing of a lid that has shut halves from frame to frame.
  face::Motion lid = still_face(0);
  for (face::MotionFrame& frame : lid.frames)
    if (frame.time_s > 2) frame.weights[face::shape("eyeBlink_L")] = 1;
  ModelledTracker half = perfect();
  half.kind = TrackerKind::openseeface_webcam;
  half.told = openseeface_told();
  half.previous_share = 0.5;
  const TrackerScene blinks{.motion = &lid, .hands = {}};
  double missing = -1;
  int halved = 0;
  for (const TrackerRow& row : model_tracker(half, blinks, Random(1)).rows) {
    const double now = 1 - double{(*row.weights)[face::shape("eyeBlink_L")]};
    if (row.time_s < 2) {
      EXPECT_NEAR(now, 1, 1e-6);
    }
    if (row.time_s < 2.02) continue;
    if (missing > 0) {
      EXPECT_NEAR(now, 0.5 * missing, 1e-6);
      ++halved;
    }
    missing = now;
  }
  EXPECT_GT(halved, 10);
}

TEST(ModelledTracker, IsTheSameOfTheSameStream) {
  const face::Motion motion = still_head(240);
  const TrackerScene scene{.motion = &motion, .hands = draw_hands(4, Random(3))};
  for (const TrackerKind kind : kKinds) {
    const TrackerCurves once = filmed(kind, scene), again = filmed(kind, scene),
                        other = filmed(kind, scene, 2);
    ASSERT_EQ(once.rows.size(), again.rows.size());
    for (std::size_t i = 0; i < once.rows.size(); ++i) EXPECT_EQ(once.rows[i].weights, again.rows[i].weights);
    EXPECT_NE(once.rows.front().time_s, other.rows.front().time_s);
  }
}

TEST(ModelledTracker, LosesAFaceThatTurnsAway) {
  const face::Motion motion = with_head_turned_away(still_head(3600), Random(5));
  const TrackerScene scene{.motion = &motion, .hands = {}};
  EXPECT_GT(gaps(filmed(TrackerKind::truedepth_phone, scene)), 0.1);
  EXPECT_GT(gaps(filmed(TrackerKind::truedepth_phone, scene)),
            gaps(filmed(TrackerKind::openseeface_webcam, scene)));
}

TEST(ModelledTracker, WebcamsNeedLight) {
  const face::Motion motion = still_head(1800);
  TrackerScene scene{.motion = &motion, .hands = {}};
  const double lit = gaps(filmed(TrackerKind::mediapipe_webcam, scene));
  const double phone_lit = gaps(filmed(TrackerKind::truedepth_phone, scene));
  scene.dark = true;
  EXPECT_GT(gaps(filmed(TrackerKind::mediapipe_webcam, scene)), lit + 0.05);
  EXPECT_NEAR(filmed(TrackerKind::mediapipe_webcam, scene).period_s(), 1.0 / 15, 1e-9);
  EXPECT_NEAR(gaps(filmed(TrackerKind::truedepth_phone, scene)), phone_lit, 1e-9)
      << "it brings its own light, or so we assume";
}

TEST(ModelledTracker, AHandLosesTheFaceOrMakesTheMouthUp) {
  face::Motion motion = still_head(600);
  for (face::MotionFrame& frame : motion.frames) frame.weights = {};
  const TrackerScene scene{.motion = &motion, .hands = {{2, 4}, {5, 7}, {8, 9.5}}};
  bool lost = false, wrong = false;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    const TrackerCurves curves = filmed(TrackerKind::mediapipe_webcam, scene, seed);
    double hidden = 0, bare = 0;
    for (const TrackerRow& row : curves.rows) {
      const bool behind = (row.time_s > 2.5 && row.time_s < 3.5) || (row.time_s > 5.5 && row.time_s < 6.5);
      if (behind && !row.weights) lost = true;
      if (!row.weights) continue;
      double& most = behind ? hidden : bare;
      if (behind || row.time_s < 1.5)
        most = std::max(most, double{(*row.weights)[face::shape("jawLeft")]} +
                                  double{(*row.weights)[face::shape("mouthPucker")]});
    }
    wrong = wrong || hidden > bare + 0.1;
  }
  EXPECT_TRUE(lost);
  EXPECT_TRUE(wrong);
}

TEST(Hands, ComeAndGoWithinThePerformance) {
  const std::vector<HandBefore> hands = draw_hands(30, Random(7));
  ASSERT_GT(hands.size(), 3U);
  for (std::size_t i = 0; i < hands.size(); ++i) {
    EXPECT_GT(hands[i].end_s, hands[i].begin_s);
    EXPECT_LE(hands[i].end_s, 30);
    if (i > 0) {
      EXPECT_GT(hands[i].begin_s, hands[i - 1].end_s);
    }
  }
  EXPECT_TRUE(draw_hands(1, Random(7)).empty());
}

TEST(Hands, ComeWithMouthfuls) {
  face::Motion motion = still_head(300);
  for (face::MotionFrame& frame : motion.frames) {
    frame.weights = {};
    if (frame.time_s > 2 && frame.time_s < 2.5) frame.weights[face::shape("jawOpen")] = 0.5F;
  }
  const std::vector<HandBefore> hands = eating_hands(motion);
  ASSERT_EQ(hands.size(), 1U);
  EXPECT_NEAR(hands[0].begin_s, 1.5, 0.05);
  EXPECT_NEAR(hands[0].end_s, 2.8, 0.05);
}

TEST(Hands, ComeWithSips) {
  const auto leaning = [](double about_x_rad) {
    face::Motion motion = still_face(0);
    for (face::MotionFrame& frame : motion.frames)
      if (frame.time_s > 2 && frame.time_s < 4) frame.head = exp_rotation(Vec3(about_x_rad, 0, 0));
    return eating_hands(motion);
  };
  const double back_rad = -12 * kRadPerDeg;
  ASSERT_GT((exp_rotation(Vec3(back_rad, 0, 0)) * Vec3::UnitZ()).y(), 0) << "the face looks up";
  const std::vector<HandBefore> hands = leaning(back_rad);
  ASSERT_EQ(hands.size(), 1U) << "the mouth is shut, but the cup is before it";
  EXPECT_NEAR(hands[0].begin_s, 2, 0.05) << "it comes with the head, not half a second before";
  EXPECT_NEAR(hands[0].end_s, 4.3, 0.05);
  EXPECT_TRUE(leaning(-back_rad).empty()) << "who looks down at the plate does not drink";
  EXPECT_TRUE(leaning(-3 * kRadPerDeg).empty()) << "nor who hardly leans back";
}

TEST(TurnedAwayHead, LooksAsideAndBack) {
  const face::Motion motion = with_head_turned_away(still_head(1800), Random(1));
  double aside = 0, most_deg = 0;
  for (const face::MotionFrame& frame : motion.frames) {
    const double turned_deg = 180 / std::numbers::pi * frame.head.angularDistance(Quat::Identity());
    most_deg = std::max(most_deg, turned_deg);
    aside += turned_deg > 40 ? 1 : 0;
  }
  EXPECT_GT(most_deg, 44);
  EXPECT_LT(most_deg, 81);
  EXPECT_NEAR(aside / static_cast<double>(motion.frames.size()), 0.5, 0.25);
  EXPECT_TRUE(motion.has_head);
}

}  // namespace
}  // namespace mien::lab::modelled_tracker_test
