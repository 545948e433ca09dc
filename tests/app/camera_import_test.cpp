// `mien import --camera`: pictures that somebody else recorded become a take that is solved and replayed.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "mien/core/files.h"
#include "mien/headset/views_file.h"
#include "mien/take/take.h"
#include "tests/app/program.h"
#include "tests/headset/small_jpeg.h"
#include "tests/headset/small_model.h"

namespace mien::app::test::camera_import_test {
namespace {
namespace fs = std::filesystem;

using headset::test::grey_jpeg;
using testing::HasSubstr;

class CameraImport : public testing::Test {
 protected:
  CameraImport() {
    write(folder / "rig.toml", headset::test::headset_rig_text());
    EXPECT_TRUE(headset::write_views_file(folder / "model.safetensors", headset::test::small_views_file()));
  }
  /// So many JPEGs of this size.
  [[nodiscard]] std::string pictures(const std::string& name, int count, int width = 64,
                                     int height = 48) const {
    fs::create_directory(folder / name);
    for (int i = 0; i < count; ++i)
      EXPECT_TRUE(
          write_file(folder / name + fmt::format("/frame{}.jpg", i + 1), grey_jpeg(width, height, i % 40)));
    write(folder / name + "/notes.txt", "no picture");
    return folder / name;
  }
  [[nodiscard]] Outcome import(const std::vector<std::string>& more) const {
    std::vector<std::string> arguments = {"import", "--rig", folder / "rig.toml", "--out", folder / "a.mien"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  }
  void expect_refused(const std::vector<std::string>& more, const std::string& why, int status = 2) const {
    const Outcome outcome = import(more);
    EXPECT_EQ(outcome.status, status) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(why));
    EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << outcome.err;
    EXPECT_FALSE(fs::exists(folder / "a.mien")) << "nothing half-written";
  }
  Folder folder;
};

TEST_F(CameraImport, MakesATakeThatIsSolvedAndReplayed) {
  const std::string left = pictures("left", 100), right = pictures("right", 90, 32, 32);
  write(folder / "events.csv", "time_s,name\n0,neutral\n3.2,smile\n");
  const Outcome outcome =
      import({"--camera", "eye_L=" + left, "--camera", "eye_R=" + right, "--fps", "25", "--mirror", "eye_L",
              "--crop", "eye_R=0.25,0,0.5,1", "--events", folder / "events.csv", "--json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto summary = nlohmann::json::parse(outcome.out);
  EXPECT_NEAR(summary["duration_s"], 4, 1e-9);
  EXPECT_NEAR(summary["frames"].get<double>(), 4 * 60, 5);
  EXPECT_EQ(summary["events"], 2);
  EXPECT_EQ(summary["truth"], 0);
  EXPECT_EQ(
      summary["cameras"][0],
      (nlohmann::json{{"name", "eye_L"}, {"pictures", 100}, {"width", 64}, {"height", 48}, {"scaled", 0}}));
  EXPECT_EQ(summary["cameras"][1]["pictures"], 90);

  const auto take = take::Take::open(folder / "a.mien");
  ASSERT_TRUE(take) << take.error().message();
  const sensor::CameraMount& eye = *take->rig().sensors[0].camera;
  EXPECT_EQ(eye.size, (std::array{64, 48}));
  EXPECT_EQ(eye.rate_hz, 25);
  const auto before = sensor::parse_rig(headset::test::headset_rig_text(), "rig").value();
  EXPECT_NE(eye.mirror, before.sensors[0].camera->mirror);
  EXPECT_EQ(eye.crop, before.sensors[0].camera->crop);
  EXPECT_EQ(take->rig().sensors[1].camera->crop, (std::array{0.25, 0.0, 0.5, 1.0}));
  const auto events = take->events().value();
  ASSERT_EQ(events.size(), 2U);
  EXPECT_EQ(events[0].kind, "neutral");
  EXPECT_NEAR(to_seconds(events[0].end - events[0].begin), 3, 1e-9);
  EXPECT_EQ(events[1].kind, "prompt");
  EXPECT_EQ(nlohmann::json::parse(events[1].json)["name"], "smile");
  const auto samples = take->samples().value();
  ASSERT_EQ(samples.size(), 190U);
  EXPECT_NEAR(to_seconds(samples.back().sample.time - samples.front().sample.time), 99 / 25.0, 1e-3);
  // The log begins with the calibration of the events. The picture is the one that was recorded, to the byte.
  EXPECT_EQ(take->entries().value().front().source, "page");
  auto payloads = take->payloads().value();
  const auto first = payloads.of(2).value();
  EXPECT_EQ(std::vector<std::byte>(first.bytes.begin(), first.bytes.end()), grey_jpeg(64, 48, 0));

  const Outcome info = run({"take", "info", folder / "a.mien"});
  EXPECT_EQ(info.status, 0) << info.err;
  EXPECT_EQ(run({"take", "check", folder / "a.mien"}).status, 0);
  const std::string model = folder / "model.safetensors";
  const Outcome solved = run({"solve", folder / "a.mien", "--model", model, "--json"});
  ASSERT_EQ(solved.status, 0) << solved.err;
  EXPECT_GT(nlohmann::json::parse(solved.out)["observed"], 0.4);
  const Outcome replayed = run({"live", "--replay", folder / "a.mien", "--model", model, "--json"});
  EXPECT_EQ(replayed.status, 0) << replayed.err;
  EXPECT_EQ(nlohmann::json::parse(replayed.out)["frames"], summary["frames"]);
}

TEST_F(CameraImport, NamesThatCountGoByTheirNumbers) {
  const std::string left = pictures("left", 11);  // frame10.jpg is as text before frame2.jpg.
  ASSERT_EQ(import({"--camera", "eye_L=" + left, "--fps", "30"}).status, 0);
  const auto take = take::Take::open(folder / "a.mien");
  auto payloads = take->payloads().value();
  for (int i = 0; i < 11; ++i) {
    const auto picture = payloads.of(i + 1).value();
    EXPECT_EQ(std::vector<std::byte>(picture.bytes.begin(), picture.bytes.end()), grey_jpeg(64, 48, i)) << i;
  }
}

TEST_F(CameraImport, ScalesAndTurnsGreyWhatIsNoCamerasPicture) {
  const std::string left = folder / "left";
  fs::create_directory(left);
  const std::vector<std::uint8_t> large = headset::test::rings(1600, 1200, 0);
  const std::string pixels(large.begin(), large.end());
  write(left + "/1.pgm", "P5 1600 1200 255\n" + pixels);
  write(left + "/2.ppm", "P3 2 2 255 " + std::string("200 200 200 200 200 200 200 200 200 200 200 200"));
  ASSERT_TRUE(write_file(left + "/3.jpg", headset::test::colour_jpeg(64, 48, 1)));
  const Outcome outcome = import({"--camera", "eye_L=" + left, "--fps", "30"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("3 pictures of 1280 x 960, 3 of them scaled to that"));
  EXPECT_EQ(take::Take::open(folder / "a.mien")->samples()->size(), 3U);
}

TEST_F(CameraImport, AMotionIsItsTruth) {
  write(folder / "truth.csv", [] {
    std::string csv =
        "Timecode,BlendShapeCount,EyeBlinkLeft,EyeLookDownLeft,EyeLookInLeft,EyeLookOutLeft,JawOpen\n";
    for (int i = 0; i < 60; ++i) csv += fmt::format("00:00:{:02}:{:02},61,0,0,0,0.5,0.25\n", i / 60, i % 60);
    return csv;
  }());
  const std::string left = pictures("left", 40);
  const Outcome outcome =
      import({folder / "truth.csv", "--camera", "eye_L=" + left, "--fps", "20", "--json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_GT(nlohmann::json::parse(outcome.out)["truth"], 40);
  const Outcome measured =
      run({"evaluate", folder / "a.mien", "--model", folder / "model.safetensors", "--json"});
  ASSERT_EQ(measured.status, 0) << measured.err;
  const auto model = nlohmann::json::parse(measured.out)["model"];
  EXPECT_GT(model["gaze_deg"]["median"], 0);
  EXPECT_TRUE(model.contains("openness_pearson"));
  EXPECT_TRUE(model["ece"].is_null());
  EXPECT_TRUE(model.contains("lip_gap_f1"));
  EXPECT_THAT(run({"evaluate", folder / "a.mien", "--model", folder / "model.safetensors"}).out,
              HasSubstr("gaze median"));
}

TEST_F(CameraImport, RefusesEachWrongOption) {
  const std::string left = pictures("left", 2), camera = "eye_L=" + left;
  expect_refused({"--camera", camera}, "--fps 25");
  expect_refused({"--camera", camera, "--fps", "0.5"}, "--fps");
  expect_refused({"--camera", "nose=" + left, "--fps", "25"}, "there are eye_L, eye_R, mouth_L, mouth_R");
  expect_refused({"--camera", left, "--fps", "25"}, "has no name and value");
  expect_refused({"--camera", "eye_L=" + (folder / "none"), "--fps", "25"}, "no such folder or film");
  expect_refused({"--camera", camera, "--camera", camera, "--fps", "25"}, "eye_L is given twice");
  expect_refused({"--camera", camera, "--fps", "25", "--mirror", "eye"}, "there are eye_L");
  for (const char* crop : {"eye_L=0,0,1", "eye_L=0,0,1,1,1", "eye_L=0,0,1,x", "eye_L=0.5,0,0.6,1",
                           "eye_L=0,0,0.01,1", "eye_L=nan,0,1,1", "eye_L=", "0,0,1,1"})
    expect_refused({"--camera", camera, "--fps", "25", "--crop", crop}, "--crop");
  expect_refused({"--mirror", "eye_L"}, "--camera");
  expect_refused({}, "nothing to import");
  fs::create_directory(folder / "empty");
  write(folder / "empty/notes.txt", "no picture");
  expect_refused({"--camera", "eye_L=" + (folder / "empty"), "--fps", "25"}, "no picture is in this folder");
  write(folder / "events.csv", "neutral,0\n");
  expect_refused({"--camera", camera, "--fps", "25", "--events", folder / "events.csv"}, "line 1");
  const Outcome wrong_name = run({"import", "--camera", camera, "--fps", "25", "--out", folder / "a.csv"});
  EXPECT_EQ(wrong_name.status, 2);
  EXPECT_THAT(wrong_name.err, HasSubstr(".mien"));
}

TEST_F(CameraImport, NamesThePictureThatItCannotRead) {
  const std::string left = pictures("left", 30), camera = "eye_L=" + left;
  write(left + "/frame20.jpg", "\xFF\xD8 no more");
  expect_refused({"--camera", camera, "--fps", "25"}, "frame20.jpg");
  write(left + "/frame20.jpg", "");
  expect_refused({"--camera", camera, "--fps", "25"}, "frame20.jpg");
  ASSERT_TRUE(write_file(left + "/frame1.jpg", grey_jpeg(8, 8, 0)));
  expect_refused({"--camera", camera, "--fps", "25"}, "16 x 16");
}

TEST_F(CameraImport, AnOlderTakeStandsUntilItIsReplaced) {
  const std::string camera = "eye_L=" + pictures("left", 5);
  write(folder / "a.mien", "older");
  const Outcome kept = import({"--camera", camera, "--fps", "25"});
  EXPECT_EQ(kept.status, 2) << kept.err;
  EXPECT_EQ(content(folder / "a.mien"), "older");
  EXPECT_EQ(import({"--camera", camera, "--fps", "25", "--force"}).status, 0);
  EXPECT_TRUE(take::Take::open(folder / "a.mien"));
}

/// The helper that decodes films may not be built; making one needs it too.
TEST_F(CameraImport, FilmsAreDecodedByTheHelper) {
  const fs::path helper = fs::path(program_path()).parent_path() / "mien-media";
  if (!fs::exists(helper)) GTEST_SKIP() << "no mien-media";
  std::string frames;
  for (int i = 0; i < 30; ++i)
    for (const std::uint8_t level : headset::test::rings(64, 48, i % 40))
      frames += std::string(3, static_cast<char>(level));
  write(folder / "frames.rgb", frames);
  const std::string film = folder / "eye.mp4";
  const std::string command = fmt::format("'{}' video --size 64x48 --fps 30 --out '{}' < '{}'",
                                          helper.string(), film, folder / "frames.rgb");
  ASSERT_EQ(std::system(command.c_str()), 0);
  const Outcome outcome = import({"--camera", "eye_L=" + film, "--fps", "30", "--json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto summary = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(summary["cameras"][0]["pictures"], 30);
  EXPECT_EQ(summary["cameras"][0]["width"], 64);
  fs::remove(folder / "a.mien");
  write(folder / "eye.mp4", "no film");
  expect_refused({"--camera", "eye_L=" + film, "--fps", "30"}, "eye.mp4");
}

}  // namespace
}  // namespace mien::app::test::camera_import_test
