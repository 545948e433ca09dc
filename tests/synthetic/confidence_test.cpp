#include "mien/synthetic/confidence.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mien/core/random.h"
#include "mien/synthetic/confidence_fit.h"

namespace mien::synthetic::confidence_test {
namespace {

/// Weights that come and go, and a tracker whose error grows with the weight and as coverage shrinks.
struct KnownTracker {
  explicit KnownTracker(std::uint64_t seed) : random(seed) {}

  template <typename Use>
  void play(std::size_t frames, float coverage, const Use& use) {
    for (std::size_t f = 0; f < frames; ++f)
      for (std::size_t k = 0; k < face::kShapeCount; ++k) {
        const double phase = 0.05 * static_cast<double>(f) + static_cast<double>(k);
        const double truth = std::max(0.0, std::sin(phase)) * 0.8;
        const double sigma = 0.03 + 0.2 * truth + 0.3 * (1 - static_cast<double>(coverage));
        use(k, std::clamp(truth + sigma * random.normal(), 0.0, 1.0), truth);
      }
  }
  Random random;
};

model::ConfidenceTable known_table() {
  ConfidenceFit fit;
  KnownTracker tracker(1);
  for (const float coverage : {1.0F, 0.6F, 0.0F}) {
    tracker.play(40000, coverage, [&](std::size_t k, double estimate, double truth) {
      fit.add(k, coverage, static_cast<float>(estimate), static_cast<float>(truth));
    });
    fit.end_person();
  }
  return fit.table();
}

float confidence_of(const model::ConfidenceTable& table, std::size_t k, float coverage, float value) {
  const std::size_t row = k * table.coverage_bins() + model::confidence_bin(table.coverage_edges, coverage);
  return table.within[row * table.value_bins() + model::confidence_bin(table.value_edges, value)];
}

TEST(ConfidenceFit, ATrackerOfKnownErrorIsCalibratedOnNewDraws) {
  const model::ConfidenceTable table = known_table();
  ASSERT_TRUE(model::check(table, face::kShapeCount, "test"));
  for (const float coverage : {1.0F, 0.6F, 0.0F}) {
    solve::Reliability told, always;
    KnownTracker(2).play(6000, coverage, [&](std::size_t k, double estimate, double truth) {
      const bool within = std::abs(estimate - truth) <= 0.1;
      told.add(confidence_of(table, k, coverage, static_cast<float>(estimate)), within);
      always.add(coverage, within);
    });
    // What is left is the prior: cells are drawn towards coverages at which this tracker is far worse.
    EXPECT_LT(told.expected_error(), 0.03) << coverage;
    EXPECT_GT(always.expected_error(), 0.05) << "coverage is no probability: " << coverage;
  }
}

TEST(ConfidenceFit, ExplainsLessWithLessCoverage) {
  const model::ConfidenceTable table = known_table();
  const std::size_t bins = table.coverage_bins();
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    EXPECT_GT(table.explained[k * bins + bins - 1], 0.8);
    EXPECT_LT(table.explained[k * bins], 0.5);
    EXPECT_TRUE(std::is_sorted(table.explained.begin() + static_cast<std::ptrdiff_t>(k * bins),
                               table.explained.begin() + static_cast<std::ptrdiff_t>((k + 1) * bins)));
  }
}

TEST(ConfidenceFit, TheThresholdLeavesOutShapesThatDoNotFollow) {
  // Every other shape is noise around its mean: it explains nothing, and correlates with nothing.
  ConfidenceFit fit;
  Random random(3);
  for (int person = 0; person < 4; ++person) {
    KnownTracker(static_cast<std::uint64_t>(person))
        .play(1200, 1, [&](std::size_t k, double estimate, double truth) {
          const double answer = k % 2 == 0 ? estimate : std::clamp(0.3 + 0.1 * random.normal(), 0.0, 1.0);
          fit.add(k, 1, static_cast<float>(answer), static_cast<float>(truth));
        });
    fit.end_person();
  }
  const model::ConfidenceTable table = fit.table();
  const std::size_t bins = table.coverage_bins();
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    EXPECT_EQ(table.explained[k * bins + bins - 1] >= table.measured_from, k % 2 == 0) << k;
}

TEST(ConfidenceFit, AFewCorrelationsMakeNothingMeasured) {
  // One shape alone follows the truth, and it does so well.
  const auto measured_from = [](int people) {
    ConfidenceFit fit;
    Random random(3);
    for (int person = 0; person < people; ++person) {
      KnownTracker(static_cast<std::uint64_t>(person))
          .play(700, 1, [&](std::size_t k, double estimate, double truth) {
            const bool follows = k == face::shape("jawOpen");
            const double answer = follows ? estimate : std::clamp(0.3 + 0.1 * random.normal(), 0.0, 1.0);
            fit.add(k, 1, static_cast<float>(answer), static_cast<float>(truth));
          });
      fit.end_person();
    }
    return fit.table().measured_from;
  };
  EXPECT_EQ(measured_from(24), 1);
  EXPECT_LT(measured_from(60), 0.8);
}

TEST(ConfidenceFit, WithoutACorrelationNothingIsMeasured) {
  ConfidenceFit fit;
  for (int i = 0; i < 10; ++i) fit.add(0, 1, 0.5F, 0.5F);
  fit.end_person();
  EXPECT_EQ(fit.table().measured_from, 1);
}

/// Answers as the known tracker does, a sixteenth of what its shapes are read from lost with each sensor.
class Known final : public WatchedPerson {
 public:
  explicit Known(std::uint64_t seed) : seed_(seed) {}
  [[nodiscard]] std::size_t sensor_count() const override { return 4; }
  [[nodiscard]] Result<Watched> watch(std::size_t lost, const Random& random) const override {
    constexpr std::size_t kFrames = 700;
    Watched out;
    out.answer.resize(kFrames);
    out.truth.resize(kFrames);
    out.coverage.resize(kFrames);
    const float coverage = lost == sensor_count() ? 0 : 1 - static_cast<float>(lost) / 16;
    for (tracker::Coverage& covered : out.coverage) covered.fill(coverage);
    std::size_t at = 0;
    KnownTracker tracker(random.fork("known", seed_).below(1000));
    tracker.play(kFrames, coverage, [&](std::size_t k, double estimate, double truth) {
      out.answer[at / face::kShapeCount][k] = static_cast<float>(estimate);
      out.truth[at++ / face::kShapeCount][k] = static_cast<float>(truth);
    });
    return out;
  }

