#include "lab/motion_statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>

#include "mien/face/livelink_csv.h"
#include "mien/performer/performer.h"
#include "tests/project_path.h"

namespace mien::lab::motion_statistics_test {
namespace {

using face::shape;

/// jawOpen 0.5 + 0.4 sin at half a hertz, both smiles half of it, the left frown against it.
face::Motion wave(double rate_hz) {
  face::Motion motion;
  for (int i = 0; i < 40 * rate_hz; ++i) {
    face::MotionFrame frame;
    frame.time_s = i / rate_hz;
    const auto s = static_cast<float>(std::sin(std::numbers::pi * frame.time_s));
    frame.weights[shape("jawOpen")] = 0.5F + 0.4F * s;
    frame.weights[shape("mouthSmile_L")] = 0.25F + 0.2F * s;
    frame.weights[shape("mouthSmile_R")] = 0.25F + 0.2F * s;
    frame.weights[shape("mouthFrown_L")] = 0.25F - 0.2F * s;
    motion.frames.push_back(frame);
  }
  return motion;
}

TEST(MotionStatistics, OfASineAreThoseOfASine) {
  for (const double rate_hz : {30.0, 60.0, 100.0}) {
    const std::array motions = {wave(rate_hz)};
    const MotionStatistics s = motion_statistics(motions, "wave");
    const ShapeStatistics& jaw = s.shapes[shape("jawOpen")];
    EXPECT_NEAR(jaw.mean, 0.5, 0.01);
    EXPECT_NEAR(jaw.deviation, 0.4 / std::sqrt(2), 0.005);
    EXPECT_NEAR(jaw.speed_per_s, 0.4 * std::numbers::pi / std::sqrt(2), 0.01);
    EXPECT_NEAR(jaw.p95, 0.5 + 0.4 * std::sin(0.45 * std::numbers::pi), 0.01);
    EXPECT_NEAR(s.correlation(shape("jawOpen"), shape("mouthSmile_L")), 1, 1e-4);
    EXPECT_NEAR(s.correlation(shape("jawOpen"), shape("mouthFrown_L")), -1, 1e-4);
    EXPECT_EQ(s.correlation(shape("jawOpen"), shape("browDown_L")), 0);
    EXPECT_NEAR(s.dimensions, 1, 1e-3);
    EXPECT_NEAR(s.quickness_per_s, std::numbers::pi, 0.03);
  }
}

TEST(MotionStatistics, LeavesOutFramesWithoutFace) {
  auto motion = wave(30);
  for (std::size_t i = 300; i < 400; ++i) {
    motion.frames[i].has_face = false;
    motion.frames[i].weights.values.fill(1000);
  }
  const std::array motions = {motion};
  const MotionStatistics s = motion_statistics(motions, "lost");
  EXPECT_LT(s.shapes[shape("jawOpen")].p95, 1);
  EXPECT_NEAR(s.duration_s, 1100 / 30.0, 0.2);
}

TEST(MotionStatistics, SurvivesNothingAndLittle) {
  EXPECT_EQ(motion_statistics({}, "none").duration_s, 0);
  std::array<face::Motion, 1> one;
  one[0].frames.resize(1);
  EXPECT_EQ(motion_statistics(one, "one").duration_s, 0);
}

TEST(MotionStatistics, MeanOfPeopleDoesNotCountTheirDifferencesAsMotion) {
  auto raised = wave(30);
  for (auto& frame : raised.frames) frame.weights[shape("jawOpen")] += 3;
  const std::array both = {wave(30), raised};
  const std::array people = {motion_statistics(std::span(both).first(1), "a"),
                             motion_statistics(std::span(both).last(1), "b")};
  const auto mean = mean_statistics(people, "mean");
  EXPECT_NEAR(mean.shapes[shape("jawOpen")].deviation, 0.4 / std::sqrt(2), 0.005);
  EXPECT_NEAR(mean.shapes[shape("jawOpen")].mean, 2.0, 0.02);
  EXPECT_NEAR(mean.duration_s, 80, 0.2);
  EXPECT_GT(motion_statistics(both, "pooled").shapes[shape("jawOpen")].deviation, 1.0);
  EXPECT_EQ(mean_statistics({}, "none").duration_s, 0);
}

TEST(MotionStatistics, AMotionAgreesWithItselfMoreThanWithAnother) {
  const auto play = [](performer::Block block) {
    Random random(1);
    const std::array motions = {
        performer::perform(performer::default_script(block, 60), performer::draw_style(random), Random(2))};
    return motion_statistics(motions, "");
  };
  const auto reading = play(performer::Block::reading);
  EXPECT_NEAR(correlation_agreement(reading, reading), 1, 1e-9);
  EXPECT_LT(correlation_agreement(reading, play(performer::Block::free)), 0.9);
}

/// Real performances are only compared with, so the bounds are wide: the same order of range, speed and
/// number of independent motions.
TEST(MotionStatistics, VirtualRangeOfMotionIsOfTheSameOrderAsARealOne) {
  const std::filesystem::path path = project_path("../shared/data/performances/alex_rom_3.csv");
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no real performance at " << path;
  const auto real_motion = face::load_motion(path);
  ASSERT_TRUE(real_motion.has_value()) << real_motion.error().message();
  const auto real = motion_statistics(std::span(&*real_motion, 1), "real");
  std::vector<MotionStatistics> people;
  Random random(1);
  for (std::uint64_t person = 0; person < 8; ++person) {
    const performer::Style style = performer::draw_style(random);
    const std::array motions = {performer::perform(
        performer::default_script(performer::Block::range_of_motion, 120), style, random.fork("p", person))};
    people.push_back(motion_statistics(motions, ""));
  }
  const auto made = mean_statistics(people, "virtual");
  const auto same_order = [](double a, double b) { return a < 2.5 * b && b < 2.5 * a; };
  EXPECT_PRED2(same_order, made.mean_deviation, real.mean_deviation);
  EXPECT_PRED2(same_order, made.mean_p95, real.mean_p95);
  EXPECT_PRED2(same_order, made.mean_speed_per_s, real.mean_speed_per_s);
  EXPECT_PRED2(same_order, made.quickness_per_s, real.quickness_per_s);
  EXPECT_GT(correlation_agreement(made, real), 0.2);
}

TEST(MotionTables, HaveARowAShape) {
  const std::array columns = {motion_statistics({}, "nobody")};
  const std::vector<measure::Table> tables = motion_tables(columns);
  ASSERT_EQ(tables.size(), 2U);
  EXPECT_EQ(tables[0].columns, (std::vector<std::string>{"", "nobody"}));
  EXPECT_EQ(tables[0].rows.size(), kMotionSummaries.size());
  ASSERT_EQ(tables[1].rows.size(), face::kShapeCount);
  for (std::size_t k = 0; k < face::kShapeCount; ++k) EXPECT_EQ(tables[1].rows[k][0], face::kShapeNames[k]);
}

TEST(MotionTables, SayWithWhomTheOthersAgree) {
  const std::array motions = {wave(30)};
  const std::array columns = {motion_statistics(motions, "a"), motion_statistics({}, "nobody")};
  const std::vector<std::vector<std::string>> rows = motion_tables(columns, 1)[0].rows;
  EXPECT_EQ(rows.back(), (std::vector<std::string>{"agreement of correlations with a", "1.00", "0.00"}));
  EXPECT_EQ(rows.front(), (std::vector<std::string>{"seconds", "40", "0"}));
}

VirtualMotionRequest brief(unsigned threads) {
  return {.performers = 2, .seconds = 8, .seed = 3, .threads = threads};
}

TEST(VirtualMotion, IsTheSameOnAnyNumberOfThreads) {
  const auto one = virtual_motion(brief(1), no_progress);
  const auto two = virtual_motion(brief(2), no_progress);
  ASSERT_TRUE(one) << one.error().message();
  ASSERT_TRUE(two) << two.error().message();
  ASSERT_EQ(one->size(), 6U);
  EXPECT_EQ(one->front().name, "range_of_motion");
  EXPECT_EQ(one->back().name, "training");
  const auto means = [](const std::vector<VirtualKind>& kinds) {
    std::vector<MotionStatistics> out;
    for (const VirtualKind& kind : kinds) out.push_back(mean_statistics(kind.people, kind.name));
    return out;
  };
  const std::vector<MotionStatistics> columns = means(*one);
  EXPECT_EQ(motion_tables(columns, columns.size())[0].rows,
            motion_tables(means(*two), columns.size())[0].rows);
  for (const MotionStatistics& kind : columns) {
    EXPECT_NEAR(kind.duration_s, 2 * 8, 0.2) << kind.name;
    EXPECT_GT(kind.mean_deviation, 0) << kind.name;
  }
  EXPECT_GT(columns[1].mean_deviation, columns[3].mean_deviation) << "free is wider than reading";
}

TEST(MotionSpread, SaysWhatLiesOutsideOfPeople) {
  std::vector<MotionStatistics> people(21);
  for (std::size_t i = 0; i < people.size(); ++i) {
    people[i] = motion_statistics({}, "");
    people[i].mean_weight = 0.1 + 0.01 * static_cast<double>(i);
    people[i].shapes[shape("jawOpen")].mean = 0.2;
  }
  std::array compared = {people[10], people[10]};
  compared[1].mean_weight = 0.4;
  compared[1].shapes[shape("jawOpen")].mean = 0.3;
  const std::vector<MotionSpread> spreads = motion_spreads(people, compared);
  ASSERT_EQ(spreads.size(), motion_values(people[0]).size());
  EXPECT_EQ(spreads.front().name, "mean_weight");
  EXPECT_NEAR(spreads.front().low, 0.11, 1e-6);
  EXPECT_NEAR(spreads.front().median, 0.20, 1e-6);
  EXPECT_NEAR(spreads.front().high, 0.29, 1e-6);
  const std::array<std::string, 2> names = {"inside", "outside"};
  const measure::Table table = spread_table(spreads, names);
  EXPECT_EQ(table.columns, (std::vector<std::string>{"", "inside", "outside", "5 %", "median", "95 %"}));
  ASSERT_EQ(table.rows.size(), 3U);
  EXPECT_EQ(table.rows[0][1], std::to_string(spreads.size()));
  EXPECT_EQ(table.rows[0][2], std::to_string(spreads.size() - 2));
  EXPECT_EQ(table.rows[1],
            (std::vector<std::string>{"mean_weight", "0.200", "0.400 !", "0.110", "0.200", "0.290"}));
  EXPECT_EQ(table.rows[2][0], "mean of jawOpen");
}

TEST(VirtualMotion, NeedsSomebodyWhoMoves) {
  EXPECT_EQ(virtual_motion({.performers = 0}, no_progress).error().code, ErrorCode::bad_usage);
  EXPECT_EQ(virtual_motion({.seconds = 0.5}, no_progress).error().code, ErrorCode::bad_usage);
}

}  // namespace
}  // namespace mien::lab::motion_statistics_test
