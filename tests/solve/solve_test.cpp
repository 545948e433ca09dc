#include "mien/solve/solve.h"

#include <gmock/gmock.h>

#include <cstring>
#include <functional>

#include "mien/core/sha256.h"
#include "mien/modalities/modalities.h"
#include "mien/session/receiver.h"
#include "mien/session/replay.h"
#include "tests/solve/performed_take.h"
#include "tests/tracker/tiny_model.h"

namespace mien::solve::solve_test {
namespace {

using ::testing::HasSubstr;

tracker::WindowSolver solver_for(std::vector<std::string> sensors = {"mentalis", "buccinator_L"}) {
  return tracker::WindowSolver::create(tracker::test::tiny_model(std::move(sensors))).value();
}

Result<Solution> solve(const take::Take& take, const tracker::WindowSolver& solver = solver_for()) {
  return solve_take(take, solver, solver.file().sampler, no_progress);
}

TEST(SamplerOf, IsTheFilesOwnButForTheSteps) {
  const model::ModelFile file = tracker::test::tiny_model({"mentalis"});
  EXPECT_EQ(sampler_of(file, 0), file.sampler);
  model::SamplerSettings asked = file.sampler;
  asked.steps = 5;
  EXPECT_EQ(sampler_of(file, 5), asked);
  EXPECT_EQ(sampler_of(file, file.schedule.levels).kind, model::SamplerKind::ddpm);
}

TEST(Solve, IsTheSameEachTimeAndTheStoredSamplesAreThoseOfTheLog) {
  const mien::test::Folder folder;
  for (const auto& [devices, session] :
       {std::pair{"device", test::device_session()}, std::pair{"lab", test::lab_session()}}) {
    const take::Take take = test::stored(session, folder / devices, devices);
    const Solution solution = solve(take).value();
    EXPECT_EQ(solution.frames.size(), session.ticks.size());
    EXPECT_EQ(solution.hash, solve(take).value().hash) << devices;
    EXPECT_EQ(solution.ridge, solve(take).value().ridge) << devices;

    const auto receiving = modalities::make_receiving_session(take.rig()).value();
    std::vector<sensor::Sample> received;
    session::Peers peers;
    const std::vector<take::LogEntry> entries = take.entries().value();
    for (const take::LogEntry& entry : entries) {
      const auto samples =
          receiving->receive_logged(entry.arrival, peers.of(entry.source), entry.bytes, {}).samples;
      received.insert(received.end(), samples.begin(), samples.end());
    }
    const auto stored = take.samples().value();
    ASSERT_EQ(received.size(), stored.size());
    for (std::size_t i = 0; i < stored.size(); ++i) {
      EXPECT_EQ(received[i].sensor, stored[i].sample.sensor);
      EXPECT_EQ(received[i].time, stored[i].sample.time);
      EXPECT_EQ(received[i].values, stored[i].sample.values);
    }
  }
}

TEST(Replay, IsWhatASessionShowsOfARecordedTakeAndOfAPerformedOne) {
  const mien::test::Folder folder;
  for (const auto& [devices, session] :
       {std::pair{"device", test::device_session()}, std::pair{"lab", test::lab_session()}}) {
    const take::Take take = test::stored(session, folder / devices, devices);
    modalities::LiveModel model("");
    model.imu = tracker::test::tiny_causal_model({"mentalis", "buccinator_L"});
    const Solution replayed = replay_take(take, model, no_progress).value();
    const auto shown = modalities::make_session(take.rig(), model).value();
    ASSERT_TRUE(session::replay(take, *shown, [](const auto&, const auto&) { return true; }));
    EXPECT_EQ(replayed.hash, shown->hash()) << devices;
    EXPECT_EQ(replayed.ridge, solve(take).value().ridge) << "the window model's baseline of the same matrix";
    EXPECT_GT(replayed.observed, 0.99) << devices;
    EXPECT_FALSE(replayed.uncalibrated && std::string(devices) == "device");
    ASSERT_EQ(replayed.frames.size(), session.ticks.size());
    EXPECT_EQ(replayed.frames.back().provenance[0], face::Provenance::measured);
  }
}

TEST(Solve, SensorsReachTheAnswer) {
  const mien::test::Folder folder;
  const take::Take take = test::stored(test::device_session(), folder / "a.mien", "device");
  const Solution solution = solve(take).value();
  // Before the calibration nothing is known; afterwards both sensors are.
  EXPECT_EQ(solution.frames.front().provenance[0], face::Provenance::predicted);
  EXPECT_EQ(solution.frames.back().provenance[0], face::Provenance::measured);
  EXPECT_EQ(solution.frames.back().confidence[0], 1);
  EXPECT_EQ(solution.frames.back().head_provenance, face::Provenance::measured);
  EXPECT_NE(solution.hash, solve(take, solver_for({"buccinator_L", "mentalis"})).value().hash);
}

TEST(Solve, RidgeIsThatOfTheTakesProfile) {
  const mien::test::Folder folder;
  const take::Take lab = test::stored(test::lab_session(), folder / "lab", "lab");
  const take::Take device = test::stored(test::device_session(), folder / "device", "device");
  // tiny_model()'s constants are 0.25 and 0.5; on the neutral face little is added.
  EXPECT_NEAR(solve(lab).value().ridge[30][0], 0.25, 0.1);
  EXPECT_NEAR(solve(device).value().ridge[30][0], 0.5, 0.1);
}

TEST(Solve, PacketsThatAreNoneArePassedOver) {
  const mien::test::Folder folder;
  const virt::VirtualSession session = test::lab_session();
  const Solution clean = solve(test::stored(session, folder / "clean", "lab")).value();
  virt::VirtualSession noisy = session;
  noisy.samples.clear();
  noisy.entries.clear();
  std::vector<std::int64_t> moved = {0};
  for (const take::LogEntry& entry : session.entries) {
    const auto add = [&](std::vector<std::byte> bytes) {
      noisy.entries.push_back({static_cast<std::int64_t>(noisy.entries.size()) + 1, entry.arrival,
                               entry.source, std::move(bytes)});
    };
    if (entry.id % 50 == 1) add({std::byte{1}, std::byte{2}});
    if (entry.id % 50 == 2) {
      std::vector<std::byte> broken = entry.bytes;
      broken.back() ^= std::byte{0x40};
      add(broken);
    }
    add(entry.bytes);
    moved.push_back(noisy.entries.back().id);
  }
  for (take::StoredSample sample : session.samples) {
    sample.entry = moved[static_cast<std::size_t>(sample.entry)];
    noisy.samples.push_back(sample);
  }
  for (take::Tick& tick : noisy.ticks) tick.after_entry = moved[static_cast<std::size_t>(tick.after_entry)];
  const take::Take take = test::stored(noisy, folder / "noisy", "lab");
  ASSERT_GT(take.entries().value().size(), session.entries.size());
  EXPECT_EQ(solve(take).value().hash, clean.hash);
}

TEST(Solve, RefusesATakeWithoutFrames) {
  const mien::test::Folder folder;
  virt::VirtualSession session = test::lab_session();
  session.ticks.clear();
  const take::Take take = test::stored(session, folder / "no-ticks.mien", "lab");
  const auto solution = solve(take);
  ASSERT_FALSE(solution);
  EXPECT_EQ(solution.error().code, ErrorCode::not_found);
  EXPECT_THAT(solution.error().message(), HasSubstr("no-ticks.mien: the take has no frames"));
}

TEST(Solve, RefusesToMeasureWithoutTruth) {
  const mien::test::Folder folder;
  virt::VirtualSession session = test::lab_session();
  session.truth.clear();
  const take::Take take = test::stored(session, folder / "no-truth.mien", "lab");
  const auto truth = own_truth(take);
  ASSERT_FALSE(truth);
  EXPECT_EQ(truth.error().code, ErrorCode::not_found);
  EXPECT_THAT(truth.error().message(), HasSubstr("no-truth.mien: the take has no truth"));
}

TEST(Solve, TruthThatWasCutOffLeavesFramesOut) {
  const mien::test::Folder folder;
  virt::VirtualSession session = test::lab_session();
  session.truth.resize(session.truth.size() - 20);
  const take::Take take = test::stored(session, folder / "cut.mien", "lab");
  const Solution solution = solve(take).value();
  const measure::TakeEstimates estimates = with_truth("cut", solution, own_truth(take).value());
  ASSERT_EQ(estimates.truth.size(), session.ticks.size());
  ASSERT_EQ(estimates.model.size(), session.ticks.size());
  std::size_t counted = 0;
  for (std::size_t i = 0; i < estimates.truth.size(); ++i) {
    EXPECT_EQ(estimates.truth[i].time, session.ticks[i].frame);
    counted += estimates.truth[i].evaluated ? 1 : 0;
    EXPECT_EQ(estimates.provenance.at(i), solution.frames[i].provenance);
  }
  EXPECT_EQ(counted, 40U);
}

TEST(Solve, ARigThatLacksAModelsSensorWorksAndOneOfStrangersDoesNot) {
  const mien::test::Folder folder;
  const take::Take take = test::stored(test::lab_session(), folder / "a.mien", "lab");
  const Solution solution = solve(take, solver_for({"mentalis", "frontalis_L", "buccinator_L"})).value();
  EXPECT_EQ(solution.frames.back().confidence[0], 1) << "the ridge reads mentalis alone";
  const auto refused = solve(take, solver_for({"frontalis_L", "frontalis_R"}));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::mismatch);
}

TEST(Solve, StopsWhenAsked) {
  const mien::test::Folder folder;
  const take::Take take = test::stored(test::lab_session(), folder / "a.mien", "lab");
  const tracker::WindowSolver solver = solver_for();
  const auto solution =
      solve_take(take, solver, solver.file().sampler, [](double, std::string_view) { return false; });
  ASSERT_FALSE(solution);
  EXPECT_EQ(solution.error().code, ErrorCode::cancelled);
}

face::OutputFrame some_frame() {
  face::OutputFrame frame;
  frame.time = DeviceTime(std::chrono::nanoseconds(123'456'789));
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    frame.weights[k] = 0.01F * static_cast<float>(k);
    frame.provenance[k] = static_cast<face::Provenance>(k % 6);
  }
  frame.head = exp_rotation(Vec3(0.1, 0.2, 0.3));
  frame.eyes_rad = {Eigen::Vector2f(0.1F, 0.2F), Eigen::Vector2f(0.3F, 0.4F)};
  frame.head_provenance = face::Provenance::measured;
  frame.eyes_provenance = face::Provenance::held;
  return frame;
}

