// IMUs and a headset's cameras on one performer, from the take to who answers.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <optional>

#include "mien/core/files.h"
#include "mien/headset/headset_tracker.h"
#include "mien/modalities/modalities.h"
#include "mien/sensor/rig_part.h"
#include "mien/session/replay.h"
#include "mien/session/session.h"
#include "mien/solve/solve.h"
#include "mien/virtual/perform_take.h"
#include "tests/folder.h"
#include "tests/headset/small_model.h"
#include "tests/project_path.h"

namespace mien::lab::imu_headset_test {
namespace {

using face::OutputFrame;
using face::ShapeRegion;

constexpr double kFrom_s = 1.5, kTo_s = 3;

/// Every `from` in the text becomes `to`.
std::string with(std::string text, std::string_view from, std::string_view to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
  return text;
}

std::size_t at(ShapeRegion region) {
  return static_cast<std::size_t>(region);
}

/// Four and a half seconds of a face at rest with a hand before its mouth, by the shipped rig with small and
/// few pictures.
const take::Take& worn_take() {
  static const mien::test::Folder folder;
  static const take::Take take = [] {
    const std::string shipped = read_text(project_path("rigs/imu_headset.toml")).value();
    EXPECT_TRUE(write_file(folder / "rig.toml", with(with(shipped, "size = [240, 240]", "size = [64, 64]"),
                                                     "rate_hz = 60.0", "rate_hz = 20.0")));
    virt::PerformRequest request;
    request.rig = folder / "rig.toml";
    request.motion = face::Motion{.name = "at rest", .frames = {}};
    for (int f = 0; f <= 270; ++f) request.motion->frames.emplace_back().time_s = f / kFrameRateHz;
    request.headset_failure = virt::parse_timed_failure(fmt::format("hand@{}-{}", kFrom_s, kTo_s)).value();
    request.take = folder / "worn.mien";
    request.seed = 5;
    request.software = "mien test";
    const auto done = virt::perform_take(request, no_progress);
    EXPECT_TRUE(done) << (done ? "" : done.error().message());
    return take::Take::open(request.take).value();
  }();
  return take;
}

/// Seconds from when the hand came.
double since_hand_s(const OutputFrame& frame) {
  static const take::Event event = [] {
    const std::vector<take::Event> events = worn_take().events().value();
    for (const take::Event& one : events)
      if (one.kind == "headset_failure") return one;
    ADD_FAILURE() << "nothing befell the headset";
    return take::Event{};
  }();
  return to_seconds(frame.time - event.begin);
}

/// A network that has learnt nothing, with judgements that it has made.
headset::ViewsFile network_with(std::uint64_t seed,
                                const std::array<model::LogisticMap, headset::kJudgements>& judgements) {
  headset::ViewsFile file = headset::test::small_file_with_memory(seed);
  file.memory->judgements = judgements;
  return file;
}

std::vector<OutputFrame> by_cameras_alone(const headset::ViewsFile& file) {
  const sensor::Rig rig = sensor::part_of(worn_take().rig(), "camera");
  session::Session::Parts parts;
  parts.rig = worn_take().rig();
  parts.trackers.push_back(
      headset::HeadsetTracker::create(rig, headset::HeadsetModel::create(file).value()).value());
  parts.protocols = modalities::make_protocols().value();
  const auto session = session::Session::create(std::move(parts)).value();
  std::vector<OutputFrame> frames;
  EXPECT_TRUE(session::replay(worn_take(), *session, [&](const auto&, const OutputFrame& frame) {
    frames.push_back(frame);
    return true;
  }));
  return frames;
}

/// Maps of the judgements of mouth and jaw by which the face is seen and the hand is not, of all else it is
/// sure; none where what it says of the one reaches into what it says of the other.
std::optional<headset::ViewsFile> judging_network(std::uint64_t seed) {
  std::array<model::LogisticMap, headset::kJudgements> maps;
  maps.fill({.offset = 0, .slope = 1});
  const std::vector<OutputFrame> frames = by_cameras_alone(network_with(seed, maps));
  maps.fill({.offset = 3, .slope = 0});
  for (const ShapeRegion region : {ShapeRegion::mouth, ShapeRegion::jaw}) {
    std::array<double, 2> least = {1e9, 1e9}, most = {-1e9, -1e9};  // Of the face, of the hand.
    for (const OutputFrame& frame : frames) {
      const double s = since_hand_s(frame);
      const double p = frame.region_confidence[at(region)];
      const bool is_hidden = s > 0.2 && s<kTo_s - kFrom_s, is_back = s> kTo_s - kFrom_s + 0.2 && s < kTo_s;
      if (!is_hidden && !is_back && !(s > 0.2 - kFrom_s && s < 0)) continue;
      if (!(p > 0 && p < 1)) return std::nullopt;
      const double logit = std::log(p / (1 - p));
      least[is_hidden ? 1 : 0] = std::min(least[is_hidden ? 1 : 0], logit);
      most[is_hidden ? 1 : 0] = std::max(most[is_hidden ? 1 : 0], logit);
    }
    const bool is_face_above = least[0] > most[1];
    if (!is_face_above && !(most[0] < least[1])) return std::nullopt;
    const double face = is_face_above ? least[0] : most[0], hand = is_face_above ? most[1] : least[1];
    const double slope = 4 / (face - hand);
    maps[at(region)] = {.offset = static_cast<float>(-slope * (face + hand) / 2),
                        .slope = static_cast<float>(slope)};
  }
  return network_with(seed, maps);
}
/// The first that tells them apart.
const headset::ViewsFile& judging_network() {
  static const headset::ViewsFile file = [] {
    constexpr std::uint64_t kMost = 200;
    for (std::uint64_t seed = 1; seed < kMost; ++seed)
      if (auto found = judging_network(seed)) return std::move(*found);
    ADD_FAILURE() << "no network tells the hand from the face";
    return headset::test::small_file_with_memory();
  }();
  return file;
}

/// Models of both kinds in one folder.
const std::filesystem::path& models() {
  static const mien::test::Folder folder;
  static const std::filesystem::path path = [] {
    std::filesystem::create_symlink(project_path("models/live.safetensors"), folder / "live.safetensors");
    EXPECT_TRUE(headset::write_views_file(folder / "headset.safetensors", judging_network()));
    return std::filesystem::path(folder / "headset.safetensors").parent_path();
  }();
  return path;
}

TEST(ImuHeadset, EachAnswersItsRegionsAndAHandGivesTheMouthToTheImusAndBack) {
  const std::vector<OutputFrame> frames = solve::replay_take(worn_take(), models(), no_progress)->frames;
  const std::vector<OutputFrame> cameras = by_cameras_alone(judging_network());
  ASSERT_EQ(frames.size(), cameras.size());
  std::size_t seen = 0, hidden = 0, back = 0;
  for (std::size_t f = 0; f < frames.size(); ++f) {
    const double s = since_hand_s(frames[f]);
    if (s < 0.3 - kFrom_s || s > kTo_s) continue;
    const auto cameras_answer = [&](ShapeRegion region) {
      return frames[f].region_confidence[at(region)] == cameras[f].region_confidence[at(region)];
    };
    ASSERT_TRUE(cameras_answer(ShapeRegion::brows)) << s;
    ASSERT_TRUE(cameras_answer(ShapeRegion::eyes)) << s;
    ASSERT_NE(frames[f].head_provenance, face::Provenance::neutral) << "the ear's: " << s;
    ASSERT_EQ(cameras[f].head_provenance, face::Provenance::neutral) << s;
    const bool is_there = s > 0.25 && s<kTo_s - kFrom_s, is_gone = s> kTo_s - kFrom_s + 0.25;
    if (s > 0 && !is_there && !is_gone) continue;
    // Where lids of a network that has learnt nothing close, directions are held and eased back.
    if (s < 0) {
      ASSERT_TRUE(frames[f].eyes_rad == cameras[f].eyes_rad) << s;
    }
    for (const ShapeRegion region : {ShapeRegion::mouth, ShapeRegion::jaw})
      ASSERT_EQ(cameras_answer(region), !is_there) << s << " s from when the hand came";
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      ASSERT_NE(frames[f].provenance[k], face::Provenance::neutral) << face::kShapeNames[k] << ", " << s;
    seen += s < 0 ? 1 : 0;
    hidden += is_there ? 1 : 0;
    back += is_gone ? 1 : 0;
  }
  EXPECT_GT(seen, 60U);
  EXPECT_GT(hidden, 60U);
  EXPECT_GT(back, 40U);
}

TEST(ImuHeadset, ASessionAndItsReplaysHaveOneHash) {
  const mien::test::Folder folder;
  const take::Take& performed = worn_take();
  const auto session = modalities::make_session(performed.rig(), models()).value();
  {
    take::Header header;
    header.rig_toml = performed.header().rig_toml;
    take::TakeWriter writer = take::TakeWriter::create(folder / "live.mien", header, false).value();
    auto payloads = performed.payloads().value();
    std::int64_t id = 0;
    const auto fire = [&](HostTime now) {
      while (const auto tick = session->due(now)) {
        session->tick(tick->frame, tick->fired);
        writer.add_tick({tick->index, id, tick->fired, tick->frame});
      }
    };
    const std::vector<take::LogEntry> entries = performed.entries().value();
    for (const take::LogEntry& entry : entries) {
      fire(entry.arrival);
      const auto received =
          session->receive(entry.arrival, {0, entry.source}, entry.bytes, payloads.of(entry.id)->bytes);
      id = writer.add_entry(entry.arrival, entry.source, received.log, received.payload);
      fire(entry.arrival);
    }
    ASSERT_TRUE(writer.finish());
  }
  const std::string hash = session->hash();
  const auto recorded = take::Take::open(folder / "live.mien").value();
  for (int replay = 0; replay < 2; ++replay) {
    const auto again = solve::replay_take(recorded, models(), no_progress);
    ASSERT_TRUE(again) << again.error().message();
    EXPECT_EQ(again->hash, hash);
    EXPECT_GT(again->frames.size(), 500U);
  }
}

}  // namespace
}  // namespace mien::lab::imu_headset_test
