#include "mien/session/command.h"

#include <gtest/gtest.h>

#include <string>

namespace mien::session::command_test {
namespace {

TEST(Command, AreWrittenAsTheyAreRead) {
  for (
      const char* text :
      {R"({"command":"calibrate","kind":"short"})",
       R"({"command":"calibrate","kind":"full"})",
       R"({"command":"calibrate","kind":"wearer"})",
       R"({"command":"calibrate","kind":"gaze"})",
       R"({"command":"cancel_calibration"})",
       R"({"command":"use_calibration","version":3})",
       R"({"calibration":"{\"a\":1}","command":"restore_calibration"})",
       R"({"command":"recentre"})",
       R"({"command":"bind","device":"02:4D:49:45:4E:07/1","sensor":"mentalis"})",
       R"({"command":"hear","sensor":"mentalis","source":"udp://192.168.1.7:5005"})",
       R"({"command":"prompt","name":"smile","say":"","seconds":2.5,"target":{"jawOpen":0.1,"mouthSmile_L":1}})",
       R"({"command":"prompts","do":"pause"})",
       R"({"command":"prompts","do":"stop"})",
       R"({"command":"prompts","do":"begin"})",
       R"({"command":"prompts","do":"next"})",
       R"({"command":"prompts","do":"again"})",
       R"({"command":"prompts","do":"voice"})",
       R"({"block":"calm","command":"prompt","emotion":"joy","language":"en","name":"a","own_pace":true,"say":"","seconds":3.0,"target":{},"text":"Read."})",
       R"({"command":"consent_over"})",
       R"({"command":"consent","performer":"anna","purpose":"a model","recorded_by":"us","sound":true,"video":true})",
       R"({"command":"cover","sensor":"eye_L"})",
       R"({"command":"view","crop":[0.1,0.0,0.5,1.0],"mirror":true,"sensor":"eye_L","turn_deg":270})",
       R"({"command":"view","mirror":false,"sensor":"eye_L"})",
       R"({"command":"tap","sensor":""})",
       R"({"command":"shape","gains":{"jawOpen":2},"smoothing":0.5})"}) {
    const auto command = parse_command(text);
    ASSERT_TRUE(command) << text << ": " << command.error().message();
    EXPECT_EQ(write_command(*command), text);
  }
}

TEST(Command, TakesOnlyWhatItsKindHas) {
  const auto bind = parse_command(
      R"({"id": 7, "command": "bind", "sensor": "mentalis", "device": "02:4d:49:45:4e:07", "more": [1]})");
  ASSERT_TRUE(bind);
  EXPECT_EQ(std::get<Bind>(*bind).sensor, "mentalis");
  EXPECT_EQ(std::get<Bind>(*bind).device, (sensor::DeviceKey{0x024D'4945'4E07, 0}));
  const auto shape = parse_command(R"({"command": "shape", "limits": {}, "id": 3})");
  ASSERT_TRUE(shape);
  EXPECT_EQ(std::get<Shape>(*shape).json, R"({"limits":{}})");
  const auto lids = parse_command(R"({"command": "shape", "lids_follow_eyes": false})");
  ASSERT_TRUE(lids);
  EXPECT_EQ(std::get<Shape>(*lids).json, R"({"lids_follow_eyes":false})");
  const auto rules = parse_command(R"({"command": "shape", "constraints": true, "rules": ""})");
  ASSERT_TRUE(rules);
  EXPECT_EQ(std::get<Shape>(*rules).json, R"({"constraints":true,"rules":""})");
  const auto merge = parse_command(R"({"command": "shape", "merge": {"order": {"jaw": ["imu"]}}})");
  ASSERT_TRUE(merge);
  EXPECT_EQ(std::get<Shape>(*merge).json, R"({"merge":{"order":{"jaw":["imu"]}}})");
  EXPECT_TRUE(std::get<Calibrate>(*parse_command(R"({"command": "calibrate", "kind": "full"})")).kind ==
              Calibrate::Kind::full);
}

TEST(Command, APromptHasThreeSecondsAndNothingToSayUnlessItSaysSo) {
  const auto command = parse_command(R"({"command": "prompt", "name": "rest"})");
  ASSERT_TRUE(command) << command.error().message();
  const Prompt& prompt = std::get<AddPrompt>(*command).prompt;
  EXPECT_EQ(prompt.name, "rest");
  EXPECT_EQ(prompt.say, "");
  EXPECT_EQ(prompt.seconds, 3);
  EXPECT_EQ(prompt.target, face::BlendshapeWeights());
}

TEST(Command, RefusesEachMistakeAlone) {
  const std::pair<const char*, ErrorCode> mistakes[] = {
      {"", ErrorCode::malformed},
      {"{", ErrorCode::malformed},
      {"[]", ErrorCode::malformed},
      {"null", ErrorCode::malformed},
      {"{}", ErrorCode::malformed},
      {R"({"command": 7})", ErrorCode::malformed},
      {R"({"command": "dance"})", ErrorCode::unsupported},
      {R"({"command": "record", "on": true})", ErrorCode::unsupported},
      {R"({"command": "calibrate"})", ErrorCode::malformed},
      {R"({"command": "calibrate", "kind": "long"})", ErrorCode::malformed},
      {R"({"command": "use_calibration"})", ErrorCode::malformed},
      {R"({"command": "use_calibration", "version": 1.5})", ErrorCode::malformed},
      {R"({"command": "use_calibration", "version": "1"})", ErrorCode::malformed},
      {R"({"command": "restore_calibration", "calibration": {}})", ErrorCode::malformed},
      {R"({"command": "bind", "sensor": "mentalis"})", ErrorCode::malformed},
      {R"({"command": "bind", "device": "02:4D:49:45:4E:07"})", ErrorCode::malformed},
      {R"({"command": "bind", "sensor": "mentalis", "device": "02:4D:49:45:4E"})", ErrorCode::malformed},
      {R"({"command": "tap"})", ErrorCode::malformed},
      {R"({"command": "cover"})", ErrorCode::malformed},
      {R"({"command": "view"})", ErrorCode::malformed},
      {R"({"command": "view", "mirror": true})", ErrorCode::malformed},
      {R"({"command": "view", "sensor": "eye_L"})", ErrorCode::malformed},
      {R"({"command": "view", "sensor": "eye_L", "mirror": 1})", ErrorCode::malformed},
      {R"({"command": "view", "sensor": "eye_L", "turn_deg": 90.5})", ErrorCode::malformed},
      {R"({"command": "view", "sensor": "eye_L", "crop": [0, 0, 1]})", ErrorCode::malformed},
      {R"({"command": "view", "sensor": "eye_L", "crop": [0, 0, 1, null]})", ErrorCode::malformed},
      {R"({"command": "view", "sensor": "eye_L", "crop": {"left": 0}})", ErrorCode::malformed},
      {R"({"command": "view", "sensor": "eye_L", "crop": [0, 0, 1, 1e999]})", ErrorCode::malformed},
      {R"({"command": "prompts"})", ErrorCode::malformed},
      {R"({"command": "correct", "lags": [0]})", ErrorCode::malformed},
      {R"({"command": "correct", "network": "0123456789abcdef", "hundred_thousandths": [1]})",
       ErrorCode::mismatch},
      {R"({"command": "prompt", "name": "a", "own_pace": 1})", ErrorCode::malformed},
      {R"({"command": "prompt", "name": "a", "text": 1})", ErrorCode::malformed},
      {R"({"command": "consent", "performer": "a", "purpose": "b", "recorded_by": "c"})",
       ErrorCode::malformed},
      {R"({"command": "consent", "performer": "a", "purpose": "b", "recorded_by": "c", "sound": true, "video": 1})",
       ErrorCode::malformed},
      {R"({"command": "consent", "performer": " ", "purpose": "b", "recorded_by": "c", "sound": false})",
       ErrorCode::out_of_range},
      {R"({"command": "prompts", "do": "dance"})", ErrorCode::malformed},
      {R"({"command": "prompt"})", ErrorCode::malformed},
      {R"({"command": "prompt", "name": ""})", ErrorCode::out_of_range},
      {R"({"command": "prompt", "name": "a", "say": 1})", ErrorCode::malformed},
      {R"({"command": "prompt", "name": "a", "seconds": "3"})", ErrorCode::malformed},
      {R"({"command": "prompt", "name": "a", "seconds": 1e9})", ErrorCode::out_of_range},
      {R"({"command": "prompt", "name": "a", "target": [1]})", ErrorCode::malformed},
      {R"({"command": "prompt", "name": "a", "target": {"nose": 1}})", ErrorCode::malformed},
      {R"({"command": "prompt", "name": "a", "target": {"jawOpen": "1"}})", ErrorCode::malformed},
      {R"({"command": "prompt", "name": "a", "target": {"jawOpen": -1}})", ErrorCode::out_of_range},
      {R"({"command": "tap", "sensor": null})", ErrorCode::malformed},
      {R"({"command": "shape", "gains": [[[[[[[[[[1]]]]]]]]]]})", ErrorCode::malformed},
      {R"({"command": "shape", "smoothing": 0.5, "smoothness": 1})", ErrorCode::malformed},
  };
  for (const auto& [text, code] : mistakes) {
    const auto command = parse_command(text);
    ASSERT_FALSE(command) << text;
    EXPECT_EQ(command.error().code, code) << text << ": " << command.error().message();
  }
}

TEST(Command, AShapeNamesTheKeyThatItDoesNotKnow) {
  const auto command = parse_command(R"({"command": "shape", "id": 1, "gain": {"jawOpen": 2}})");
  ASSERT_FALSE(command);
  const std::string message = command.error().message();
  EXPECT_NE(message.find("\"gain\""), std::string::npos) << message;
  EXPECT_NE(message.find("smoothing, resting, blinks_per_min, lids_follow_eyes, gains, limits, constraints, "
                         "rules, merge, off"),
            std::string::npos)
      << message;
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
}

TEST(Command, RefusesWhatIsLongOrDeepBeforeItIsRead) {
  const auto padded = [](std::size_t size) {
    std::string text = R"({"command":"recentre"})";
    return text + std::string(size - text.size(), ' ');
  };
  EXPECT_TRUE(parse_command(padded(kMaxCommandBytes)));
  EXPECT_EQ(parse_command(padded(kMaxCommandBytes + 1)).error().code, ErrorCode::out_of_range);
  EXPECT_EQ(parse_command(std::string(60'000, '[')).error().code, ErrorCode::malformed);
}

TEST(Command, KnowsWhichAreTheSessions) {
  for (const char* name : {"calibrate", "cancel_calibration", "use_calibration", "restore_calibration",
                           "recentre", "bind", "tap", "cover", "view", "shape", "prompt", "prompts"}) {
    EXPECT_TRUE(is_session_command(name)) << name;
    // Whatever is wrong with it, its name is known.
    const auto command = parse_command(std::string(R"({"command": ")") + name + "\"}");
    EXPECT_TRUE(command || command.error().code != ErrorCode::unsupported) << name;
  }
  for (const char* name : {"", "record", "sink", "replay", "takes", "Tap"})
    EXPECT_FALSE(is_session_command(name)) << name;
}

}  // namespace
}  // namespace mien::session::command_test
