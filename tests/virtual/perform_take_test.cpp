#include "mien/virtual/perform_take.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>

#include "mien/core/bytes.h"
#include "mien/core/files.h"
#include "mien/face/livelink_csv.h"
#include "mien/session/command.h"
#include "mien/take/take.h"
#include "tests/folder.h"
#include "tests/virtual/three_sensors.h"

namespace mien::virt::perform_take_test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

/// A folder with a rig and a short motion in it.
class PerformTake : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(write_file(folder_ / "rig.toml", test::kRig));
    ASSERT_TRUE(write_file(folder_ / "talking.csv",
                           face::format_livelink_csv(face::livelink_from_motion(test::talking(45)))));
    request_.rig = folder_ / "rig.toml";
    request_.motion = face::load_motion(folder_ / "talking.csv").value();
    request_.script_name = "talking.csv";
    request_.take = folder_ / "a.mien";
    request_.devices = "lab";
    request_.seed = 5;
    request_.software = "mien test";
  }

  /// Expects the request to be refused with one line that has `words`, and no file to be left.
  void expect_refused(const std::string& words) {
    const auto done = perform_take(request_, no_progress);
    ASSERT_FALSE(done);
    EXPECT_THAT(done.error().message(), HasSubstr(words));
    EXPECT_EQ(done.error().message().find('\n'), std::string::npos);
    for (const fs::directory_entry& file : fs::directory_iterator(folder_.path()))
      EXPECT_FALSE(file.path().filename().string().starts_with("a.mien")) << file.path();
  }

  mien::test::Folder folder_;
  PerformRequest request_;
};

TEST_F(PerformTake, SaysInTheHeaderWhatWasPerformed) {
  const PerformSummary summary = perform_take(request_, no_progress).value();
  const take::Take take = take::Take::open(request_.take).value();
  EXPECT_TRUE(take.finished());
  EXPECT_TRUE(take.check());
  EXPECT_EQ(take.header().software, "mien test");
  EXPECT_EQ(take.header().performer, "virtual:5");
  EXPECT_EQ(take.header().script, "talking.csv");
  EXPECT_EQ(take.header().devices, "lab");
  EXPECT_EQ(take.header().face, "builtin");
  EXPECT_EQ(take.header().prologue, "short");
  EXPECT_EQ(take.header().seed, 5U);
  EXPECT_EQ(take.header().rig_toml, test::kRig);
  EXPECT_EQ(take.entries().value().size(), summary.packets + 1) << "the calibration's command is first";
  EXPECT_EQ(take.samples().value().size(), summary.samples);
  EXPECT_EQ(take.ticks().value().size(), summary.frames);
  EXPECT_EQ(take.truth().value().size(), summary.frames);
}

TEST_F(PerformTake, TheLogBeginsWithTheCalibrationAsASessionsDoes) {
  request_.devices = "device";
  ASSERT_TRUE(perform_take(request_, no_progress));
  const take::Take take = take::Take::open(request_.take).value();
  const take::LogEntry first = take.entries().value().front();
  EXPECT_EQ(first.source, session::kPageSource);
  const auto command = session::parse_command(as_text(first.bytes));
  ASSERT_TRUE(command) << command.error().message();
  const auto& steps = std::get<session::Calibrate>(*command).steps;
  ASSERT_EQ(steps.size(), 3U);
  const std::vector<take::Event> events = take.events().value();
  for (const take::Event& event : events)
    if (event.kind == "nod") {
      EXPECT_EQ(steps[1].begin, event.begin);
      EXPECT_EQ(steps[1].end, event.end);
    }
  EXPECT_EQ(take.ticks().value().front().after_entry,
            play(set_stage(request_).value()).value().ticks.front().after_entry + 1);
}

TEST_F(PerformTake, TheSeedDecidesEverythingButTheDate) {
  const auto content = [&](std::uint64_t seed) {
    request_.seed = seed;
    request_.replace = true;
    EXPECT_TRUE(perform_take(request_, no_progress));
    std::vector<std::vector<std::byte>> bytes;
    const take::Take take = take::Take::open(request_.take).value();
    auto entries = take.entries().value();
    for (take::LogEntry& entry : entries) bytes.push_back(std::move(entry.bytes));
    return bytes;
  };
  const auto one = content(5);
  EXPECT_EQ(one, content(5));
  EXPECT_NE(one, content(6));
}

TEST_F(PerformTake, AFileOfFaultsIsAProfile) {
  ASSERT_TRUE(write_file(folder_ / "lossy.toml", "packet_loss = 0.5\n"));
  request_.prologue = performer::PrologueKind::none;
  request_.devices = "device";
  const auto all = perform_take(request_, no_progress).value().packets;
  request_.replace = true;
  request_.devices = (folder_ / "lossy.toml").string();
  const auto received = perform_take(request_, no_progress).value().packets;
  EXPECT_GT(received, all / 4);
  EXPECT_LT(received, 3 * all / 4);
  EXPECT_EQ(take::Take::open(request_.take).value().header().devices, request_.devices);
}

