#include "app/live/session_message.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "mien/live/page_messages.h"
#include "tests/virtual/three_sensors.h"

namespace mien::app::session_message_test {
namespace {

using nlohmann::json;

live::Status status() {
  live::Status out;
  out.report.time = DeviceTime(from_seconds(12.5));
  out.report.shaping = "{}";
  out.report.links.resize(3);
  out.report.links[0].health.state = sensor::LinkState::good;
  out.report.links[1].health.state = sensor::LinkState::lost;
  session::Report::Calibration& calibration = out.report.calibration;
  calibration.state = "running";
  calibration.step = "nod";
  calibration.prompt = "Nod";
  calibration.progress = 0.25;
  calibration.remaining_s = 3.5;
  calibration.age_s = 4320;
  calibration.sigma_rad = 0.05 * 3.14159265358979 / 0.9;  // 10 degrees.
  calibration.in_force = 2;
  calibration.versions.resize(2);
  calibration.versions[0] = {1, DeviceTime(from_seconds(3)), "self", "", "", "", {}};
  calibration.versions[1] = {
      2,
      DeviceTime(from_seconds(10.5)),
      "guided",
      "",
      "",
      "",
      {{"nod", 21.5, "deg", true, "the nod was large enough"}, {"neutral", 5, "dps", false, "again"}}};
  return out;
}

json status_object() {
  return json::parse(live::status_json(status(), virt::test::three_sensors()));
}

TEST(SessionMessage, AStatusComesBackAsTheSessionWroteIt) {
  const session::Report written = status().report;
  const auto message = parse_session_message(live::status_json(status(), virt::test::three_sensors()));
  ASSERT_TRUE(message) << message.error().message();
  const auto* read = std::get_if<SessionStatus>(&*message);
  ASSERT_NE(read, nullptr);
  EXPECT_EQ(read->time_s, 12.5);
  ASSERT_EQ(read->links.size(), 3U);
  EXPECT_EQ(read->links[0].sensor, virt::test::three_sensors().sensors[0].name);
  EXPECT_EQ(read->links[0].state, "good");
  EXPECT_EQ(read->links[1].state, "lost");
  EXPECT_TRUE(read->links[0].received());
  EXPECT_FALSE(read->links[1].received());
  EXPECT_FALSE(read->links[2].received());  // Silent.
  const session::Report::Calibration& calibration = read->calibration;
  EXPECT_EQ(calibration.state, "running");
  EXPECT_EQ(calibration.step, "nod");
  EXPECT_EQ(calibration.prompt, "Nod");
  EXPECT_EQ(calibration.progress, 0.25);
  EXPECT_EQ(calibration.remaining_s, 3.5);
  EXPECT_EQ(calibration.in_force, 2);
  EXPECT_EQ(calibration.age_s, 4320);
  EXPECT_EQ(calibration.recentred_s, std::nullopt);
  ASSERT_TRUE(calibration.sigma_rad);
  EXPECT_NEAR(*calibration.sigma_rad, *written.calibration.sigma_rad, 1e-3);
  ASSERT_EQ(calibration.versions.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    const session::CalibrationVersion& is = calibration.versions[i];
    const session::CalibrationVersion& was = written.calibration.versions[i];
    EXPECT_EQ(is.id, was.id);
    EXPECT_EQ(is.made, was.made);
    EXPECT_EQ(is.origin, was.origin);
    EXPECT_EQ(is.scores, was.scores);
  }
}

TEST(SessionMessage, RepliesEventsAndWhatIsPassedOver) {
  const auto yes = parse_session_message(live::reply_json(7, ""));
  ASSERT_TRUE(yes);
  EXPECT_EQ(std::get<SessionReply>(*yes).id, 7);
  EXPECT_EQ(std::get<SessionReply>(*yes).error, "");
  EXPECT_EQ(std::get<SessionReply>(*parse_session_message(live::reply_json(8, "no"))).error, "no");
  const auto event = parse_session_message(live::event_json("recentre_failed", "{}"));
  ASSERT_TRUE(event);
  EXPECT_EQ(std::get<SessionEvent>(*event).kind, "recentre_failed");
  for (const char* other :
       {R"({"type": "hello"})", R"({"type": "frame", "weights": 3})", R"({"type": ""})"}) {
    const auto message = parse_session_message(other);
    ASSERT_TRUE(message) << other;
    EXPECT_TRUE(std::holds_alternative<std::monostate>(*message));
  }
}

TEST(SessionMessage, EachFieldThatIsMissingOrOfAnotherTypeIsSeen) {
  const json good = status_object();
  ASSERT_TRUE(parse_session_message(good.dump()));
  using Pointer = json::json_pointer;
  for (const char* field : {"/type",
                            "/time",
                            "/links",
                            "/links/0/sensor",
                            "/links/2/state",
                            "/calibration",
                            "/calibration/state",
                            "/calibration/step",
                            "/calibration/prompt",
                            "/calibration/progress",
                            "/calibration/remaining_s",
                            "/calibration/versions",
                            "/calibration/versions/1/id",
                            "/calibration/versions/1/time",
                            "/calibration/versions/1/origin",
                            "/calibration/versions/1/in_force",
                            "/calibration/versions/1/scores",
                            "/calibration/versions/1/scores/0/name",
                            "/calibration/versions/1/scores/0/value",
                            "/calibration/versions/1/scores/0/unit",
                            "/calibration/versions/1/scores/0/pass",
                            "/calibration/versions/1/scores/0/sentence"}) {
    const Pointer at(field);
    json missing = good;
    missing[at.parent_pointer()].erase(at.back());
    EXPECT_FALSE(parse_session_message(missing.dump())) << field;
    for (const json& odd : {json(nullptr), json::array({1}), json::array({json::array()})}) {
      json wrong = good;
      wrong[at] = odd;
      EXPECT_FALSE(parse_session_message(wrong.dump())) << field << " " << odd;
    }
  }
}

TEST(SessionMessage, WhatCannotBeMeantIsRefused) {
  for (const char* text :
       {"", "{", "[]", "null", "3", "{}", R"({"type": 1})", R"({"type": "reply", "id": 1, "ok": true})",
        R"({"type": "reply", "id": 1.5, "ok": true, "error": ""})",
        R"({"type": "reply", "id": 18446744073709551615, "ok": true, "error": ""})",
        R"({"type": "reply", "id": 1, "ok": true, "error": "no"})",
        R"({"type": "reply", "id": 1, "ok": false, "error": ""})", R"({"type": "event", "kind": "a"})",
        R"({"type": "status", "time": 1e999})"})
    EXPECT_FALSE(parse_session_message(text)) << text;
  json late = status_object();
  late["calibration"]["age_s"] = 1e300;
  EXPECT_FALSE(parse_session_message(late.dump()));
  late["calibration"].erase("age_s");
  late["calibration"].erase("sigma_deg");
  EXPECT_TRUE(parse_session_message(late.dump())) << "sessions of before did not tell them";
  late["calibration"]["versions"][0]["time"] = 1e300;
  const auto message = parse_session_message(late.dump());
  ASSERT_FALSE(message);
  EXPECT_EQ(message.error().code, ErrorCode::out_of_range);
  const std::string deep(std::size_t{1} << 20U, '[');
  EXPECT_FALSE(parse_session_message(deep));
  const std::string longest = R"({"type": ")" + std::string(kMaxSessionMessageBytes, 'x') + "\"}";
  EXPECT_EQ(parse_session_message(longest).error().code, ErrorCode::out_of_range);
}

}  // namespace
}  // namespace mien::app::session_message_test
