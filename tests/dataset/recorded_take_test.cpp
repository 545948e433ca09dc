#include "mien/dataset/recorded_take.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mien/solve/solve.h"
#include "mien/solve/trace_features.h"
#include "tests/dataset/written_take.h"

namespace mien::dataset::recorded_take_test {
namespace {

using test::Folder;
using test::WrittenTake;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Key;

class RecordedTakes : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { session_ = new virt::VirtualSession(test::talking_session(12)); }
  static void TearDownTestSuite() {
    delete session_;
    session_ = nullptr;
  }
  take::Take written(const WrittenTake& what) {
    const std::filesystem::path path = folder_ / "a.mien";
    test::write_take(path, *session_, what);
    return take::Take::open(path).value();
  }
  /// When the performer begins to be judged, s from the first frame.
  static double judged_from_s() {
    const auto first = std::ranges::find_if(session_->truth, &take::TruthFrame::evaluated);
    return to_seconds(first->time - session_->ticks.front().frame);
  }

  Folder folder_;
  static virt::VirtualSession* session_;
};
virt::VirtualSession* RecordedTakes::session_ = nullptr;

std::size_t frames_of(const RecordedTake& take) {
  std::size_t frames = 0;
  for (const CountedStretch& stretch : take.stretches) frames += stretch.sequence.frames;
  return frames;
}

TEST_F(RecordedTakes, OfAVirtualPerformerAllThatIsJudgedCounts) {
  const take::Take take = written({.performer = "virtual:7", .sound = std::vector<float>(16'000)});
  const auto read = read_recorded_take(take);
  ASSERT_TRUE(read) << read.error().message();
  const TakeOverview& overview = read->overview;
  EXPECT_EQ(overview.performer, "virtual:7");
  EXPECT_FALSE(overview.consent);
  EXPECT_FALSE(overview.sync);
  EXPECT_TRUE(overview.finished);
  EXPECT_EQ(overview.rig, "three");
  EXPECT_NEAR(overview.sound_s, 1, 1e-9);
  const auto judged = std::ranges::count_if(session_->truth, &take::TruthFrame::evaluated);
  EXPECT_EQ(frames_of(*read), static_cast<std::size_t>(judged));
  EXPECT_NEAR(overview.seconds.counted, static_cast<double>(judged) / 60, 1e-6);
  EXPECT_NEAR(overview.seconds.all(), static_cast<double>(session_->ticks.size()) / 60, 1e-6);
  // All of what is judged is one stretch: features and truth as they are, frame by frame.
  ASSERT_EQ(read->stretches.size(), 1u);
  const Sequence& sequence = read->stretches[0].sequence;
  EXPECT_FALSE(sequence.lab);
  EXPECT_TRUE(sequence.from_take);
  const std::vector<model::FeatureFrame> features = solve::take_features(take).value();
  std::size_t f = 0;
  for (std::size_t tick = 0; tick < features.size(); ++tick) {
    if (!session_->truth[tick].evaluated) continue;
    if (f == 0) {
      EXPECT_EQ(read->stretches[0].begin, features[tick].time);
    }
    for (std::size_t s = 0; s < 2; ++s) {
      const model::SensorFeature& feature = features[tick].sensors[s];
      const float* values = sequence.values.data() + 7 * (2 * f + s);
      for (int axis = 0; axis < 3; ++axis) ASSERT_EQ(values[axis], feature.accel_m_s2[axis]);
      ASSERT_TRUE(std::equal(feature.rotation.begin(), feature.rotation.end(), values + 3));
      ASSERT_EQ(sequence.present[4 * f + s] != 0, feature.has_rotation);
      ASSERT_EQ(sequence.present[4 * f + 2 + s] != 0, feature.has_accel);
    }
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      ASSERT_EQ(sequence.weights[face::kShapeCount * f + k],
                std::clamp(session_->truth[tick].weights[k], 0.0F, 1.0F));
    ++f;
  }
  // Both shapes that move go all the way; the others rest.
  EXPECT_GT(overview.ranges[face::shape("jawOpen")].high, 0.98F);
  EXPECT_LT(overview.ranges[face::shape("jawOpen")].low, 0.02F);
  EXPECT_EQ(overview.ranges[face::shape("noseSneer_L")].high, 0);
}

TEST_F(RecordedTakes, CountFromTheConsentOnAndWithoutPoorLines) {
  const double from_s = judged_from_s() + 1;
  WrittenTake what{.performer = "whoever", .consents = "Anna", .consent_s = from_s};
  const auto line = [&](double after_s, const std::string& json, double length_s = 2) {
    what.events.push_back(test::line_event(*session_, from_s + after_s, from_s + after_s + length_s, json));
  };
  line(-1, R"({"name": "before", "block": "calm"})");
  line(0, R"({"name": "one", "block": "calm", "emotion": "neutral", "language": "en"})", 1.5);
  line(2, R"({"name": "two", "block": "calm", "emotion": "joy", "poor": ["the face was lost"]})");
  line(4, R"({"name": "pose"})");
  line(6, R"({"name": "two", "block": "calm", "emotion": "joy", "attempt": 2})");
  line(8, R"({"name": "three", "block": "emotional", "poor": ["nothing moved"]})");
  const auto read = read_recorded_take(written(what));
  ASSERT_TRUE(read) << read.error().message();
  const TakeOverview& overview = read->overview;
  EXPECT_EQ(overview.performer, "Anna");
  ASSERT_TRUE(overview.consent);
  EXPECT_EQ(*overview.consent, test::consent_of_test("Anna"));
  EXPECT_EQ(overview.good_lines, 2u);
  EXPECT_EQ(overview.poor_lines, 1u);
  EXPECT_NEAR(overview.seconds.poor, 4, 0.05);
  EXPECT_THAT(overview.blocks, ElementsAre(Key("calm")));
  EXPECT_EQ(overview.blocks.at("calm").lines, 2u);
  EXPECT_NEAR(overview.blocks.at("calm").seconds, 3.5, 0.05);
  EXPECT_THAT(overview.emotions, ElementsAre(Key("joy"), Key("neutral")));
  EXPECT_NEAR(overview.emotions.at("joy").seconds, 2, 0.05);
  EXPECT_THAT(overview.languages, ElementsAre(Key("en")));
  // One stretch to the first poor line, one between the two; what is after the last is too short.
  ASSERT_EQ(read->stretches.size(), 2u);
  EXPECT_GE(read->stretches[0].begin, test::at_s(*session_, from_s));
  EXPECT_NEAR(to_seconds(read->stretches[0].begin - test::at_s(*session_, from_s)), 0, 0.02);
  EXPECT_NEAR(static_cast<double>(read->stretches[0].sequence.frames), 120, 2);
  EXPECT_NEAR(static_cast<double>(read->stretches[1].sequence.frames), 240, 2);
  EXPECT_GT(overview.seconds.brief, 0.5);
  ASSERT_EQ(read->lines.size(), 3u);
  EXPECT_EQ(read->lines[0].name, "one");
  // The line is over before the stretch is.
  const std::vector<std::int32_t>& shown = read->stretches[0].line;
  EXPECT_EQ(shown.front(), 0);
  EXPECT_EQ(shown.back(), -1);
  EXPECT_NEAR(static_cast<double>(std::ranges::count(shown, 0)), 90, 2);
  // The pose is no line, then the second attempt.
  EXPECT_EQ(read->stretches[1].line.front(), -1);
  EXPECT_EQ(read->stretches[1].line.back(), 1);
}

TEST_F(RecordedTakes, EndWhereTheFaceIsLost) {
  virt::VirtualSession session = *session_;
  const double from_s = judged_from_s();
  for (take::TruthFrame& truth : session.truth) {
    const double s = to_seconds(truth.time - session.ticks.front().frame) - from_s;
    if ((s >= 4 && s < 5) || (s >= 6 && s < 7)) truth.has_face = false;
  }
  test::write_take(folder_ / "lost.mien", session, {});
  const auto read = read_recorded_take(take::Take::open(folder_ / "lost.mien").value());
  ASSERT_TRUE(read) << read.error().message();
  // Between the two losses there is a second alone.
  ASSERT_EQ(read->stretches.size(), 2u);
  EXPECT_NEAR(read->overview.seconds.without_face, 2, 0.05);
  EXPECT_NEAR(read->overview.seconds.brief, 1, 0.05);
}

TEST_F(RecordedTakes, AreLeftOutForAReason) {
  const auto refused = [&](const WrittenTake& what, ErrorCode code) {
    const auto read = read_recorded_take(written(what));
    EXPECT_FALSE(read);
    if (read) return std::string();
    EXPECT_EQ(read.error().code, code) << read.error().message();
    return read.error().what;
  };
  EXPECT_THAT(refused({.performer = "somebody"}, ErrorCode::not_found), HasSubstr("nobody consented"));
  EXPECT_THAT(refused({.performer = "virtual:me"}, ErrorCode::not_found), HasSubstr("nobody consented"));
  EXPECT_THAT(refused({.own_truth = false}, ErrorCode::not_found), HasSubstr("without its truth"));
  EXPECT_THAT(refused({.consents = "Anna", .own_truth = false}, ErrorCode::not_found),
              HasSubstr("no phone was recorded"));
  EXPECT_THAT(refused({.consents = "Anna", .consent_s = 1000}, ErrorCode::not_found),
              HasSubstr("nothing in it counts"));
  // Glasses.
  const sensor::Rig glasses = sensor::read_rig(project_path("rigs/eyewear.toml")).value();
  take::Header header;
  header.performer = "virtual:1";
  header.rig_toml = sensor::write_rig(glasses);
  ASSERT_TRUE(take::TakeWriter::create(folder_ / "glasses.mien", header, true).value().finish());
  const auto identity = identify_take(take::Take::open(folder_ / "glasses.mien").value());
  ASSERT_FALSE(identity);
  EXPECT_EQ(identity.error().code, ErrorCode::unsupported);
}

/// A virtual phone before a wearer of the default rig.
struct Phoned {
  std::string rig_toml;
  sensor::Rig rig;
  virt::VirtualSession session;
};
Phoned phoned() {
  virt::StageRequest request;
  request.script = performer::default_script(performer::Block::reading, 40);
  request.rig = project_path("rigs/default.toml");
  request.seed = 5;
  request.phone = true;
  const virt::Stage stage = virt::set_stage(request).value();
  return {stage.rig_toml, stage.rig, virt::play(stage).value()};
}

TEST(RecordedTakeWithAPhone, HasTheTruthThatThePhoneTold) {
  const Phoned phone = phoned();
  const Folder folder;
  WrittenTake what{.performer = "", .rig_toml = phone.rig_toml, .consents = "Anna", .own_truth = false};
  test::write_take(folder / "a.mien", phone.session, what);
  const auto read = read_recorded_take(take::Take::open(folder / "a.mien").value());
  ASSERT_TRUE(read) << read.error().message();
  ASSERT_TRUE(read->overview.sync);
  EXPECT_GT(read->overview.sync->alignment.agreement, 0.5);
  EXPECT_GT(read->overview.seconds.counted, 30);
  EXPECT_GT(read->overview.seconds.before_calibration, 5);
  double sum = 0, count = 0;
  for (const CountedStretch& stretch : read->stretches) {
    const auto first = std::ranges::find(phone.session.truth, stretch.begin, &take::TruthFrame::time);
    ASSERT_NE(first, phone.session.truth.end());
    for (std::size_t f = 0; f < stretch.sequence.frames; ++f) {
      const take::TruthFrame& real = *(first + static_cast<std::ptrdiff_t>(f));
      if (!real.evaluated) continue;
      for (std::size_t k = 0; k < face::kShapeCount; ++k, ++count)
        sum += std::pow(double{stretch.sequence.weights[f * face::kShapeCount + k]} -
                            std::clamp(double{real.weights[k]}, 0.0, 1.0),
                        2);
    }
  }
  ASSERT_GT(count, 0);
  EXPECT_LT(std::sqrt(sum / count), 0.05);

  // One who saw nothing.
  Phoned blind = phone;
  const auto truth = std::ranges::find_if(blind.rig.sensors, &sensor::Mount::is_truth);
  std::erase_if(blind.session.samples, [&](const take::StoredSample& stored) {
    return stored.sample.sensor == truth - blind.rig.sensors.begin();
  });
  test::write_take(folder / "blind.mien", blind.session, what);
  const auto saw_nothing = read_recorded_take(take::Take::open(folder / "blind.mien").value());
  ASSERT_FALSE(saw_nothing);
  EXPECT_EQ(saw_nothing.error().code, ErrorCode::not_found);
  EXPECT_THAT(saw_nothing.error().what, HasSubstr("told nothing"));
}

TEST(WeightHistogram, GivesPercentilesOfAllThatWasAdded) {
  WeightHistogram first, second;
  EXPECT_EQ(first.ranges()[0], ShapeRange());
  face::BlendshapeWeights weights;
  for (int i = 1; i <= 1000; ++i) {
    weights[0] = static_cast<float>(i) / 1000;
    weights[1] = i <= 5 ? 7.0F : 0.25F;  // Beyond 1, and in fewer than a hundredth.
    (i % 2 == 0 ? first : second).add(weights);
  }
  first.add(second);
  EXPECT_EQ(first.frames(), 1000u);
  EXPECT_EQ(first.ranges()[0], (ShapeRange{0.01F, 0.99F}));
  EXPECT_EQ(first.ranges()[1], (ShapeRange{0.25F, 0.25F}));
}

TEST(CutSequence, IsThatPartOfEveryArray) {
  Sequence sequence;
  sequence.performer = 3;
  sequence.frames = 4;
  for (int i = 0; i < 4 * 7; ++i) sequence.values.push_back(static_cast<float>(i));
  for (int i = 0; i < 4 * 2; ++i) sequence.present.push_back(static_cast<std::uint8_t>(i));
  for (int i = 0; i < 4 * 53; ++i) sequence.weights.push_back(static_cast<float>(i));
  const Sequence part = cut_sequence(sequence, 1, 1, 2);
  EXPECT_EQ(part.performer, 3u);
  EXPECT_EQ(part.frames, 2u);
  ASSERT_EQ(part.values.size(), 14u);
  EXPECT_EQ(part.values.front(), 7);
  EXPECT_THAT(part.present, ElementsAre(2, 3, 4, 5));
  ASSERT_EQ(part.weights.size(), 106u);
  EXPECT_EQ(part.weights.front(), 53);
  EXPECT_EQ(part.weights.back(), 158);
}

}  // namespace
}  // namespace mien::dataset::recorded_take_test
