#include "lab/eyewear/sensors_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "tests/project_path.h"

namespace mien::lab::sensors_report_test {
namespace {

using ::testing::HasSubstr;

SensorsMethod method(const std::string& name, std::size_t sensors, double mm) {
  const SensorsRow row{{mm, mm + 1}, {mm / 2, mm / 2}, {2 * mm, 2 * mm}};
  SensorsMethod out;
  out.name = name;
  out.sensors = sensors;
  out.overall = row;
  out.wearers = {row};
  out.sets.fill(row);
  out.markers = {{mm, mm}, {mm, mm}};
  return out;
}

TEST(SensorsReport, StandsBesideThePublishedFigures) {
  SensorsStudy study;
  study.markers = {"tip", "chin"};
  study.training = {{5000, 321, 0.99}};
  study.faithful = method("faithful", 20, 3.25);
  study.faithful16 = method("faithful16", 16, 4.125);
  study.mean_pose = method("mean_pose", 0, 5);
  for (int i = 0; i < 3000; ++i) {
    study.curve_s.push_back(0.05 * i);
    study.curve_mm.push_back(3);
  }
  MinuteStudy minute;
  for (const char* name : {"neutral", "linear", "learned", "learned16"})
    minute.methods.push_back(method(name, 20, 2.375));
  minute.conditions = {method("remounted_5s", 20, 2.625)};
  const auto report = sensors_report(study, minute, "one wearer", render::Image(4, 4));
  ASSERT_TRUE(report) << report.error().message();
  const std::string html = report->html();
  for (const char* words : {"one wearer", "3.25 mm", "published 3.19 mm", "6.97", "321 of 5000", "chin",
                            "learned", "2.38", "remounted_5s", "image/png"})
    EXPECT_THAT(html, HasSubstr(words));
}

TEST(ErrorPicture, IsDarkerWhereTheErrorIsLarge) {
  const builtin_face::MarkerSet markers =
      builtin_face::read_markers(project_path("rigs/markers.toml")).value();
  SensorsMethod small, large;
  small.name = "small";
  large.name = "large";
  small.markers.assign(markers.markers.size(), {0, 0});
  large.markers.assign(markers.markers.size(), {8, 8});
  const std::array<const SensorsMethod*, 2> both = {&small, &large};
  const auto picture = error_picture(markers, both, 8, 96);
  ASSERT_TRUE(picture) << picture.error().message();
  ASSERT_EQ(picture->width, 192);
  const auto light = [&](int from) {
    long sum = 0;
    for (int y = 30; y < 70; ++y)
      for (int x = from + 30; x < from + 70; ++x) sum += picture->pixel(x, y)[1];
    return sum;
  };
  EXPECT_LT(light(96), 0.8 * static_cast<double>(light(0)));
  small.markers.pop_back();
  EXPECT_FALSE(error_picture(markers, both, 8, 96));
}

}  // namespace
}  // namespace mien::lab::sensors_report_test
