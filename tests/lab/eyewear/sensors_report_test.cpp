#include "lab/eyewear/sensors_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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
  MinuteStudy minute;
  for (const char* name : {"neutral", "linear", "learned", "learned16"})
    minute.methods.push_back(method(name, 20, 2.375));
  minute.conditions = {method("remounted_5s", 20, 2.625)};
  const std::string html = sensors_report(study, minute, "one wearer").html();
  for (const char* words : {"one wearer", "3.25 mm", "published 3.19 mm", "6.97", "321 of 5000", "chin",
                            "learned", "2.38", "remounted_5s"})
    EXPECT_THAT(html, HasSubstr(words));
}

}  // namespace
}  // namespace mien::lab::sensors_report_test
