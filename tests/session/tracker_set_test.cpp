#include "mien/session/tracker_set.h"

#include <gtest/gtest.h>

#include <map>

#include "mien/shaping/shaper.h"
#include "tests/shaping/frames.h"

namespace mien::session::tracker_set_test {
namespace {

using face::OutputFrame;
using face::Provenance;
using shaping::frame_time;
using shaping::measured;
using shaping::Merge;
using shaping::MergePlace;
using shaping::same_bits;
using shaping::ShaperSettings;
using tracker::CalibrationState;
using tracker::Step;
using Phase = CalibrationState::Phase;

/// A tracker whose answers are set, and that remembers what it was called with.
class Puppet final : public tracker::Tracker {
 public:
  explicit Puppet(std::string name) : name_(std::move(name)) {}

  // What it is to answer.
  float weight = 0;
  float confidence = 0.9F;
  std::size_t there = 4;
  std::optional<tracker::Explained> explained;
  CalibrationState state{.phase = Phase::done, .step = Step::none, .hint = {}};
  tracker::Guidance wants;
  std::string made = "{}";
  std::vector<tracker::CalibrationEvent> events;  // Of the next tick.
  std::vector<sensor::Score> judged;
  DeviceTime ticked;  // Time of the last tick.
  Duration rest_wanted{};
  std::optional<tracker::RestOutcome> rested;  // Of the next tick.
  std::uint64_t defects = 0;
  // What it heard.
  std::vector<std::uint16_t> samples, forgotten;
  std::vector<Step> guided;
  DeviceTime range_end;
  int cancelled = 0;
  DeviceTime rest_end;
  std::string restored;

  [[nodiscard]] std::string_view modality() const override { return name_; }
  void add(HostTime, const sensor::Sample& sample) override { samples.push_back(sample.sensor); }
  void forget(std::uint16_t sensor) override { forgotten.push_back(sensor); }
  tracker::TickResult tick(DeviceTime frame, const sensor::TimeLines&, OutputFrame& out) override {
    out = measured(0, weight);
    out.time = frame;
    out.confidence.fill(confidence);
    if (made.empty()) out.provenance.fill(Provenance::neutral);
    ticked = frame;
    if (name_ == Merge::kListening) out.provenance.fill(Provenance::audio);
    tracker::TickResult result{
        .sensors_present = there, .calibration = std::exchange(events, {}), .explained = explained};
    result.rested = std::exchange(rested, std::nullopt);
    if (name_ == Merge::kListening) result.hearing = tracker::TickResult::Hearing{.speaks = true};
    return result;
  }
  [[nodiscard]] tracker::Guidance guidance() const override { return wants; }
  void guide(Step step, DeviceTime, DeviceTime) override { guided.push_back(step); }
  void guide_range(DeviceTime, DeviceTime end) override { range_end = end; }
  void guide_expression(const tracker::PromptedExpression& asked) override { expression = asked.name; }
  std::string expression;
  void guide_gaze(const face::GazeTarget& target, DeviceTime, DeviceTime) override { looks = target.name; }
  std::string looks;
  void cancel_guidance() override { ++cancelled; }
  [[nodiscard]] CalibrationState calibration_state() const override { return state; }
  [[nodiscard]] std::string calibration() const override { return made; }
  [[nodiscard]] std::vector<sensor::Score> scores() const override { return judged; }
  [[nodiscard]] Result<void> restore(std::string_view json) override {
    if (json.find("bad") != std::string_view::npos)
      return fail(ErrorCode::mismatch, "another rig's", "puppet " + name_);
    made = restored = std::string(json);
    return {};
  }
  [[nodiscard]] std::optional<double> heading_sigma_rad(std::uint16_t sensor) const override {
    return sensor + 0.5;
  }
  [[nodiscard]] Duration wants_rest() const override { return rest_wanted; }
  void rest(DeviceTime, DeviceTime end) override { rest_end = end; }
  [[nodiscard]] std::optional<tracker::SensorCertainty> certainty(std::uint16_t sensor) const override {
    return tracker::SensorCertainty{.sigma_rad = sensor + 0.25};
  }
  [[nodiscard]] std::uint64_t faults() const override { return defects; }

