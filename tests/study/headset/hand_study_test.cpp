#include "mien/study/headset/hand_study.h"

#include <gmock/gmock.h>

#include <cmath>

#include "mien/builtin_face/builtin_face.h"
#include "mien/core/files.h"
#include "mien/study/headset/hand_sheet.h"
#include "tests/headset/small_model.h"
#include "tests/project_path.h"
#include "tests/study/speech/letter_speaker.h"

namespace mien::study::hand_study_test {
namespace {

using face::OutputFrame;
using face::Provenance;

const HandScene& scene() {
  static const HandScene scene = [] {
    HandScene out;
    out.rig = sensor::read_rig(project_path("rigs/headset.toml")).value();
    out.model = headset::test::small_model_with_memory();
    out.network = speech::read_speech_network(project_path("models/speech.safetensors")).value();
    return out;
  }();
  return scene;
}

Result<std::vector<HandPerson>> study(int people, unsigned threads) {
  HandStudyRequest request;
  request.people = people;
  request.hand_s = 0.5;
  request.threads = threads;
  return study_hand(request, scene(), test::letter_speaker(), no_progress);
}

TEST(HandStudy, MeasuresWhatTheHandDoesWithSoundAndWithout) {
  const auto people = study(1, 1);
  ASSERT_TRUE(people) << people.error().message();
  ASSERT_EQ(people->size(), 1U);
  const HandPerson& person = people->front();
  EXPECT_EQ(person.seed, 1U);
  EXPECT_FALSE(person.voice.empty());
  ASSERT_EQ(person.moments.size(), 30U + 30U + 90U);
  EXPECT_NEAR(person.moments.front().time_s, -0.5, 1e-9);
  for (const HandRow* row : {&person.held, &person.heard}) {
    EXPECT_GT(row->over.jerk_ratio, 0);
    EXPECT_GT(row->over.mouth_mm, 0);
    EXPECT_GE(row->over.notice_s, 0);
    EXPECT_GE(row->over.recover_s, 0);
  }
  // A network that has learnt nothing is moved by a hand, and until then shows the same with sound as
  // without.
  EXPECT_GT(person.held.mouth_change, 0);
  // The picture shows the hand: it is another one than a frame before.
  const auto &before = person.moments[29].mouth_view, &under = person.moments[30].mouth_view;
  double change = 0;
  for (std::size_t p = 0; p < under.size(); ++p) change += std::abs(int{under[p]} - int{before[p]});
  EXPECT_GT(change / static_cast<double>(under.size()), 10);

  const auto sheet = hand_sheet(person, 0.5, builtin_face::make_builtin(), "");
  ASSERT_TRUE(sheet) << sheet.error().message();
  EXPECT_EQ(sheet->width, 6 * 152);
  EXPECT_EQ(sheet->height, 4 * 152);
  EXPECT_FALSE(hand_sheet({}, 0.5, builtin_face::make_builtin(), ""));

  const face::Face face = builtin_face::make_builtin();
  auto painter = HandPainter::create(face, "");
  ASSERT_TRUE(painter) << painter.error().message();
  const render::Image first = painter->across(person.moments[29]),
                      second = painter->across(person.moments[30]);
  EXPECT_EQ(first.width, 4 * 152);
  EXPECT_EQ(first.height, 152);
  EXPECT_NE(first.rgb, second.rgb);
  // As long as the moments, and somebody speaks.
  EXPECT_NEAR(person.sound.duration_s(), static_cast<double>(person.moments.size()) / 60, 1e-3);
  EXPECT_GT(std::ranges::max(person.sound.samples), 0.01F);
}

TEST(HandStudy, RefusesNobodyAndOtherSensors) {
  EXPECT_FALSE(study(0, 1));
  HandScene other = scene();
  other.rig = sensor::read_rig(project_path("rigs/imu_headset.toml")).value();
  const auto refused = study_hand({}, other, test::letter_speaker(), no_progress);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message(), ::testing::HasSubstr("cameras alone"));
}

}  // namespace
}  // namespace mien::study::hand_study_test
