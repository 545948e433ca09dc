#include "mien/live/page_messages.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace mien::live::page_messages_test {
namespace {

using Json = nlohmann::json;

sensor::Rig glasses() {
  sensor::Rig rig;
  rig.name = "glasses";
  sensor::Mount brow;
  brow.name = "brow";
  brow.kind = "eyewear";
  brow.role = "face";
  brow.position_m = Vec3(0.018, 0.054, 0.114);
  brow.aim = Vec3(0, 0, -1);
  sensor::Mount ear;
  ear.name = "ear";
  ear.kind = "imu";
  ear.role = "head";
  rig.sensors = {brow, ear};
  return rig;
}

Status status() {
  Status status;
  status.report.links.resize(2);
  status.report.links[0].level = 0.3456F;
  status.report.shaping = "{}";
  return status;
}

TEST(PageMessages, HelloSaysWhereASensorLooks) {
  const Json hello = Json::parse(sink::hello_json(hello_for(glasses(), "mien", "m", {}, false)));
  EXPECT_EQ(hello["rig"]["sensors"][0]["kind"], "eyewear");
  EXPECT_EQ(hello["rig"]["sensors"][0]["aim"], Json({0.0, 0.0, -1.0}));
  EXPECT_FALSE(hello["rig"]["sensors"][1].contains("aim"));
}

TEST(PageMessages, HelloSaysWhereACameraLooks) {
  sensor::Rig rig = glasses();
  rig.sensors[0].kind = "camera";
  rig.sensors[0].aim.reset();
  rig.sensors[0].camera.emplace().look_at_m = Vec3(0.018, 0.054, 0.100);
  const Json hello = Json::parse(sink::hello_json(hello_for(rig, "mien", "m", {}, false)));
  ASSERT_TRUE(hello["rig"]["sensors"][0].contains("aim"));
  const auto aim = hello["rig"]["sensors"][0]["aim"].get<std::vector<double>>();
  EXPECT_NEAR(aim[0], 0, 1e-9);
  EXPECT_NEAR(aim[2], -1, 1e-9);
  rig.sensors[0].camera->look_at_m = *rig.sensors[0].position_m;
  const Json nowhere = Json::parse(sink::hello_json(hello_for(rig, "mien", "m", {}, false)));
  EXPECT_FALSE(nowhere["rig"]["sensors"][0].contains("aim"));
}

TEST(PageMessages, StatusSaysWhoIsShownPictures) {
  Status now = status();
  EXPECT_TRUE(Json::parse(status_json(now, glasses()))["pictures"].is_null()) << "no camera";
  now.pictures = PicturesState{.cameras = 4, .watchers = 1};
  EXPECT_EQ(Json::parse(status_json(now, glasses()))["pictures"], Json({{"cameras", 4}, {"watchers", 1}}));
}

TEST(PageMessages, StatusSaysWhatIsSeenOfACamera) {
  Status now = status();
  now.report.links[0].view = {.crop = {0.1, 0.2, 0.5, 0.6}, .turn_deg = 90, .mirror = true};
  const Json links = Json::parse(status_json(now, glasses()))["links"];
  EXPECT_EQ(links[0]["view"],
            Json::parse(R"({"crop": [0.1, 0.2, 0.5, 0.6], "turn_deg": 90, "mirror": true})"));
  EXPECT_TRUE(links[1]["view"].is_null());
}

TEST(PageMessages, StatusSaysWhoseLensIsToBeCoveredAndWhyNoneWasFound) {
  Status now = status();
  EXPECT_TRUE(Json::parse(status_json(now, glasses()))["cover"].is_null());
  now.report.cover.sensor = "eye_L";
  EXPECT_EQ(Json::parse(status_json(now, glasses()))["cover"],
            Json({{"sensor", "eye_L"}, {"trouble", nullptr}}));
  now.report.cover = {.sensor = "", .trouble = "two lenses are covered at once"};
  EXPECT_EQ(Json::parse(status_json(now, glasses()))["cover"],
            Json({{"sensor", nullptr}, {"trouble", "two lenses are covered at once"}}));
}

TEST(PageMessages, StatusSaysWhereTheFaceRests) {
  Status now = status();
  now.report.shaping = R"({"resting": true})";
  now.report.resting = R"({"rest": {"eyeBlink_L": 0.25}, "full": {}})";
  const Json said = Json::parse(status_json(now, glasses()));
  EXPECT_EQ(said["shaping"]["resting"], true);
  EXPECT_EQ(said["shaping"]["resting_face"]["rest"], Json::parse(R"({"eyeBlink_L": 0.25})"));
  EXPECT_FALSE(Json::parse(status_json(status(), glasses()))["shaping"].contains("resting_face"));
}

TEST(PageMessages, StatusNamesWhoIsHeardAsASensorAndWhoIsNot) {
  Status now = status();
  now.report.links[0].source = "udp://10.0.0.1:5005";
  now.report.links[0].rivals = {{"udp://10.0.0.9:5005", std::chrono::milliseconds(4), true}};
  const Json said = Json::parse(status_json(now, glasses()));
  EXPECT_EQ(said["links"][0]["source"], "udp://10.0.0.1:5005");
  EXPECT_EQ(said["links"][0]["rivals"],
            Json::parse(R"([{"source": "udp://10.0.0.9:5005", "age_ms": 4.0, "implausible": true}])"));
  EXPECT_EQ(said["links"][1]["source"], "");
  EXPECT_EQ(said["links"][1]["rivals"], Json::array());
  EXPECT_EQ(event_text({"contested", {}, {}, R"({"sensor": "brow", "accepted": "a", "other": "b"})"}),
            "two devices send as brow: a is heard, b is not; the page's sensors let you choose");
}

TEST(PageMessages, StatusSaysHowOldAndHowSureTheCalibrationIs) {
  Status now = status();
  Json said = Json::parse(status_json(now, glasses()));
  for (const char* key : {"age_s", "recentred_s", "sigma_deg"})
    EXPECT_TRUE(said["calibration"][key].is_null());
  EXPECT_EQ(said["calibration"]["advises_recentring"], false);
  EXPECT_TRUE(said["links"][0]["rotation_sigma_deg"].is_null());
  EXPECT_EQ(said["links"][0]["left_out"], false);

  session::Report::Calibration& calibration = now.report.calibration;
  calibration.age_s = 4320;
  calibration.recentred_s = 180.5;
  calibration.sigma_rad = 0.1;
  calibration.advises_recentring = true;
  calibration.faults = 2;
  now.report.links[1].certainty = tracker::SensorCertainty{.sigma_rad = 0.2, .left_out = true};
  said = Json::parse(status_json(now, glasses()));
  EXPECT_EQ(said["calibration"]["age_s"], 4320);
  EXPECT_EQ(said["calibration"]["recentred_s"], 180.5);
  EXPECT_EQ(said["calibration"]["sigma_deg"], 5.73);
  EXPECT_EQ(said["calibration"]["advises_recentring"], true);
  EXPECT_EQ(said["calibration"]["drift_faults"], 2);
  EXPECT_EQ(said["links"][1]["rotation_sigma_deg"], 11.46);
  EXPECT_EQ(said["links"][1]["left_out"], true);
}

TEST(PageMessages, RecentringIsAdvisedAndTold) {
  const auto text = [](const char* kind, const char* json) { return event_text({kind, {}, {}, json}); };
  EXPECT_EQ(text("recentre", ""), "") << "who pressed Space knows";
  EXPECT_EQ(text("recentre", R"({"source": "udp://10.0.0.9:9000"})"),
            "re-centring, as udp://10.0.0.9:9000 asks by OSC: relax your face and look ahead");
  EXPECT_EQ(text("rested", R"({"corrected": ["a"], "moved": [], "absent": []})"), "");
  EXPECT_EQ(text("rested", R"({"corrected": ["a"], "moved": [], "absent": ["b"]})"),
            "not corrected for lack of data: b; see to it on the page's sensors, then re-centre again");
  EXPECT_EQ(text("rested", R"({"corrected": [], "moved": ["mentalis", "brow"], "absent": []})"),
            "the face moved at mentalis, brow while it should rest, so that was not corrected; relax it and "
            "re-centre again");
  EXPECT_EQ(text("recentre_advised", R"({"sigma_deg": 6.25, "left_out": []})"),
            "rotations are known to 6.2 degrees only; relax your face and press Space on the page, or mien "
            "calibrate recentre");
  EXPECT_EQ(text("recentre_advised", R"({"sigma_deg": 3, "left_out": ["mentalis"]})"),
            "left out for their uncertainty: mentalis; relax your face and press Space on the page, or mien "
            "calibrate recentre");
  EXPECT_NE(text("drift_fault", R"({"count": 1})").find("a defect of this program"), std::string::npos);
  for (const char* kind : {"rested", "recentre_advised", "drift_fault", "recentre"})
    for (const char* odd : {"", "[]", "3", R"({"moved": 3, "left_out": [1], "sigma_deg": "x", "source": 1})"})
      EXPECT_NO_THROW(static_cast<void>(text(kind, odd))) << kind << odd;
}

TEST(PageMessages, StatusDoesNotRepeatTheTextOfRules) {
  Status now = status();
  now.report.shaping = R"({"constraints": true, "rules": "[[exclusive]]", "smoothing": 0.5})";
  const Json said = Json::parse(status_json(now, glasses()));
  EXPECT_EQ(said["shaping"], Json::parse(R"({"constraints": true, "smoothing": 0.5})"));
}

TEST(PageMessages, StatusHasALevelWhereThereIsOneAndPromptsWhileTheyAreAskedFor) {
  Status now = status();
  Json said = Json::parse(status_json(now, glasses()));
  EXPECT_EQ(said["links"][0]["level"], 0.346);
  EXPECT_TRUE(said["links"][1]["level"].is_null());
  EXPECT_TRUE(said["prompts"].is_null());
  EXPECT_TRUE(said["recording"]["ends_s"].is_null());

  session::Report::Prompts& prompts = now.report.prompts;
  prompts.state = "running";
  prompts.prompt.name = "smile";
  prompts.prompt.say = "Smile";
  prompts.prompt.target[face::shape("mouthSmile_L")] = 0.6F;
  prompts.prompt.text = "Read.";
  prompts.prompt.block = "calm";
  prompts.prompt.emotion = "joy";
  prompts.prompt.language = "en";
  prompts.prompt.own_pace = true;
  prompts.prompt.attempt = 2;
  prompts.poor = {"chin was lost"};
  prompts.again = 3;
  prompts.next.name = "open";
  prompts.next.text = "And.";
  prompts.next.target[face::shape("jawOpen")] = 1;
  prompts.number = 2;
  prompts.of = 9;
  prompts.progress = 0.25;
  prompts.remaining_s = 1.5;
  prompts.left_s = 21;
  now.recording_ends_s = 60;
  said = Json::parse(status_json(now, glasses()));
  EXPECT_EQ(said["prompts"], Json::parse(R"({"state": "running", "name": "smile", "say": "Smile",
    "text": "Read.", "block": "calm", "emotion": "joy", "language": "en", "own_pace": true, "attempt": 2,
    "poor": ["chin was lost"], "again": 3,
    "target": {"mouthSmile_L": 0.6}, "next": {"name": "open", "text": "And.", "target": {"jawOpen": 1.0}},
    "number": 2, "of": 9, "progress": 0.25, "remaining_s": 1.5, "left_s": 21.0})"));
  EXPECT_EQ(said["recording"]["ends_s"], 60);

  prompts = {};
  prompts.state = "over";
  prompts.number = prompts.of = 9;
  said = Json::parse(status_json(now, glasses()));
  EXPECT_EQ(said["prompts"]["state"], "over");
  EXPECT_TRUE(said["prompts"]["target"].is_null());
  EXPECT_TRUE(said["prompts"]["next"].is_null());
}

TEST(PageMessages, StatusTellsOfADatasetsRecordingOnceThereWasOne) {
  Status now = status();
  EXPECT_TRUE(Json::parse(status_json(now, glasses()))["dataset"].is_null());
  now.dataset = DatasetRecording::State{.name = "faces",
                                        .performer = "anna",
                                        .take = "anna.mien",
                                        .lines = 7,
                                        .done = 3,
                                        .over = true,
                                        .error = "the disk is full"};
  EXPECT_EQ(Json::parse(status_json(now, glasses()))["dataset"],
            Json::parse(R"({"name": "faces", "performer": "anna", "take": "anna.mien", "lines": 7, "done": 3,
              "over": true, "error": "the disk is full"})"));
}

TEST(PageMessages, StatusTellsWhoCanSend) {
  Status now = status();
  now.network = {.open = {"udp://0.0.0.0:5005"},
                 .interfaces = {{.name = "lo", .address = "127.0.0.1", .loopback = true}},
                 .only = "lo",
                 .elsewhere = 7,
                 .sealed = true};
  now.report.refused = 9;
  EXPECT_EQ(Json::parse(status_json(now, glasses()))["network"], Json::parse(R"({
      "open": ["udp://0.0.0.0:5005"],
      "interfaces": [{"name": "lo", "address": "127.0.0.1", "loopback": true}],
      "only": "lo", "elsewhere": 7, "sealed": true, "refused": 9, "unsealed": []})"));
}

TEST(PageMessages, ASessionWithoutFramesHasNoLatency) {
  Status now = status();
  const Json none = Json::parse(status_json(now, glasses()))["latency_ms"];
  EXPECT_EQ(none, Json::parse(R"({"p50": null, "p99": null, "max": null})"));
  now.latency.add(std::chrono::milliseconds(5));
  const Json some = Json::parse(status_json(now, glasses()))["latency_ms"];
  EXPECT_EQ(some, Json::parse(R"({"p50": 5.0, "p99": 5.0, "max": 5.0})"));
}

TEST(PageMessages, StatusTellsByHowMuchFramesAreHeld) {
  Status now = status();
  EXPECT_EQ(Json::parse(status_json(now, glasses()))["hold_ms"], 0.0);
  now.report.hold = std::chrono::milliseconds(45);
  EXPECT_EQ(Json::parse(status_json(now, glasses()))["hold_ms"], 45.0);
}

TEST(PageMessages, StatusTellsWhatIsLeftOfTheLog) {
  Status now = status();
  now.recording.log = {.bytes = 1'500'000'000,
                       .limit = 4'000'000'000,
                       .payload_bytes = 1'000'000'000,
                       .payload_limit = 2'000'000'000,
                       .seconds_left = 5400};
  EXPECT_EQ(Json::parse(status_json(now, glasses()))["log"],
            Json::parse(R"({"megabytes": 1500.0, "limit_megabytes": 4000.0, "payload_megabytes": 1000.0,
    "payload_limit_megabytes": 2000.0, "hours_left": 1.5, "error": null})"));
  now.recording.log.seconds_left.reset();
  now.recording.unable = "the disk is full";
  const Json said = Json::parse(status_json(now, glasses()))["log"];
  EXPECT_TRUE(said["hours_left"].is_null());
  EXPECT_EQ(said["error"], "the disk is full");
}

TEST(PageMessages, StatusSaysWhatIsHeardAndWhatStandsAgainstIt) {
  Status now = status();
  const auto hearing = [&] { return Json::parse(status_json(now, glasses()))["hearing"]; };
  EXPECT_TRUE(hearing().is_null()) << "no microphone";
  now.hearing.shut = true;
  EXPECT_EQ(hearing()["shut"], true) << "who shut it is shown that";
  EXPECT_EQ(hearing()["on"], false);
  now.hearing.shut = false;
  now.report.hearing = session::Report::Hearing{
      .on = true, .speaks = true, .share = 0.25, .later = std::chrono::milliseconds(35)};
  now.hearing.handed_over = 50;
  EXPECT_EQ(hearing(),
            Json::parse(R"({"on": true, "speaks": true, "share": 0.25, "later_ms": 35.0, "shut": false,
                                       "blocks": 50, "trouble": null, "browser": null})"));
  now.hearing.trouble = "no sound";
  now.hearing.browser = HearingState::Browser{.heard = true, .refused = 3};
  EXPECT_EQ(hearing()["trouble"], "no sound");
  EXPECT_EQ(hearing()["browser"], Json::parse(R"({"heard": true, "refused": 3})"));
  EXPECT_EQ(Json::parse(microphone_json("why")),
            Json::parse(R"({"type": "microphone", "on": false, "why": "why"})"));
}

}  // namespace
}  // namespace mien::live::page_messages_test