 private:
  std::string name_;
};

/// A rig of sensors of these kinds.
sensor::Rig rig_of(const std::vector<std::string>& kinds) {
  sensor::Rig rig;
  for (const std::string& kind : kinds)
    rig.sensors.push_back({.name = "s" + std::to_string(rig.sensors.size()), .kind = kind, .role = "face"});
  return rig;
}

/// The trackers of a rig, merged as a session merges them.
class Stage {
 public:
  explicit Stage(const std::vector<std::string>& kinds = {"imu", "imu", "eyewear", "eyewear", "imu"},
                 const ShaperSettings& settings = {})
      : set(rig_of(kinds), make(kinds)), shaper(settings, set.modalities()), lines(kinds.size(), 0) {}
  void receive(std::uint16_t sensor, double at_s) {
    sensor::Sample sample;
    sample.sensor = sensor;
    set.add(HostTime(from_seconds(at_s)), sample, {});
  }
  /// What a session does at a tick; returns the merged number of sensors.
  std::size_t tick(int frame, OutputFrame& out) {
    answer = set.tick(frame_time(frame), lines);
    const std::size_t present = shaper.apply(set.sources(), out);
    set.follow_lag(answer.hearing ? answer.hearing->behind : Duration(), shaper.settings().merge.sure);
    return present;
  }

 private:
  std::vector<std::unique_ptr<tracker::Tracker>> make(const std::vector<std::string>& kinds) {
    std::vector<std::unique_ptr<tracker::Tracker>> all;
    for (const std::string& kind : kinds) {
      if (puppets.contains(kind)) continue;
      auto one = std::make_unique<Puppet>(kind);
      puppets[kind] = one.get();
      all.push_back(std::move(one));
    }
    imu = puppets["imu"];
    eyewear = puppets["eyewear"];
    return all;
  }

