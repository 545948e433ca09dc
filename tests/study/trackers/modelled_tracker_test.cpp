#include "mien/study/trackers/modelled_tracker.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>

#include "mien/performer/head_motion.h"
#include "mien/study/trackers/trackers_study.h"
#include "tests/performer/talking.h"

namespace mien::study::modelled_tracker_test {
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
    const ModelledTracker& tracker = modelled_tracker(kind);
    const TrackerCurves curves = filmed(kind, scene);
    EXPECT_EQ(curves.told, tracker.told);
    EXPECT_NEAR(curves.period_s(), 1 / tracker.rate_hz, 1e-9);
    double error = 0, count = 0;
    for (std::size_t i = 0; i < curves.rows.size(); ++i) {
      if (i > 0) {
        EXPECT_GT(curves.rows[i].time_s, curves.rows[i - 1].time_s);
      }
      if (!curves.rows[i].weights) continue;
      const face::BlendshapeWeights truth = curve.at(curves.rows[i].time_s).weights;
      for (std::size_t k = 0; k < face::kShapeCount; ++k) {
        const float weight = (*curves.rows[i].weights)[k];
        ASSERT_TRUE(weight >= 0 && weight <= 1) << weight;
        if (!curves.told[k]) {
          EXPECT_EQ(weight, 0);
        }
        if (k == face::shape("jawOpen")) error += std::abs(double{weight} - double{truth[k]});
      }
      ++count;
    }
    EXPECT_LT(error / count, 0.3) << tracker.name << ": it is late and noisy, but it tells the jaw";
    EXPECT_LT(gaps(curves), 0.5) << tracker.name;
  }
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
}  // namespace mien::study::modelled_tracker_test