TEST(HashFrames, IsOfTheBytesThatTheContractNames) {
  const face::OutputFrame frame = some_frame();
  std::vector<std::byte> bytes;
  const auto add = [&](const auto& value) {
    const auto* begin = reinterpret_cast<const std::byte*>(&value);
    bytes.insert(bytes.end(), begin, begin + sizeof(value));
  };
  add(std::int64_t{123'456'789});
  for (const float w : frame.weights.values) add(w);
  for (const double h : {frame.head.w(), frame.head.x(), frame.head.y(), frame.head.z()})
    add(static_cast<float>(h));
  for (const float angle : {0.1F, 0.2F, 0.3F, 0.4F}) add(angle);
  for (std::size_t k = 0; k < face::kShapeCount; ++k) add(static_cast<std::uint8_t>(k % 6));
  add(std::uint8_t{0});  // The head was measured,
  add(std::uint8_t{3});  // the eyes held.
  ASSERT_EQ(bytes.size(), 307U);
  Sha256 hash;
  hash.add(bytes);
  EXPECT_EQ(hash_frames({&frame, 1}), hash.hex());
  EXPECT_EQ(hash_frames({}), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

TEST(HashFrames, ChangesWithEveryField) {
  const std::vector<std::function<void(face::OutputFrame&)>> changes = {
      [](auto& f) { f.time += std::chrono::nanoseconds(1); },
      [](auto& f) { f.weights[0] += 1e-6F; },
      [](auto& f) { f.weights[52] = std::nextafter(f.weights[52], 1.0F); },
      [](auto& f) { f.head = exp_rotation(Vec3(0.1, 0.2, 0.30001)); },
      [](auto& f) { f.eyes_rad[0].x() += 1e-6F; },
      [](auto& f) { f.eyes_rad[0].y() += 1e-6F; },
      [](auto& f) { f.eyes_rad[1].x() += 1e-6F; },
      [](auto& f) { f.eyes_rad[1].y() += 1e-6F; },
      [](auto& f) { f.provenance[0] = face::Provenance::held; },
      [](auto& f) { f.provenance[52] = face::Provenance::neutral; },
      [](auto& f) { f.head_provenance = face::Provenance::held; },
      [](auto& f) { f.eyes_provenance = face::Provenance::neutral; },
  };
  const std::vector<face::OutputFrame> frames = {some_frame(), some_frame()};
  std::vector<std::string> hashes = {hash_frames(frames)};
  for (const auto& change : changes) {
    auto changed = frames;
    change(changed[1]);
    hashes.push_back(hash_frames(changed));
  }
  auto shorter = frames;
  shorter.pop_back();
  hashes.push_back(hash_frames(shorter));
  std::ranges::sort(hashes);
  EXPECT_EQ(std::ranges::adjacent_find(hashes), hashes.end());
}

}  // namespace
}  // namespace mien::solve::solve_test
