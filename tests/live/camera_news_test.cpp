#include "mien/live/camera_news.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace mien::live::camera_news_test {
namespace {

HostTime at(double seconds) {
  return HostTime(from_seconds(seconds));
}

CameraStatus camera(bool open, std::uint64_t lost, std::string problem = {}) {
  CameraStatus status;
  status.address = "http://a/";
  status.open = open;
  status.problem = std::move(problem);
  status.lost = lost;
  return status;
}

std::string said(CameraNews& news, double time_s, const CameraStatus& status) {
  const auto sentence = news.tell(at(time_s), status);
  return sentence ? sentence->kind + ": " + sentence->text : std::string();
}

TEST(CameraNews, SaysEachChangeAtOnce) {
  CameraNews news;
  EXPECT_EQ(said(news, 0, camera(false, 0)), "") << "nothing is known yet";
  EXPECT_EQ(said(news, 1, camera(false, 0, "not there")), "camera_lost: http://a/: not there");
  EXPECT_EQ(said(news, 2, camera(false, 0, "not there")), "");
  EXPECT_EQ(said(news, 3, camera(true, 0)), "camera: http://a/: pictures come");
  EXPECT_EQ(said(news, 4, camera(true, 0)), "");
  EXPECT_EQ(said(news, 60, camera(false, 1, "it hung up")), "camera_lost: http://a/: it hung up");
  EXPECT_EQ(said(news, 61, camera(true, 1)), "camera: http://a/: pictures come");
}

TEST(CameraNews, OfOneThatFlapsItSaysEachTenSecondsHowOftenItWent) {
  CameraNews news;
  std::vector<std::string> all;
  std::uint64_t lost = 0;
  for (int i = 0; i < 300; ++i) {  // A minute, five times a second open or lost.
    const bool open = i % 2 == 0;
    if (!open) ++lost;
    const std::string text = said(news, 0.2 * i, camera(open, lost, open ? "" : "it hung up"));
    if (!text.empty()) all.push_back(text);
  }
  ASSERT_GE(all.size(), 8u);
  EXPECT_LE(all.size(), 13u);
  EXPECT_EQ(all[0], "camera: http://a/: pictures come");
  EXPECT_EQ(all[1], "camera_lost: http://a/: it hung up");
  EXPECT_EQ(all[2], "camera: http://a/: pictures come (they ended 24 times since this was said)");
}

TEST(CameraNews, ALossThatWasOverBeforeAnybodyLookedIsSaid) {
  CameraNews news;
  EXPECT_NE(said(news, 0, camera(true, 0)), "");
  EXPECT_EQ(said(news, 20, camera(true, 1)),
            "camera: http://a/: pictures come (they ended 1 time since this was said)");
  EXPECT_EQ(said(news, 40, camera(true, 1)), "");
}

TEST(LineNews, TellsOfACameraInPlaceOfItsLine) {
  LineNews news;
  SerialPort::Status glasses{.address = "serial:/dev/a", .open = true, .problem = {}, .camera = {}};
  SerialPort::Status eye{.address = "serial:/dev/b", .open = true, .problem = {}, .camera = {}};
  const auto tell = [&](double time_s) {
    std::string text;
    for (const auto& sentence : news.tell(at(time_s), std::vector{glasses, eye}))
      text += sentence.kind + ": " + sentence.text + "\n";
    return text;
  };
  EXPECT_EQ(tell(0), "") << "they were open when the session began";
  eye.camera = camera(true, 0);
  eye.camera->address = eye.address;
  EXPECT_EQ(tell(1), "camera: serial:/dev/b: pictures come\n");
  for (SerialPort::Status* line : {&glasses, &eye}) {
    line->open = false;
    line->problem = "unplugged (x)";
  }
  eye.camera->open = false;
  eye.camera->problem = eye.problem;
  eye.camera->lost = 1;
  EXPECT_EQ(tell(2),
            "line_lost: serial:/dev/a is unplugged (x); it is opened again when it is back\n"
            "camera_lost: serial:/dev/b: unplugged (x)\n");
  glasses.open = eye.open = true;
  EXPECT_EQ(tell(3), "line_back: serial:/dev/a is back\n") << "of the camera nothing came yet";
}

}  // namespace
}  // namespace mien::live::camera_news_test
