#include "lab/bench/attacked_session.h"

#include <gmock/gmock.h>

namespace mien::lab::attack_verdict_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A session of few seconds.
AttackFigures figures(double heard, double frames = 300) {
  AttackFigures out;
  out.heard = heard;
  out.frames = frames;
  out.same_bits = true;
  return out;
}

std::vector<std::string> of_board(double heard, double of) {
  return breaches(Attack{}, true, {figures(heard)}, {figures(of)});
}

std::vector<std::string> of_camera(double heard, double of) {
  Attack attack;
  attack.camera = [](const Pictures&, Random) { return CameraTalk(); };
  return breaches(attack, true, {figures(heard)}, {figures(of)});
}

TEST(AttackVerdict, AHundredthOfReadingsMayBeMissing) {
  EXPECT_THAT(of_board(990, 1000), IsEmpty());
  EXPECT_THAT(of_board(989, 1000), ElementsAre(HasSubstr("98.9 % of the devices' readings")));
}

TEST(AttackVerdict, OfTwoCamerasATenthOfASecondMayWhereThatIsMore) {
  EXPECT_THAT(of_camera(348, 360), IsEmpty());
  EXPECT_THAT(of_camera(347, 360), ElementsAre(HasSubstr("readings accepted")));
  EXPECT_THAT(of_camera(7128, 7200), IsEmpty());
  EXPECT_THAT(of_camera(7127, 7200), ElementsAre(HasSubstr("readings accepted")));
}

TEST(AttackVerdict, NothingOfAStrangersIsAccepted) {
  AttackFigures one = figures(1000);
  one.strangers = 1;
  EXPECT_THAT(breaches(Attack{}, true, {one}, {figures(1000)}), ElementsAre("1 readings of his accepted"));
  one = figures(1000);
  one.same_bits = false;
  EXPECT_THAT(breaches(Attack{}, true, {one}, {figures(1000)}),
              ElementsAre("its take replays to other bits"));
}

TEST(AttackVerdict, FramesAreAddedBeyondTheRateAndNotBeyondAQuietSessionThatDropsSome) {
  AttackFigures quiet = figures(1000), attacked = figures(1000);
  quiet.added = -2;
  EXPECT_THAT(breaches(Attack{}, true, {attacked}, {quiet}), IsEmpty());
  attacked.added = 2;
  EXPECT_THAT(breaches(Attack{}, true, {attacked}, {quiet}), ElementsAre("2 frames added"));
  quiet.added = 1;
  EXPECT_THAT(breaches(Attack{}, true, {attacked}, {quiet}), IsEmpty());
}

}  // namespace
}  // namespace mien::lab::attack_verdict_test