TEST_F(PerformTake, LeavesAnExistingTakeAlone) {
  ASSERT_TRUE(write_file(request_.take, "somebody's work"));
  const auto done = perform_take(request_, no_progress);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, ErrorCode::bad_usage);
  EXPECT_THAT(done.error().message(), HasSubstr("--force"));
  EXPECT_EQ(read_text(request_.take).value(), "somebody's work");
  request_.replace = true;
  EXPECT_TRUE(perform_take(request_, no_progress));
  EXPECT_TRUE(take::Take::open(request_.take));
}

TEST_F(PerformTake, StoppedAtAnyPointItLeavesNothing) {
  request_.motion = test::talking(600);  // Long enough to be stopped in the midst of its writing.
  const std::vector<std::string> before = folder_.files();
  for (const double at : {0.0, 0.1, 0.5, 0.75}) {
    const auto done =
        perform_take(request_, [at](double fraction, std::string_view) { return fraction < at; });
    ASSERT_FALSE(done) << at;
    EXPECT_EQ(done.error().code, ErrorCode::cancelled);
    EXPECT_EQ(folder_.files(), before) << at;
  }
}

TEST_F(PerformTake, AMisplacedSensorFeelsAnotherPatchOfSkin) {
  request_.devices = (folder_ / "faults.toml").string();
  request_.replace = true;
  const auto samples = [&](const std::string& faults) {
    EXPECT_TRUE(write_file(request_.devices, faults));
    EXPECT_TRUE(perform_take(request_, no_progress));
    std::vector<float> all;
    const auto performed = take::Take::open(request_.take).value().samples().value();
    for (const take::StoredSample& stored : performed)
      all.insert(all.end(), stored.sample.values.begin(), stored.sample.values.begin() + 3);
    return all;
  };
  const auto placed = samples("mount_position_mm = 0\n");
  EXPECT_EQ(samples("mount_position_mm = 0\n"), placed);
  EXPECT_NE(samples("mount_position_mm = 5\n"), placed);
}

TEST_F(PerformTake, RefusesAPerformanceOfDays) {
  request_.motion->frames.back().time_s = 3 * 86'400;
  expect_refused("talking.csv");
}

TEST_F(PerformTake, RefusesMoreHoursThanAreHeldWhole) {
  request_.motion_s = kLongestWholeS + 1;
  expect_refused("7200");
  expect_refused("IMUs alone");
  request_.devices = "device";
  request_.motion_s = kLongestPerformanceS + 1;
  expect_refused("10800");
}

TEST_F(PerformTake, AMotionIsRepeatedForAsLongAsItIsToLast) {
  const double once_s = request_.motion->duration_s();
  request_.replace = true;
  for (const char* devices : {"lab", "device"})
    for (const double seconds : {0.4 * once_s, 10.0}) {
      request_.devices = devices;
      request_.motion_s = seconds;
      const PerformSummary summary = perform_take(request_, no_progress).value();
      const auto truth = take::Take::open(request_.take).value().truth().value();
      std::vector<take::TruthFrame> motion;
      std::ranges::copy_if(truth, std::back_inserter(motion), &take::TruthFrame::evaluated);
      ASSERT_FALSE(motion.empty());
      EXPECT_NEAR(to_seconds(motion.back().time - motion.front().time), seconds, 2.0 / 60);
      EXPECT_GE(summary.duration_s, seconds);
      const auto round = static_cast<std::size_t>(std::lround(60 * (once_s + performer::kReturnS)));
      for (std::size_t i = 0; i + round < motion.size(); ++i)
        for (std::size_t k = 0; k < face::kShapeCount; ++k)
          ASSERT_NEAR(motion[i + round].weights[k], motion[i].weights[k], 0.02) << devices << " " << i;
    }
}

TEST_F(PerformTake, ALongScriptGoesOnWhereItsFirstPieceEnds) {
  request_.motion.reset();
  request_.devices = "device";
  request_.prologue = performer::PrologueKind::none;
  std::vector<performer::Script> scripts =
      performer::piece_scripts(performer::Block::free, performer::kPieceS + 3);
  request_.script = scripts[0];
  request_.later_scripts = {scripts[1]};
  const Stage whole = set_stage(request_).value();
  EXPECT_EQ(whole.motion.motion.frames.size(), 60 * 603U);
  const Stage piece = set_stage(request_, StageHolds::piece).value();
  EXPECT_EQ(piece.motion.motion.frames.size(), 60 * 600U);
  EXPECT_NEAR(piece.duration_s, whole.duration_s, 1e-9);
  performer::LongMotion played = long_motion(piece);
  const face::MotionCurve curve(whole.motion.motion);
  for (const double t : {0.0, 300.0, 599.9, 600.5, 602.0, 602.9})
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      EXPECT_NEAR(played.at(t).weights[k], curve.at(t).weights[k], 1e-5) << t;
}

