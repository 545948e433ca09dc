#include "mien/shaping/combined_tracker.h"

#include <gtest/gtest.h>

#include "tests/shaping/frames.h"

namespace mien::shaping::combined_tracker_test {
namespace {

using face::OutputFrame;
using face::Provenance;
using tracker::CalibrationState;
using tracker::Step;
using Phase = CalibrationState::Phase;

/// A tracker that does as it is told, and remembers what it was told.
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

/// Sensors 0, 1 and 4 are IMUs, 2 and 3 the glasses'.
struct Stage {
  Puppet* imu;
  Puppet* eyewear;
  std::unique_ptr<CombinedTracker> both;
  sensor::TimeLines lines{5, 0};

  explicit Stage(const ShaperSettings& settings = {}) {
    auto first = std::make_unique<Puppet>("imu");
    auto second = std::make_unique<Puppet>("eyewear");
    imu = first.get();
    eyewear = second.get();
    std::vector<CombinedTracker::Part> parts;
    parts.push_back({std::move(first), {0, 1, 4}});
    parts.push_back({std::move(second), {2, 3}});
    both = std::make_unique<CombinedTracker>(std::move(parts), settings);
  }
  void receive(std::uint16_t sensor, double at_s) const {
    sensor::Sample sample;
    sample.sensor = sensor;
    both->add(HostTime(from_seconds(at_s)), sample);
  }
};

TEST(CombinedTracker, SoundIsAskedForWhenItBelongsToTheFace) {
  auto first = std::make_unique<Puppet>("imu");
  auto second = std::make_unique<Puppet>("speech");
  Puppet *const imu = first.get(), *const speech = second.get();
  tracker::Explained explained;
  explained.fill(0.9F);
  imu->explained = explained;
  std::vector<CombinedTracker::Part> parts;
  parts.push_back({std::move(first), {0}});
  parts.push_back({std::move(second), {1}});
  CombinedTracker both(std::move(parts));
  const sensor::TimeLines lines{2, 0};
  // A jaw that the microphone brings a tenth of a second late.
  Random random(1);
  std::vector<float> jaw;
  for (int i = 0; i < 4000; ++i)
    jaw.push_back(i % 12 == 0 || jaw.empty() ? static_cast<float>(random.uniform(0, 0.8)) : jaw.back());
  tracker::TickResult result;
  for (int i = 100; i < 4000; ++i) {
    const auto at = [&](Duration offset) {
      return jaw[static_cast<std::size_t>(i + std::lround(to_seconds(offset) * kFrameRateHz))];
    };
    imu->weight = at({});
    speech->weight =
        at((result.hearing ? result.hearing->later : Duration()) - std::chrono::milliseconds(100));
    OutputFrame out;
    result = both.tick(frame_time(i), lines, out);
    ASSERT_EQ(out.time, frame_time(i));
    ASSERT_TRUE(result.hearing);
    ASSERT_LE(speech->ticked - frame_time(i), std::chrono::milliseconds(110));
  }
  EXPECT_TRUE(result.hearing->speaks);
  EXPECT_NEAR(to_seconds(result.hearing->later), 0.1, 0.02);
  EXPECT_NEAR(to_seconds(speech->ticked - frame_time(3999)), 0.1, 0.02);
  EXPECT_EQ(imu->ticked, frame_time(3999));
}

TEST(CombinedTracker, EveryTrackerGetsTheSamplesOfItsOwnSensors) {
  const Stage stage;
  EXPECT_EQ(stage.both->modality(), "imu+eyewear");
  for (const std::uint16_t sensor : {0, 2, 4, 9}) stage.receive(sensor, 1);
  stage.both->forget(3);
  EXPECT_EQ(stage.imu->samples, (std::vector<std::uint16_t>{0, 4}));
  EXPECT_EQ(stage.eyewear->samples, (std::vector<std::uint16_t>{2})) << "the ninth is nobody's";
  for (const Puppet* one : {stage.imu, stage.eyewear})
    EXPECT_EQ(one->forgotten, (std::vector<std::uint16_t>{3}));
}

TEST(CombinedTracker, AHeadingIsAskedOfWhoOwnsTheSensor) {
  const Stage stage;
  EXPECT_EQ(stage.both->heading_sigma_rad(4), 4.5);
  EXPECT_EQ(stage.both->heading_sigma_rad(3), 3.5);
  EXPECT_EQ(stage.both->heading_sigma_rad(5), std::nullopt) << "nobody's";
}

TEST(CombinedTracker, ARestIsForAllThatAreThereAndTheLongestIsAskedFor) {
  const Stage stage;
  EXPECT_EQ(stage.both->wants_rest(), Duration::zero());
  stage.imu->rest_wanted = std::chrono::seconds(2);
  EXPECT_EQ(stage.both->wants_rest(), std::chrono::seconds(2));
  // Sensors that are on the table ask for none.
  stage.receive(0, 1);
  stage.receive(2, 9);
  EXPECT_EQ(stage.both->wants_rest(), Duration::zero());
  stage.receive(0, 9);
  EXPECT_EQ(stage.both->wants_rest(), std::chrono::seconds(2));
  const DeviceTime end = frame_time(120);
  stage.both->rest(frame_time(0), end);
  EXPECT_EQ(stage.imu->rest_end, end);
  EXPECT_EQ(stage.eyewear->rest_end, end);

  OutputFrame out;
  EXPECT_FALSE(stage.both->tick(frame_time(0), stage.lines, out).rested);
  stage.imu->rested = tracker::RestOutcome{.corrected = {0}, .moved = {4}, .absent = {1}};
  stage.eyewear->rested = tracker::RestOutcome{.corrected = {2}, .moved = {}, .absent = {}};
  const auto rested = stage.both->tick(frame_time(1), stage.lines, out).rested;
  ASSERT_TRUE(rested);
  EXPECT_EQ(rested->corrected, (std::vector<std::uint16_t>{0, 2}));
  EXPECT_EQ(rested->moved, (std::vector<std::uint16_t>{4}));
  EXPECT_EQ(rested->absent, (std::vector<std::uint16_t>{1}));
}

TEST(CombinedTracker, CertaintyIsTheOwnersAndFaultsAreAllTrackers) {
  const Stage stage;
  ASSERT_TRUE(stage.both->certainty(3));
  EXPECT_EQ(stage.both->certainty(3)->sigma_rad, 3.25);
  EXPECT_FALSE(stage.both->certainty(5));
  stage.imu->defects = 2;
  stage.eyewear->defects = 1;
  EXPECT_EQ(stage.both->faults(), 3U);
}

TEST(CombinedTracker, MergesWhatItsTrackersAnswer) {
  const Stage stage;
  stage.imu->weight = 0.25F;
  stage.eyewear->weight = 0.75F;
  OutputFrame out;
  EXPECT_EQ(stage.both->tick(frame_time(0), stage.lines, out).sensors_present, 8u);
  EXPECT_EQ(out.time, frame_time(0));
  EXPECT_EQ(out.weights[face::shape("jawOpen")], 0.25F);
  EXPECT_EQ(out.weights[face::shape("browDown_L")], 0.75F);
  stage.imu->there = 0;
  EXPECT_EQ(stage.both->tick(frame_time(1), stage.lines, out).sensors_present, 4u);
  for (int i = 2; i < 70; ++i) stage.both->tick(frame_time(i), stage.lines, out);
  EXPECT_EQ(out.weights[face::shape("jawOpen")], 0.75F);
}

TEST(CombinedTracker, TrackersAreComparedByWhatTheyExplain) {
  const Stage stage;
  stage.imu->weight = 0.25F;
  stage.eyewear->weight = 0.75F;
  stage.eyewear->explained.emplace().fill(0.1F);
  OutputFrame out;
  stage.both->tick(frame_time(0), stage.lines, out);
  EXPECT_EQ(out.weights[face::shape("browDown_L")], 0.25F)
      << "the other one's confidence stands for its share";
  stage.eyewear->explained->fill(0.6F);
  for (int i = 1; i < 70; ++i) stage.both->tick(frame_time(i), stage.lines, out);
  EXPECT_EQ(out.weights[face::shape("browDown_L")], 0.75F);
}

TEST(CombinedTracker, ALoneTrackerIsThatTracker) {
  auto only = std::make_unique<Puppet>("imu");
  Puppet& puppet = *only;
  std::vector<CombinedTracker::Part> parts;
  parts.push_back({std::move(only), {0}});
  CombinedTracker alone(std::move(parts));
  EXPECT_EQ(alone.modality(), "imu");
  const sensor::TimeLines lines{5, 0};
  for (int i = 0; i < 20; ++i) {
    puppet.weight = static_cast<float>(i) / 20;
    puppet.there = static_cast<std::size_t>(1 + i % 3);
    OutputFrame out, plain;
    EXPECT_EQ(alone.tick(frame_time(i), lines, out).sensors_present, puppet.there);
    puppet.tick(frame_time(i), lines, plain);
    ASSERT_TRUE(same_bits(out, plain));
  }
}

TEST(CombinedTracker, SettingsTakeEffectAtTheNextFrame) {
  ShaperSettings settings;
  settings.merge.order[static_cast<std::size_t>(MergePlace::jaw)] = {"eyewear"};
  const Stage stage(settings);
  stage.imu->weight = 0.25F;
  stage.eyewear->weight = 0.75F;
  OutputFrame out;
  stage.both->tick(frame_time(0), stage.lines, out);
  EXPECT_EQ(out.weights[face::shape("jawOpen")], 0.75F);
  stage.both->set(ShaperSettings());
  for (int i = 1; i < 70; ++i) {
    const float before = out.weights[face::shape("jawOpen")];
    stage.both->tick(frame_time(i), stage.lines, out);
    ASSERT_LE(std::abs(out.weights[face::shape("jawOpen")] - before), 0.05F) << "eased";
  }
  EXPECT_EQ(out.weights[face::shape("jawOpen")], 0.25F);
}

TEST(CombinedTracker, CalibrationIsDoneWhenAllThatAreThereAreDone) {
  const Stage stage;
  stage.eyewear->state = {.phase = Phase::watching, .step = Step::neutral, .hint = "hold still"};
  EXPECT_EQ(stage.both->calibration_state().phase, Phase::watching) << "none was heard: all count";
  stage.receive(0, 10);
  EXPECT_EQ(stage.both->calibration_state().phase, Phase::done) << "the glasses are not there";
  EXPECT_TRUE(stage.both->calibration_state().hint.empty());
  stage.receive(2, 11);
  const CalibrationState state = stage.both->calibration_state();
  EXPECT_EQ(state.phase, Phase::watching);
  EXPECT_EQ(state.step, Step::neutral);
  EXPECT_EQ(state.hint, "hold still");
  stage.imu->state.phase = Phase::guided;
  stage.imu->state.step = Step::nod;
  EXPECT_EQ(stage.both->calibration_state().phase, Phase::guided);
  EXPECT_EQ(stage.both->calibration_state().step, Step::nod);
  stage.imu->state = {.phase = Phase::done, .step = Step::none, .hint = {}};
  stage.receive(0, 14);  // The glasses were taken off.
  EXPECT_EQ(stage.both->calibration_state().phase, Phase::done);
}

TEST(CombinedTracker, GuidesAllAsLongAsOneWants) {
  const Stage stage;
  stage.eyewear->wants = {.neutral = std::chrono::seconds(5), .gestures = false};
  EXPECT_EQ(stage.both->guidance().neutral, std::chrono::seconds(5));
  EXPECT_TRUE(stage.both->guidance().gestures);
  stage.receive(3, 1);
  EXPECT_FALSE(stage.both->guidance().gestures) << "glasses alone need no nod";
  const DeviceTime begin = frame_time(0), end = frame_time(60);
  stage.both->guide(Step::neutral, begin, end);
  stage.both->guide(Step::nod, begin, end);
  stage.both->guide_range(begin, end);
  stage.both->guide_expression({.name = "smile", .begin = begin, .end = end, .target = {}});
  EXPECT_EQ(stage.eyewear->expression, "smile");
  EXPECT_FALSE(stage.both->guidance().learns_gaze);
  stage.eyewear->wants.learns_gaze = true;
  EXPECT_TRUE(stage.both->guidance().learns_gaze);
  stage.both->guide_gaze(face::gaze_targets()[1], begin, end);
  EXPECT_EQ(stage.eyewear->looks, "look left");
  stage.both->cancel_guidance();
  for (const Puppet* one : {stage.imu, stage.eyewear}) {
    EXPECT_EQ(one->guided, (std::vector<Step>{Step::neutral, Step::nod}));
    EXPECT_EQ(one->range_end, end);
    EXPECT_EQ(one->cancelled, 1);
  }
}

TEST(CombinedTracker, ACalibrationHasAPartOfEachAndGoesBackToEach) {
  const Stage stage;
  stage.imu->made = R"({"headings": [0.25, -1.5]})";
  stage.eyewear->made = "";
  EXPECT_EQ(stage.both->calibration(), R"({"imu":{"headings":[0.25,-1.5]}})");
  stage.eyewear->made = R"({"neutral": 1})";
  const std::string both = stage.both->calibration();
  EXPECT_EQ(both, R"({"eyewear":{"neutral":1},"imu":{"headings":[0.25,-1.5]}})");
  ASSERT_TRUE(stage.both->restore(both));
  EXPECT_EQ(stage.imu->restored, R"({"headings":[0.25,-1.5]})");
  EXPECT_EQ(stage.eyewear->restored, R"({"neutral":1})");
  EXPECT_EQ(stage.both->calibration(), both);
  stage.imu->restored.clear();
  ASSERT_TRUE(stage.both->restore(R"({"eyewear": {"neutral": 2}})"));
  EXPECT_EQ(stage.imu->restored, "") << "keeps what it has";

  stage.imu->made = stage.eyewear->made = "";
  EXPECT_EQ(stage.both->calibration(), "");
}

TEST(CombinedTracker, ARestoreThatFailsLeavesAllAsItWas) {
  const Stage stage;
  stage.imu->made = R"({"version": 1})";
  const std::string before = stage.both->calibration();
  EXPECT_EQ(stage.both->restore("").error().code, ErrorCode::malformed);
  EXPECT_EQ(stage.both->restore("{}").error().code, ErrorCode::malformed);
  EXPECT_EQ(stage.both->restore("[1]").error().code, ErrorCode::malformed);
  EXPECT_EQ(stage.both->restore(R"({"imu": {}, "speech": {}})").error().code, ErrorCode::mismatch);
  EXPECT_EQ(stage.both->restore(R"({"imu": {"version": 2}, "eyewear": "bad"})").error().code,
            ErrorCode::mismatch);
  OutputFrame frame;
  EXPECT_TRUE(stage.both->tick(frame_time(0), stage.lines, frame).calibration.empty());
  EXPECT_EQ(stage.both->calibration(), before);
}

TEST(CombinedTracker, ScoresAndEventsAreThoseOfAll) {
  const Stage stage;
  stage.imu->judged = {{.name = "nod", .value = 20, .unit = "deg", .pass = true, .sentence = "wide"}};
  stage.eyewear->judged = {{.name = "light", .value = 1, .unit = "", .pass = true, .sentence = "bright"}};
  stage.imu->events = {{.modality = "imu", .found = {{Step::nod, frame_time(1), frame_time(2)}}}};
  stage.eyewear->events = {{.modality = "eyewear", .found = {{Step::neutral, frame_time(0), frame_time(1)}}}};
  const std::vector<sensor::Score> scores = stage.both->scores();
  ASSERT_EQ(scores.size(), 2u);
  EXPECT_EQ(scores[0].name, "nod");
  EXPECT_EQ(scores[1].name, "light");
  OutputFrame frame;
  const tracker::TickResult result = stage.both->tick(frame_time(2), stage.lines, frame);
  ASSERT_EQ(result.calibration.size(), 2u);
  EXPECT_EQ(result.calibration[0].modality, "imu");
  ASSERT_EQ(result.calibration[1].found.size(), 1u);
  EXPECT_EQ(result.calibration[1].found[0].step, Step::neutral);
}

}  // namespace
}  // namespace mien::shaping::combined_tracker_test
