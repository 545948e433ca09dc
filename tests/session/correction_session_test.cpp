#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "mien/model/correction_json.h"
#include "tests/session/session_run.h"

// What a phone taught in a whole session: in force by a command, a version among calibrations, taken back,
// and the same in a replay.
namespace mien::session::correction_session_test {
namespace {

using test::kPrologue_s;

constexpr const char* kNetwork = "0123456789abcdef";

/// TwoShapes whose jaw is multiplied by one and what the correction's bias says of it.
class Corrected final : public tracker::FrameModel {
 public:
  void step(const model::FeatureFrame& features, face::OutputFrame& out) override {
    shapes_.step(features, out);
    out.weights[face::shape("jawOpen")] *= 1 + more_;
  }
  void reset() override {}
  [[nodiscard]] Result<void> check_correction(const model::Correction& correction) const override {
    if (correction.network == kNetwork) return {};
    return fail(ErrorCode::mismatch, "learnt for another model");
  }
  void use_correction(const model::Correction* correction) override {
    more_ = correction == nullptr ? 0 : correction->bias[face::shape("jawOpen")];
  }

 private:
  test::TwoShapes shapes_;
  float more_ = 0;
};

std::unique_ptr<Session> corrected_session() {
  const sensor::Rig rig = virt::test::three_sensors();
  Session::Parts parts;
  parts.rig = rig;
  parts.trackers.push_back(std::make_unique<imu::ImuTracker>(rig, std::make_unique<Corrected>()));
  parts.protocols.push_back(std::make_unique<imu::NodeProtocol>(imu::NodeProtocol::create().value()));
  return Session::create(std::move(parts)).value();
}

/// The jaw is told at half of what it is.
model::Correction halving(const char* network = kNetwork) {
  model::Correction correction{.network = network,
                               .weights = std::vector<float>(face::kShapeCount),
                               .bias = std::vector<float>(face::kShapeCount)};
  correction.bias[face::shape("jawOpen")] = -0.5F;
  return correction;
}
std::string halves() {
  return write_command(Correct{halving()});
}

/// Mean of the jaw between two times of arrival, s.
double jaw(const test::Played& played, double from_s, double to_s) {
  double sum = 0;
  std::size_t count = 0;
  for (const auto& [tick, frame] : played.frames) {
    const double at_s = to_seconds(tick.fired.time_since_epoch());
    if (at_s < from_s || at_s >= to_s) continue;
    sum += frame.weights[face::shape("jawOpen")];
    ++count;
  }
  return sum / static_cast<double>(count);
}

TEST(CorrectionSession, ComesIntoForceAsAVersionThatIsTakenBack) {
  const auto entries = test::performance(12).entries;
  const double at = kPrologue_s + 4, until = at + 4;
  const auto plain = corrected_session();
  const test::Played before = test::run(*plain, entries);
  const auto session = corrected_session();
  const std::vector<test::Order> orders = {{at, halves()},
                                           {until, R"({"command":"use_calibration","version":1})"}};
  const test::Played played = test::run(*session, entries, orders);
  ASSERT_EQ(session->versions().size(), 2u);
  EXPECT_EQ(session->versions()[1].origin, "phone");
  EXPECT_NE(session->versions()[1].json.find("hundred_thousandths"), std::string::npos);
  EXPECT_EQ(session->versions()[0].json.find("hundred_thousandths"), std::string::npos);
  // Shaping smooths a little; a second after each change it is through.
  EXPECT_NEAR(jaw(played, at - 3, at), jaw(before, at - 3, at), 1e-9);
  EXPECT_NEAR(jaw(played, at + 1, until), 0.5 * jaw(before, at + 1, until), 0.02);
  EXPECT_GT(jaw(before, at + 1, until), 0.05) << "there is something to halve";
  EXPECT_NEAR(jaw(played, until + 1, until + 3), jaw(before, until + 1, until + 3), 0.02);

  const auto again = corrected_session();
  EXPECT_EQ(test::run(*again, entries, orders).hash, played.hash);
}

TEST(CorrectionSession, IsRefusedBeforeThereIsACalibrationAndWhereNothingIsCorrected) {
  const auto session = corrected_session();
  const auto early = session->command(HostTime(), halves());
  ASSERT_FALSE(early);
  EXPECT_EQ(early.error().code, ErrorCode::not_found);
  const auto other = test::session()->command(HostTime(), halves());
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().code, ErrorCode::unsupported);
  const auto of_another = session->command(HostTime(), write_command(Correct{halving("fedcba9876543210")}));
  ASSERT_FALSE(of_another);
  EXPECT_EQ(of_another.error().code, ErrorCode::mismatch);
}

TEST(CorrectionSession, AVersionThatIsRestoredInAnotherSessionCorrectsThereToo) {
  const auto entries = test::performance(12).entries;
  const auto first = corrected_session();
  static_cast<void>(test::run(*first, entries, {{kPrologue_s + 1, halves()}}));
  const std::string json = write_command(RestoreCalibration{first->versions().back().json});
  const auto second = corrected_session();
  const test::Played played = test::run(*second, entries, {{kPrologue_s + 1, json}});
  const test::Played plain = test::run(*corrected_session(), entries);
  const double from = kPrologue_s + 3, to = kPrologue_s + 10;
  EXPECT_NEAR(jaw(played, from, to), 0.5 * jaw(plain, from, to), 0.03);

  // One that a phone taught to another model leaves the answers, and says so.
  std::string of_another = json;
  of_another.replace(of_another.find(kNetwork), 16, "fedcba9876543210");
  const auto third = corrected_session();
  const test::Played left = test::run(*third, entries, {{kPrologue_s + 1, of_another}});
  EXPECT_NEAR(jaw(left, from, to), jaw(plain, from, to), 0.03);
  const std::vector<sensor::Score> scores = third->versions().back().scores;
  const auto told = std::ranges::find(scores, "phone", &sensor::Score::name);
  ASSERT_NE(told, scores.end());
  EXPECT_FALSE(told->pass);
}

}  // namespace
}  // namespace mien::session::correction_session_test