TEST_F(PerformTake, PlaysExactlyThreeHours) {
  request_.motion.reset();
  request_.devices = "device";
  // Of which only the first, a short one here, is drawn. Their lengths add up to a little more in doubles.
  request_.later_scripts = performer::piece_scripts(performer::Block::mixed, kLongestPerformanceS);
  request_.script = performer::default_script(performer::Block::mixed, 1);
  request_.later_scripts.back().segments.back().duration_s -= 1;
  EXPECT_TRUE(set_stage(request_, StageHolds::piece));
}

TEST_F(PerformTake, ProgressOnlyRises) {
  double last = 0;
  ASSERT_TRUE(perform_take(request_, [&](double fraction, std::string_view) {
    EXPECT_GE(fraction, last);
    last = fraction;
    return true;
  }));
  EXPECT_EQ(last, 1);
}

TEST_F(PerformTake, RefusesARigThatIsNotThere) {
  request_.rig = folder_ / "none.toml";
  expect_refused("none.toml");
}

TEST_F(PerformTake, RefusesARigWithASiteThatNobodyKnows) {
  ASSERT_TRUE(
      write_file(folder_ / "rig.toml",
                 "name = \"odd\"\nreference = \"elbow\"\n[[sensor]]\nname = \"elbow\"\nkind = \"imu\"\n"
                 "site = \"elbow\"\nside = \"L\"\nrole = \"face\"\n"));
  expect_refused("elbow");
}

TEST_F(PerformTake, HoldsTheSoundFromTheMotionsStart) {
  request_.sound = Sound{.rate_hz = 16000, .samples = std::vector<float>(20000)};
  for (std::size_t i = 0; i < request_.sound->samples.size(); ++i)
    request_.sound->samples[i] = 0.5F * static_cast<float>(i % 100) / 100;
  for (const char* devices : {"lab", "device"}) {
    request_.devices = devices;
    request_.replace = true;
    ASSERT_TRUE(perform_take(request_, no_progress));
    const take::Take take = take::Take::open(request_.take).value();
    const auto audio = take.audio().value();
    ASSERT_TRUE(audio);
    EXPECT_EQ(audio->rate_hz, 16000);
    EXPECT_EQ(audio->samples, request_.sound->samples);
    // The first frame that counts is the motion's first, to a frame.
    const std::vector<take::TruthFrame> truth = take.truth().value();
    for (const take::TruthFrame& frame : truth)
      if (frame.evaluated) {
        EXPECT_NEAR(to_seconds(frame.time - audio->start), 0, 1.0 / 60);
        break;
      }
  }
}

TEST_F(PerformTake, RefusesAFaceThatIsNotThere) {
  request_.face = "nobody.glb";
  expect_refused("nobody.glb");
}

TEST_F(PerformTake, RefusesFaultsThatAreNone) {
  request_.devices = (folder_ / "faults.toml").string();
  expect_refused("faults.toml");
  for (const auto& [text, words] :
       std::vector<std::pair<std::string, std::string>>{{"packet_loss = 1.5\n", "packet_loss"},
                                                        {"packet_loss = -0.1\n", "packet_loss"},
                                                        {"packet_loss = nan\n", "packet_loss"},
                                                        {"packet_loss = \"some\"\n", "packet_loss"},
                                                        {"clock_offset_s = [0, 1e12]\n", "clock_offset_s"},
                                                        {"clock_offset_s = [2, 1]\n", "clock_offset_s"},
                                                        {"clock_offset_s = 5\n", "clock_offset_s"},
                                                        {"clock_drift_ppm = 500000\n", "clock_drift_ppm"},
                                                        {"gyro_range_dps = 0\n", "gyro_range_dps"},
                                                        {"gyro_range_dps = 4000\n", "gyro_range_dps"},
                                                        {"accel_range_g = 100\n", "accel_range_g"},
                                                        {"radio_delay_ms = inf\n", "radio_delay_ms"},
                                                        {"magnetometer = 1\n", "magnetometer"},
                                                        {"gyro_temperature = 1\n", "gyro_temperature"},
                                                        {"packet_loss =\n", "line 1"}}) {
    ASSERT_TRUE(write_file(request_.devices, text));
    SCOPED_TRACE(text);
    expect_refused(words);
  }
}

TEST_F(PerformTake, RefusesAFolderThatIsNotThere) {
  request_.take = folder_ / "nowhere" / "a.mien";
  const auto done = perform_take(request_, no_progress);
  ASSERT_FALSE(done);
  EXPECT_THAT(done.error().message(), HasSubstr("nowhere"));
  EXPECT_FALSE(fs::exists(folder_ / "nowhere"));
}

}  // namespace
}  // namespace mien::virt::perform_take_test
