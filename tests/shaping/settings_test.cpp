#include "mien/shaping/settings.h"

#include <gtest/gtest.h>

namespace mien::shaping::settings_test {
namespace {

TEST(Settings, GoThroughJson) {
  ShaperSettings settings;
  EXPECT_EQ(parse_settings(write_settings(settings), "test").value(), settings);
  settings.smoothing = 0.35;
  settings.smooth_head = true;
  settings.constraints = true;
  settings.lids_follow_eyes = false;
  settings.blinks_per_min = 25;
  settings.off.set(static_cast<std::size_t>(ChainStep::merge)).set(static_cast<std::size_t>(ChainStep::gaze));
  settings.limits.shapes[face::shape("jawOpen")] = {.gain = 1.3f, .low = 0.1f, .high = 0.9f};
  settings.limits.shapes[face::shape("noseSneer_R")].gain = 0;
  settings.fallback = {.hold_s = 0, .neutral_s = 1.5, .return_s = 0.1};
  EXPECT_EQ(parse_settings(write_settings(settings), "test").value(), settings);
}

TEST(Settings, RulesGoThroughJsonAsAFilesText) {
  ShaperSettings settings;
  EXPECT_EQ(write_settings(settings).find("rules"), std::string::npos);
  const std::string own = "[[exclusive]]\na = \"jawLeft\"\nb = \"jawRight\"\n";
  settings.rules = face::RigConstraints::parse(own, "own").value();
  EXPECT_EQ(parse_settings(write_settings(settings), "test").value(), settings);
  // The switch is another's affair.
  const ShaperSettings on = parse_settings(R"({"constraints": true})", "page", settings).value();
  EXPECT_TRUE(on.constraints);
  EXPECT_EQ(on.rules, settings.rules);
  const ShaperSettings none = parse_settings(R"({"rules": ""})", "page", on).value();
  EXPECT_EQ(none.rules, face::RigConstraints());
  EXPECT_EQ(parse_settings(write_settings(none), "test").value(), none);
  EXPECT_EQ(
      parse_settings(R"({"rules": "[[exclusive]]\na = 'jawOpen'\nb = 'jaw'"})", "page").error().message(),
      "page, 'rules', line 3: no shape is called 'jaw'; names are those of the 53, as eyeBlink_L");
}

TEST(Settings, OfMergingGoThroughJsonAndAreLeftOutWhileDefault) {
  ShaperSettings settings;
  EXPECT_EQ(write_settings(settings).find("merge"), std::string::npos);
  settings.merge.sure = 0.7F;
  settings.merge.unsure = 0.1F;
  settings.merge.audio = false;
  settings.merge.order[static_cast<std::size_t>(MergePlace::gaze)] = {"imu"};
  settings.merge.order[static_cast<std::size_t>(MergePlace::mouth)] = {};
  EXPECT_EQ(parse_settings(write_settings(settings), "test").value(), settings);
  const ShaperSettings changed =
      parse_settings(R"({"merge": {"order": {"mouth": ["speech", "imu"]}}})", "page").value();
  EXPECT_EQ(changed.merge.order[static_cast<std::size_t>(MergePlace::mouth)],
            (MergeSettings::Order{"speech", "imu"}));
  EXPECT_EQ(changed.merge.order[static_cast<std::size_t>(MergePlace::jaw)],
            MergeSettings().order[static_cast<std::size_t>(MergePlace::jaw)]);
}

TEST(Settings, WhatIsNotNamedStays) {
  ShaperSettings base;
  base.smoothing = 0.5;
  base.limits.shapes[0].gain = 2;
  base.limits.shapes[1] = {.gain = 0.5f, .low = 0.2f, .high = 0.4f};
  const ShaperSettings changed =
      parse_settings(R"({"gains": {"browDown_R": 3}, "fallback": {"hold_s": 1}})", "page", base).value();
  EXPECT_EQ(changed.smoothing, 0.5);
  EXPECT_EQ(changed.limits.shapes[0].gain, 2);
  EXPECT_EQ(changed.limits.shapes[1], (ShapeLimits{.gain = 3, .low = 0.2f, .high = 0.4f}));
  EXPECT_EQ(changed.fallback, (FallbackSettings{.hold_s = 1}));
  EXPECT_EQ(parse_settings("{}", "page", base).value(), base);
}

TEST(Settings, RefuseWhatCannotBeMeant) {
  const auto code = [](const char* text) { return parse_settings(text, "page").error().code; };
  for (const char* text : {"",
                           "null",
                           "[1]",
                           "{",
                           R"({"smoothing": "much"})",
                           R"({"smoothing": true})",
                           R"({"smooth_head": 1})",
                           R"({"constraints": "ict"})",
                           R"({"rules": true})",
                           R"({"rules": "[[exclusive"})",
                           R"({"resting": 1})",
                           R"({"lids_follow_eyes": "yes"})",
                           R"({"blinks_per_min": true})",
                           R"({"off": "gaze"})",
                           R"({"off": ["eyes"]})",
                           R"({"off": [1]})",
                           R"({"gains": []})",
                           R"({"gains": {"jawopen": 1}})",
                           R"({"gains": {"jawOpen": null}})",
                           R"({"limits": 1})",
                           R"({"limits": {"jawOpen": 1}})",
                           R"({"limits": {"jawOpen": [0]}})",
                           R"({"limits": {"jawOpen": [0, "1"]}})",
                           R"({"limits": {"nose": [0, 1]}})",
                           R"({"fallback": 1})",
                           R"({"fallback": {"hold": 1}})",
                           R"({"fallback": {"hold_s": {}}})",
                           R"({"merge": []})",
                           R"({"merge": {"hold": 1}})",
                           R"({"merge": {"sure": "very"}})",
                           R"({"merge": {"audio": 1}})",
                           R"({"merge": {"order": ["imu"]}})",
                           R"({"merge": {"order": {"nose": ["imu"]}}})",
                           R"({"merge": {"order": {"jaw": "imu"}}})",
                           R"({"merge": {"order": {"jaw": [1]}}})",
                           R"({"merge": {"order": {"jaw": [""]}}})",
                           R"({"merge": {"order": {"jaw": ["IMU"]}}})",
                           R"({"merge": {"order": {"jaw": ["imu", "imu"]}}})",
                           R"({"merge": {"order": {"jaw": ["abcdefghijklmnopqrstuvwxyzabcdefg"]}}})",
                           R"({"colour": 1})",
                           R"({"smoothing": 1e999})"})
    EXPECT_EQ(code(text), ErrorCode::malformed) << text;
  for (const char* text : {R"({"smoothing": 1.1})", R"({"smoothing": -0.1})", R"({"gains": {"jawOpen": 5}})",
                           R"({"gains": {"jawOpen": -1}})", R"({"limits": {"jawOpen": [0.5, 0.4]}})",
                           R"({"limits": {"jawOpen": [-0.1, 1]}})", R"({"limits": {"jawOpen": [0, 1.5]}})",
                           R"({"fallback": {"hold_s": -1}})", R"({"fallback": {"neutral_s": 0}})",
                           R"({"fallback": {"return_s": 11}})", R"({"merge": {"sure": 1.5}})",
                           R"({"merge": {"sure": 0.2}})", R"({"merge": {"unsure": 0.6}})",
                           R"({"merge": {"order": {"jaw": ["a", "b", "c", "d", "e", "f", "g", "h", "i"]}}})"})
    EXPECT_EQ(code(text), ErrorCode::out_of_range) << text;
  EXPECT_EQ(parse_settings(R"({"smoothing": 2})", "page").error().message(),
            "page: 'smoothing' is 2; give 0 to 1");
}

TEST(Settings, SayWhatMayHaveBeenMeant) {
  const auto message = [](const char* text) { return parse_settings(text, "page").error().message(); };
  EXPECT_EQ(message(R"({"smoothign": 1})"), "page: shaping has no 'smoothign'; did you mean smoothing?");
  EXPECT_EQ(message(R"({"colour": 1})"), "page: shaping has no 'colour'");
  EXPECT_EQ(message(R"({"fallback": {"holds": 1}})"),
            "page: 'fallback' has no 'holds'; did you mean hold_s?");
  EXPECT_EQ(message(R"({"gains": {"jawopen": 1}})"),
            "page: no shape is called 'jawopen'; did you mean jawOpen?; names are those of the 53, as "
            "eyeBlink_L");
  EXPECT_EQ(message(R"({"rules": "rigs/constraints/own.toml"})"),
            "page: 'rules' is a file's name, not its text; give the text; mien live takes the file with "
            "--constraints");
}

}  // namespace
}  // namespace mien::shaping::settings_test
