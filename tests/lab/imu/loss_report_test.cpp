#include "lab/imu/loss_report.h"

#include <gmock/gmock.h>

namespace mien::lab::loss_report_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

LossRow row(Fault fault, double amount, const std::string& sensor, double mse) {
  LossRow out{.condition = {fault, amount, sensor}};
  out.mse = mse;
  out.rise = mse / 0.01 - 1;
  return out;
}

LossStudy small() {
  LossStudy out;
  out.mean_pose_mse = 0.02;
  out.rows = {row(Fault::none, 0, {}, 0.01), row(Fault::loss, 10, {}, 0.0111),
              row(Fault::bursts, 10, {}, 0.0123)};
  return out;
}

TEST(LossReport, ShowsThePromisesTheCurveAndEveryRow) {
  LossStudy study = small();
  study.rows.push_back(row(Fault::sensor_silent, 0, "chin", 0.0107));
  const std::string html = loss_report(study, "who <performed>").html();
  EXPECT_THAT(html, HasSubstr("who &lt;performed&gt;"));
  EXPECT_THAT(html, HasSubstr("+11.0 %"));
  EXPECT_THAT(html, HasSubstr("+25.0 % is promised"));
  EXPECT_THAT(html, HasSubstr("Without chin, the worst to lose"));
  EXPECT_THAT(html, HasSubstr("in bursts of ten packets"));
  EXPECT_THAT(html, HasSubstr("Weight error without one sensor"));
  for (const LossRow& one : study.rows) EXPECT_THAT(html, HasSubstr(one.condition.name()));
}

TEST(LossReport, LeavesOutWhatWasNotStudied) {
  const std::string html = loss_report(small(), "").html();
  EXPECT_THAT(html, Not(HasSubstr("the worst to lose")));
  EXPECT_THAT(html, Not(HasSubstr("Weight error without one sensor")));
}

}  // namespace
}  // namespace mien::lab::loss_report_test
