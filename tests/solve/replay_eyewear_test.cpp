// A performed take of smart eyewear.
#include <gtest/gtest.h>

#include "mien/session/command.h"
#include "mien/solve/solve.h"
#include "mien/virtual/perform_take.h"
#include "tests/folder.h"
#include "tests/project_path.h"
#include "tests/virtual/three_sensors.h"

namespace mien::solve::replay_eyewear_test {
namespace {

const std::size_t kJaw = face::shape("jawOpen");

/// A second of a talking wearer after a short prologue, as mien perform writes it.
const take::Take& performed_take() {
  static const mien::test::Folder folder;
  static const take::Take take = [] {
    virt::PerformRequest request;
    request.rig = project_path("rigs/eyewear.toml");
    request.motion = virt::test::talking(60);
    request.take = folder / "performed.mien";
    request.seed = 5;
    request.software = "mien test";
    const auto done = virt::perform_take(request, no_progress);
    EXPECT_TRUE(done) << (done ? "" : done.error().message());
    return take::Take::open(request.take).value();
  }();
  return take;
}

const std::filesystem::path kModel = project_path("models/eyewear.safetensors");

Result<Solution> solved(const Progress& progress = no_progress) {
  return replay_take(performed_take(), kModel, progress);
}

TEST(ReplayEyewear, GivesTheSameBitsEachTime) {
  const auto solution = solved();
  ASSERT_TRUE(solution) << solution.error().message();
  EXPECT_EQ(solution->frames.size(), performed_take().ticks()->size());
  EXPECT_TRUE(solution->ridge.empty());
  EXPECT_EQ(solved()->hash, solution->hash);
}

TEST(ReplayEyewear, TheLogsPrologueCalibrates) {
  const auto entries = performed_take().entries().value();
  EXPECT_EQ(entries.front().source, session::kPageSource);
  const Solution solution = solved().value();
  EXPECT_GT(solution.observed, 0.99);
  EXPECT_FALSE(solution.uncalibrated);
  EXPECT_EQ(solution.frames.front().provenance[kJaw], face::Provenance::neutral);
  EXPECT_NE(solution.frames.back().provenance[kJaw], face::Provenance::neutral);
  const auto truth = own_truth(performed_take());
  ASSERT_TRUE(truth) << truth.error().message();
  EXPECT_EQ(with_truth("performed", solution, *truth).model.size(), solution.frames.size());
}

TEST(ReplayEyewear, IsStopped) {
  const auto stopped = solved([](double, std::string_view) { return false; });
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace mien::solve::replay_eyewear_test