 public:
  std::map<std::string, Puppet*> puppets;
  Puppet* imu = nullptr;
  Puppet* eyewear = nullptr;
  TrackerSet set;
  shaping::Shaper shaper;
  sensor::TimeLines lines;
  TrackerSet::Answer answer;  // Of the last tick.
};

TEST(TrackerSet, SoundIsAskedForWhenItBelongsToTheFace) {
  Stage stage({"imu", "speech"});
  Puppet *const imu = stage.imu, *const speech = stage.puppets["speech"];
  tracker::Explained explained;
  explained.fill(0.9F);
  imu->explained = explained;
  // A jaw that the microphone brings a tenth of a second late.
  Random random(1);
  std::vector<float> jaw;
  for (int i = 0; i < 4000; ++i)
    jaw.push_back(i % 12 == 0 || jaw.empty() ? static_cast<float>(random.uniform(0, 0.8)) : jaw.back());
  for (int i = 100; i < 4000; ++i) {
    const auto at = [&](Duration offset) {
      return jaw[static_cast<std::size_t>(i + std::lround(to_seconds(offset) * kFrameRateHz))];
    };
    const auto& hearing = stage.answer.hearing;
    imu->weight = at({});
    speech->weight = at((hearing ? hearing->later : Duration()) - std::chrono::milliseconds(100));
    OutputFrame out;
    stage.tick(i, out);
    ASSERT_EQ(out.time, frame_time(i));
    ASSERT_TRUE(hearing);
    ASSERT_LE(speech->ticked - frame_time(i), std::chrono::milliseconds(110));
  }
  EXPECT_TRUE(stage.answer.hearing->speaks);
  EXPECT_NEAR(to_seconds(stage.answer.hearing->later), 0.1, 0.02);
  EXPECT_NEAR(to_seconds(speech->ticked - frame_time(3999)), 0.1, 0.02);
  EXPECT_EQ(imu->ticked, frame_time(3999));
}

TEST(TrackerSet, EveryTrackerGetsTheSamplesOfItsOwnSensors) {
  Stage stage;
  EXPECT_EQ(stage.set.modality(), "imu+eyewear");
  for (const std::uint16_t sensor : {0, 2, 4, 9}) stage.receive(sensor, 1);
  stage.set.forget(3);
  EXPECT_EQ(stage.imu->samples, (std::vector<std::uint16_t>{0, 4}));
  EXPECT_EQ(stage.eyewear->samples, (std::vector<std::uint16_t>{2})) << "the ninth is nobody's";
  for (const Puppet* one : {stage.imu, stage.eyewear})
    EXPECT_EQ(one->forgotten, (std::vector<std::uint16_t>{3}));
}

TEST(TrackerSet, AHeadingIsAskedOfWhoOwnsTheSensor) {
  Stage stage;
  EXPECT_EQ(stage.set.heading_sigma_rad(4), 4.5);
  EXPECT_EQ(stage.set.heading_sigma_rad(3), 3.5);
  EXPECT_EQ(stage.set.heading_sigma_rad(5), std::nullopt) << "nobody's";
}

TEST(TrackerSet, ARestIsForAllThatAreThereAndTheLongestIsAskedFor) {
  Stage stage;
  EXPECT_EQ(stage.set.wants_rest(), Duration::zero());
  stage.imu->rest_wanted = std::chrono::seconds(2);
  EXPECT_EQ(stage.set.wants_rest(), std::chrono::seconds(2));
  // Sensors that are on the table ask for none.
  stage.receive(0, 1);
  stage.receive(2, 9);
  EXPECT_EQ(stage.set.wants_rest(), Duration::zero());
  stage.receive(0, 9);
  EXPECT_EQ(stage.set.wants_rest(), std::chrono::seconds(2));
  const DeviceTime end = frame_time(120);
  stage.set.rest(frame_time(0), end);
  EXPECT_EQ(stage.imu->rest_end, end);
  EXPECT_EQ(stage.eyewear->rest_end, end);

  EXPECT_FALSE(stage.set.tick(frame_time(0), stage.lines).rested);
  stage.imu->rested = tracker::RestOutcome{.corrected = {0}, .moved = {4}, .absent = {1}};
  stage.eyewear->rested = tracker::RestOutcome{.corrected = {2}, .moved = {}, .absent = {}};
  const auto rested = stage.set.tick(frame_time(1), stage.lines).rested;
  ASSERT_TRUE(rested);
  EXPECT_EQ(rested->corrected, (std::vector<std::uint16_t>{0, 2}));
  EXPECT_EQ(rested->moved, (std::vector<std::uint16_t>{4}));
  EXPECT_EQ(rested->absent, (std::vector<std::uint16_t>{1}));
}

TEST(TrackerSet, CertaintyIsTheOwnersAndFaultsAreAllTrackers) {
  Stage stage;
  ASSERT_TRUE(stage.set.certainty(3));
  EXPECT_EQ(stage.set.certainty(3)->sigma_rad, 3.25);
  EXPECT_FALSE(stage.set.certainty(5));
  stage.imu->defects = 2;
  stage.eyewear->defects = 1;
  EXPECT_EQ(stage.set.faults(), 3U);
}

TEST(TrackerSet, MergesWhatItsTrackersAnswer) {
  Stage stage;
  stage.imu->weight = 0.25F;
  stage.eyewear->weight = 0.75F;
  OutputFrame out;
  EXPECT_EQ(stage.tick(0, out), 8u);
  EXPECT_EQ(out.time, frame_time(0));
  EXPECT_EQ(out.weights[face::shape("jawOpen")], 0.25F);
  EXPECT_EQ(out.weights[face::shape("browDown_L")], 0.75F);
  stage.imu->there = 0;
  EXPECT_EQ(stage.tick(1, out), 4u);
  for (int i = 2; i < 70; ++i) stage.tick(i, out);
  EXPECT_EQ(out.weights[face::shape("jawOpen")], 0.75F);
}

TEST(TrackerSet, TrackersAreComparedByWhatTheyExplain) {
  Stage stage;
  stage.imu->weight = 0.25F;
  stage.eyewear->weight = 0.75F;
  stage.eyewear->explained.emplace().fill(0.1F);
  OutputFrame out;
  stage.tick(0, out);
  EXPECT_EQ(out.weights[face::shape("browDown_L")], 0.25F)
      << "the other one's confidence stands for its share";
  stage.eyewear->explained->fill(0.6F);
  for (int i = 1; i < 70; ++i) stage.tick(i, out);
  EXPECT_EQ(out.weights[face::shape("browDown_L")], 0.75F);
}

TEST(TrackerSet, ALoneTrackerIsThatTracker) {
  ShaperSettings unshaped;
  unshaped.off.set();
  Stage stage({"imu"}, unshaped);
  EXPECT_EQ(stage.set.modality(), "imu");
  stage.imu->made = "its own words";
  EXPECT_EQ(stage.set.calibration(), "its own words");
  for (int i = 0; i < 20; ++i) {
    stage.imu->weight = static_cast<float>(i) / 20;
    stage.imu->there = static_cast<std::size_t>(1 + i % 3);
    OutputFrame out, plain;
    EXPECT_EQ(stage.tick(i, out), stage.imu->there);
    stage.imu->tick(frame_time(i), stage.lines, plain);
    ASSERT_EQ(out.weights, plain.weights);
  }
}

TEST(TrackerSet, WithoutTrackersNothingIsCalibratedAndNothingIsAsked) {
  Stage none(std::vector<std::string>{});
  EXPECT_TRUE(none.set.empty());
  EXPECT_EQ(none.set.modality(), "");
  EXPECT_EQ(none.set.calibration(), "");
  EXPECT_EQ(none.set.features(), nullptr);
  EXPECT_FALSE(none.set.guidance().gestures);
  EXPECT_EQ(none.set.correct({}).error().code, ErrorCode::unsupported);
}

TEST(TrackerSet, SettingsTakeEffectAtTheNextFrame) {
  ShaperSettings settings;
  settings.merge.order[static_cast<std::size_t>(MergePlace::jaw)] = {"eyewear"};
  Stage stage({"imu", "eyewear"}, settings);
  stage.imu->weight = 0.25F;
  stage.eyewear->weight = 0.75F;
  OutputFrame out;
  stage.tick(0, out);
  EXPECT_EQ(out.weights[face::shape("jawOpen")], 0.75F);
  stage.shaper.set(ShaperSettings());
  for (int i = 1; i < 70; ++i) {
    const float before = out.weights[face::shape("jawOpen")];
    stage.tick(i, out);
    ASSERT_LE(std::abs(out.weights[face::shape("jawOpen")] - before), 0.05F) << "eased";
  }
  EXPECT_EQ(out.weights[face::shape("jawOpen")], 0.25F);
}

TEST(TrackerSet, CalibrationIsDoneWhenAllThatAreThereAreDone) {
  Stage stage;
  stage.eyewear->state = {.phase = Phase::watching, .step = Step::neutral, .hint = "hold still"};
  EXPECT_EQ(stage.set.calibration_state().phase, Phase::watching) << "none was heard: all count";
  stage.receive(0, 10);
  EXPECT_EQ(stage.set.calibration_state().phase, Phase::done) << "the glasses are not there";
  EXPECT_TRUE(stage.set.calibration_state().hint.empty());
  stage.receive(2, 11);
  const CalibrationState state = stage.set.calibration_state();
  EXPECT_EQ(state.phase, Phase::watching);
  EXPECT_EQ(state.step, Step::neutral);
  EXPECT_EQ(state.hint, "hold still");
  stage.imu->state.phase = Phase::guided;
  stage.imu->state.step = Step::nod;
  EXPECT_EQ(stage.set.calibration_state().phase, Phase::guided);
  EXPECT_EQ(stage.set.calibration_state().step, Step::nod);
  stage.imu->state = {.phase = Phase::done, .step = Step::none, .hint = {}};
  stage.receive(0, 14);  // The glasses were taken off.
  EXPECT_EQ(stage.set.calibration_state().phase, Phase::done);
}

TEST(TrackerSet, GuidesAllAsLongAsOneWants) {
  Stage stage;
  stage.eyewear->wants = {.neutral = std::chrono::seconds(5), .gestures = false};
  EXPECT_EQ(stage.set.guidance().neutral, std::chrono::seconds(5));
  EXPECT_TRUE(stage.set.guidance().gestures);
  stage.receive(3, 1);
  EXPECT_FALSE(stage.set.guidance().gestures) << "glasses alone need no nod";
  const DeviceTime begin = frame_time(0), end = frame_time(60);
  stage.set.guide(Step::neutral, begin, end);
  stage.set.guide(Step::nod, begin, end);
  stage.set.guide_range(begin, end);
  stage.set.guide_expression({.name = "smile", .begin = begin, .end = end, .target = {}});
  EXPECT_EQ(stage.eyewear->expression, "smile");
  EXPECT_FALSE(stage.set.guidance().learns_gaze);
  stage.eyewear->wants.learns_gaze = true;
  EXPECT_TRUE(stage.set.guidance().learns_gaze);
  stage.set.guide_gaze(face::gaze_targets()[1], begin, end);
  EXPECT_EQ(stage.eyewear->looks, "look left");
  stage.set.cancel_guidance();
  for (const Puppet* one : {stage.imu, stage.eyewear}) {
    EXPECT_EQ(one->guided, (std::vector<Step>{Step::neutral, Step::nod}));
    EXPECT_EQ(one->range_end, end);
    EXPECT_EQ(one->cancelled, 1);
  }
}

TEST(TrackerSet, ACalibrationHasAPartOfEachAndGoesBackToEach) {
  Stage stage;
  stage.imu->made = R"({"headings": [0.25, -1.5]})";
  stage.eyewear->made = "";
  EXPECT_EQ(stage.set.calibration(), R"({"imu":{"headings":[0.25,-1.5]}})");
  stage.eyewear->made = R"({"neutral": 1})";
  const std::string both = stage.set.calibration();
  EXPECT_EQ(both, R"({"eyewear":{"neutral":1},"imu":{"headings":[0.25,-1.5]}})");
  ASSERT_TRUE(stage.set.restore(both));
  EXPECT_EQ(stage.imu->restored, R"({"headings":[0.25,-1.5]})");
  EXPECT_EQ(stage.eyewear->restored, R"({"neutral":1})");
  EXPECT_EQ(stage.set.calibration(), both);
  stage.imu->restored.clear();
  ASSERT_TRUE(stage.set.restore(R"({"eyewear": {"neutral": 2}})"));
  EXPECT_EQ(stage.imu->restored, "") << "keeps what it has";

  stage.imu->made = stage.eyewear->made = "";
  EXPECT_EQ(stage.set.calibration(), "");
}

TEST(TrackerSet, ARestoreThatFailsLeavesAllAsItWas) {
  Stage stage;
  stage.imu->made = R"({"version": 1})";
  const std::string before = stage.set.calibration();
  EXPECT_EQ(stage.set.restore("").error().code, ErrorCode::malformed);
  EXPECT_EQ(stage.set.restore("{}").error().code, ErrorCode::malformed);
  EXPECT_EQ(stage.set.restore("[1]").error().code, ErrorCode::malformed);
  EXPECT_EQ(stage.set.restore(R"({"imu": {}, "speech": {}})").error().code, ErrorCode::mismatch);
  EXPECT_EQ(stage.set.restore(R"({"imu": {"version": 2}, "eyewear": "bad"})").error().code,
            ErrorCode::mismatch);
  EXPECT_TRUE(stage.set.tick(frame_time(0), stage.lines).calibration.empty());
  EXPECT_EQ(stage.set.calibration(), before);
}

TEST(TrackerSet, ScoresAndEventsAreThoseOfAll) {
  Stage stage;
  stage.imu->judged = {{.name = "nod", .value = 20, .unit = "deg", .pass = true, .sentence = "wide"}};
  stage.eyewear->judged = {{.name = "light", .value = 1, .unit = "", .pass = true, .sentence = "bright"}};
  stage.imu->events = {{.modality = "imu", .found = {{Step::nod, frame_time(1), frame_time(2)}}}};
  stage.eyewear->events = {{.modality = "eyewear", .found = {{Step::neutral, frame_time(0), frame_time(1)}}}};
  const std::vector<sensor::Score> scores = stage.set.scores();
  ASSERT_EQ(scores.size(), 2u);
  EXPECT_EQ(scores[0].name, "nod");
  EXPECT_EQ(scores[1].name, "light");
  const TrackerSet::Answer result = stage.set.tick(frame_time(2), stage.lines);
  ASSERT_EQ(result.calibration.size(), 2u);
  EXPECT_EQ(result.calibration[0].modality, "imu");
  ASSERT_EQ(result.calibration[1].found.size(), 1u);
  EXPECT_EQ(result.calibration[1].found[0].step, Step::neutral);
}

}  // namespace
}  // namespace mien::session::tracker_set_test
