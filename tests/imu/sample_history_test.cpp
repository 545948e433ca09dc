#include "mien/imu/sample_history.h"

#include <gtest/gtest.h>

#include <vector>

namespace mien::imu::sample_history_test {
namespace {

using Place = SampleHistory::Place;

DeviceTime at(int i) {
  return DeviceTime(std::chrono::milliseconds(1000 + 4 * i));
}

/// The `i`th sample, in packets of four.
FusionInput sample(int i) {
  FusionInput in;
  in.time = at(i);
  in.sequence = static_cast<std::uint32_t>(i / 4);
  in.values[0] = static_cast<float>(i);
  return in;
}

struct Filled {
  explicit Filled(int count, int left_out = -1) {
    for (int i = 0; i < count; ++i) {
      if (i == left_out) continue;
      EXPECT_EQ(history.insert(sample(i)), Place::newest);
      integrate(history[history.size() - 1]);
    }
  }
  void integrate(const FusionInput& in) {
    state.newest = in.time;
    ++state.lost;  // Counts what was integrated.
    history.integrated(state);
  }
  SampleHistory history;
  Integration state;
};

TEST(SampleHistory, KeepsTheNewestInOrder) {
  const Filled filled(200);
  const SampleHistory& history = filled.history;
  ASSERT_EQ(history.size(), SampleHistory::kSize);
  EXPECT_EQ(history.newest(), at(199));
  for (std::size_t i = 0; i < history.size(); ++i)
    EXPECT_EQ(history[i].time, at(200 - static_cast<int>(SampleHistory::kSize) + static_cast<int>(i)));
  EXPECT_EQ(history.first_after(at(198)), history.size() - 1);
  EXPECT_EQ(history.first_after(at(199)), history.size());
}

TEST(SampleHistory, PutsALateOneInItsPlaceAndKnowsTheStateBefore) {
  for (int late = 145; late < 199; ++late) {
    Filled filled(200, late);
    ASSERT_EQ(filled.history.insert(sample(late)), Place::late) << late;
    const Integration before = filled.history.before(at(late));
    ASSERT_TRUE(before.newest);
    EXPECT_LT(*before.newest, at(late));
    EXPECT_GE(*before.newest, at(late - 9));
    // Counted without the late one, all before that state are in it.
    EXPECT_EQ(at(static_cast<int>(before.lost) - 1), *before.newest);
    // What is integrated anew ends with all of them.
    filled.state = before;
    for (std::size_t i = filled.history.first_after(*before.newest); i < filled.history.size(); ++i)
      filled.integrate(filled.history[i]);
    EXPECT_EQ(filled.state.lost, 200u);
    EXPECT_EQ(filled.state.newest, at(199));
    // And another one, earlier, is not misled by what was void.
    EXPECT_LT(*filled.history.before(at(late)).newest, at(late));
  }
}

TEST(SampleHistory, ReachesBackByFiftySixSamples) {
  for (const int count : {70, 123, 200, 201, 202, 203, 204, 205, 206, 207}) {
    Filled filled(count, count - 55);
    EXPECT_EQ(filled.history.insert(sample(count - 55)), Place::late) << count;
  }
}

TEST(SampleHistory, RejectsWhatCameBeforeOrIsTooLateOrAnotherBoards) {
  Filled filled(200, 190);
  EXPECT_EQ(filled.history.insert(sample(189)), Place::rejected);
  EXPECT_EQ(filled.history.insert(sample(199)), Place::rejected);
  EXPECT_EQ(filled.history.insert(sample(100)), Place::rejected);
  FusionInput other = sample(190);
  other.sequence += 1000;
  EXPECT_EQ(filled.history.insert(other), Place::rejected);
  other.sequence = 3;
  EXPECT_EQ(filled.history.insert(other), Place::rejected);
  EXPECT_EQ(filled.history.insert(sample(190)), Place::late);
  EXPECT_EQ(filled.history.insert(sample(190)), Place::rejected);
}

TEST(SampleHistory, ForgetsAll) {
  Filled filled(100);
  filled.history.clear();
  EXPECT_EQ(filled.history.size(), 0u);
  EXPECT_FALSE(filled.history.newest());
  EXPECT_EQ(filled.history.insert(sample(5)), Place::newest);
  EXPECT_EQ(filled.history.insert(sample(4)), Place::rejected) << "no state is known from before";
}

}  // namespace
}  // namespace mien::imu::sample_history_test