 private:
  std::uint64_t seed_;
};

TEST(MeasureConfidence, IsTheSameOnAnyNumberOfThreadsWhateverTheSensorsAre) {
  WatchedGroup group{"people", {}};
  for (std::uint64_t p = 0; p < 3; ++p) group.people.push_back(std::make_shared<const Known>(p));
  const auto table = measure_confidence(group, 5, no_progress, 1);
  ASSERT_TRUE(table) << table.error().message();
  EXPECT_EQ(table->people, 3U);
  EXPECT_EQ(*table, measure_confidence(group, 5, no_progress, 2).value());

  const auto rows = study_confidence(*table, {group}, 6, no_progress, 2);
  ASSERT_TRUE(rows) << rows.error().message();
  ASSERT_EQ(rows->size(), 4U);
  for (const ConfidenceRow& row : *rows) {
    EXPECT_EQ(row.people, 3U);
    EXPECT_EQ(row.gaze_measured, 0U);
    // Of many together no error is larger than of the worst of them.
    ASSERT_EQ(row.single.size(), 3U);
    EXPECT_TRUE(std::ranges::is_sorted(row.single));
    EXPECT_LE(row.all.expected_error(), row.single.back() + 1e-12);
  }
  EXPECT_EQ(rows->back().lost, 4U) << "no more than there are";
  EXPECT_EQ(measure_confidence({}, 5, no_progress, 1).error().code, ErrorCode::not_found);
}

/// The known tracker again: clean, and under a fault that leaves its sensors half of what they tell.
class KnownFaulty final : public FaultyPerson {
 public:
  explicit KnownFaulty(std::uint64_t seed) : seed_(seed) {}
  [[nodiscard]] Result<void> watch_each(const See& see) const override {
    const Known known(seed_);
    for (std::size_t fault = 0; fault < 2; ++fault) {
      const std::size_t lost = fault == 0 ? 0 : known.sensor_count();
      MIEN_TRY_ASSIGN(const Watched seen, known.watch(lost, Random(seed_).fork("fault", fault)));
      see(fault, seen);
    }
    return {};
  }

 private:
  std::uint64_t seed_;
};

TEST(FitRegions, IsCalibratedOnOthersCleanAndUnderFaults) {
  WatchedGroup group{"people", {}}, others{"others", {}};
  FaultyGroup faulty{"people", {"clean", "all but lost"}, {}}, other_faulty = faulty;
  for (std::uint64_t p = 0; p < 4; ++p) {
    group.people.push_back(std::make_shared<const Known>(p));
    others.people.push_back(std::make_shared<const Known>(100 + p));
    faulty.people.push_back(std::make_shared<const KnownFaulty>(p));
    other_faulty.people.push_back(std::make_shared<const KnownFaulty>(100 + p));
  }
  model::ConfidenceTable table = measure_confidence(group, 5, no_progress, 1).value();
  const auto maps = fit_regions(table, group, {faulty}, 5, no_progress, 1);
  ASSERT_TRUE(maps) << maps.error().message();
  EXPECT_EQ(*maps, fit_regions(table, group, {faulty}, 5, no_progress, 2).value());
  for (const model::LogisticMap& map : *maps) EXPECT_GT(map.slope, 0) << "surer shapes, a surer region";

  const auto unknown = study_faults(table, {other_faulty}, no_progress, 1);
  table.regions = *maps;
  const auto rows = study_faults(table, {other_faulty}, no_progress, 2);
  ASSERT_TRUE(rows && unknown);
  ASSERT_EQ(rows->size(), 2U);
  EXPECT_EQ(rows->back().fault, "all but lost");
  EXPECT_EQ(rows->back().regions_single.size(), 4U);
  for (std::size_t r = 0; r < rows->size(); ++r) {
    // One map serves all coverages, and this tracker's errors jump from one to the next.
    EXPECT_LT((*rows)[r].regions.all.expected_error(), 0.12) << r;
    EXPECT_EQ((*rows)[r].all.expected_error(), (*unknown)[r].all.expected_error()) << "shapes are as before";
  }
  EXPECT_GT(rows->front().regions.roc.area(), 0.6);
  EXPECT_GT(unknown->front().regions.all.expected_error(), 0.3) << "without maps it is 0, and untrue";
  EXPECT_FALSE(regions_kept(unknown->front()));
  EXPECT_EQ(study_confidence(table, {others}, 6, no_progress, 1)->size(), 4U);
  EXPECT_EQ(fit_regions(table, {}, {}, 5, no_progress, 1).error().code, ErrorCode::not_found);
}

}  // namespace
}  // namespace mien::synthetic::confidence_test
