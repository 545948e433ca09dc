// Payloads: a picture beside a datagram reaches the tracker, raw or reduced, and the log replays to the same
// bits. Allocations of the live path are counted, by taking the place of operator new.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mien/session/replay.h"
#include "mien/take/take.h"
#include "tests/allocation_count.h"
#include "tests/folder.h"
#include "tests/session/picture_modality.h"

namespace mien::session::payload_test {
namespace {

using sensor::Verdict;
using test::PictureTracker;

constexpr std::size_t kPictureBytes = 5000;

HostTime arrival_of(std::uint32_t n) {
  return HostTime(frame_offset(n) + std::chrono::milliseconds(2));
}
std::vector<std::byte> datagram_of(std::uint32_t n) {
  return test::picture_datagram(n, DeviceTime(frame_offset(n) + std::chrono::seconds(7)));
}

/// Two seconds of pictures as a live session has them, into a take; returns the frames' hash.
std::string record(Session& session, const std::filesystem::path& path) {
  take::Header header;
  header.rig_toml = test::kCameraRig;
  take::TakeWriter writer = take::TakeWriter::create(path, header, false).value();
  std::int64_t entry = 0;
  const auto fire = [&](HostTime now) {
    while (const auto tick = session.due(now)) {
      session.tick(tick->frame, tick->fired);
      writer.add_tick({tick->index, entry, tick->fired, tick->frame});
    }
  };
  for (std::uint32_t n = 0; n < 120; ++n) {
    fire(arrival_of(n));
    const std::vector<std::byte> datagram = datagram_of(n);
    const std::vector<std::byte> picture = test::picture(n, kPictureBytes);  // What is logged refers to it.
    const auto received = session.receive(arrival_of(n), 0, datagram, picture);
    EXPECT_EQ(received.verdict, Verdict::taken);
    entry = writer.add_entry(arrival_of(n), "camera:left", received.log, received.payload);
    for (const sensor::Sample& sample : received.samples) writer.add_sample(entry, arrival_of(n), sample);
    fire(arrival_of(n));
  }
  const auto finished = writer.finish();
  EXPECT_TRUE(finished) << finished.error().message();
  EXPECT_GT(session.frames(), 100u);
  return session.hash();
}

std::string replayed(const std::filesystem::path& path, Session& session) {
  const auto take = take::Take::open(path);
  EXPECT_TRUE(take) << take.error().message();
  const auto done = replay(*take, session, [](const auto&, const auto&) { return true; });
  EXPECT_TRUE(done) << done.error().message();
  return session.hash();
}

TEST(Payload, ReachesTheTrackerWholeUpToItsLimit) {
  PictureTracker::Seen seen;
  const auto session = test::picture_session({}, &seen);
  for (const std::size_t bytes : {std::size_t{1}, kPictureBytes, sensor::kMaxPayload}) {
    const std::vector<std::byte> picture = test::picture(3, bytes);
    const auto received = session->receive(arrival_of(static_cast<std::uint32_t>(seen.payloads)), 0,
                                           datagram_of(static_cast<std::uint32_t>(seen.payloads)), picture);
    EXPECT_EQ(received.verdict, Verdict::taken);
    EXPECT_EQ(received.payload.bytes.data(), picture.data()) << "by reference";
    EXPECT_EQ(received.payload.bytes.size(), bytes);
    EXPECT_TRUE(received.payload.reducer.empty());
    EXPECT_EQ(seen.bytes, bytes);
  }
  EXPECT_EQ(seen.payloads, 3u);
  const auto too_long =
      session->receive(arrival_of(3), 0, datagram_of(3), test::picture(3, sensor::kMaxPayload + 1));
  EXPECT_EQ(too_long.verdict, Verdict::malformed);
  EXPECT_TRUE(too_long.payload.bytes.empty()) << "nothing of it is logged";
  EXPECT_EQ(session->receive(arrival_of(3), 0, datagram_of(3)).verdict, Verdict::malformed);
  EXPECT_EQ(seen.payloads, 3u);
  EXPECT_EQ(seen.alone, 0u);
}

TEST(Payload, ATakeOfRawPicturesReplaysToTheSameBits) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  const std::string live = record(*test::picture_session(), folder / "raw.mien");
  EXPECT_EQ(replayed(folder / "raw.mien", *test::picture_session()), live);
  EXPECT_EQ(replayed(folder / "raw.mien", *test::picture_session(1)), live)
      << "a reducer that came later changes no old log";
  auto payloads = take::Take::open(folder / "raw.mien").value();
  auto reader = payloads.payloads().value();
  const auto third = reader.of(3).value();
  EXPECT_TRUE(std::ranges::equal(third.bytes, test::picture(2, kPictureBytes)));
  EXPECT_TRUE(third.reducer.empty());
}

TEST(Payload, ATakeOfReducedPicturesHoldsTheReductionAloneAndReplaysToTheSameBits) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  PictureTracker::Seen seen;
  const std::string live = record(*test::picture_session(1, &seen), folder / "reduced.mien");
  EXPECT_EQ(seen.bytes, 64u) << "the tracker sees what a replay will see";
  const auto take = take::Take::open(folder / "reduced.mien").value();
  auto reader = take.payloads().value();
  for (std::int64_t entry = 1; entry <= 120; ++entry) {
    const auto payload = reader.of(entry).value();
    ASSERT_EQ(payload.bytes.size(), 64u);
    EXPECT_EQ(payload.reducer, test::PictureReducer(1).hash());
  }
  EXPECT_TRUE(take.check());

  EXPECT_EQ(replayed(folder / "reduced.mien", *test::picture_session(1)), live);
  EXPECT_EQ(replayed(folder / "reduced.mien", *test::picture_session()), live) << "no reducer any more";
  EXPECT_EQ(replayed(folder / "reduced.mien", *test::picture_session(2)), live) << "another reducer";
  const std::string raw = record(*test::picture_session(), folder / "raw.mien");
  const std::string other = record(*test::picture_session(2), folder / "other.mien");
  EXPECT_NE(raw, live);
  EXPECT_NE(other, live);
  EXPECT_LT(10 * std::filesystem::file_size(folder / "reduced.mien"),
            9 * std::filesystem::file_size(folder / "raw.mien"));
}

TEST(Payload, OneThatItsReducerDoesNotTakeIsMalformed) {
  PictureTracker::Seen seen;
  const auto session = test::picture_session(1, &seen);
  const std::vector<std::byte> broken(100, std::byte{0xFF});
  const auto received = session->receive(arrival_of(0), 0, datagram_of(0), broken);
  EXPECT_EQ(received.verdict, Verdict::malformed);
  EXPECT_EQ(seen.payloads, 0u);
  Report report;
  session->report(arrival_of(1), report);
  EXPECT_EQ(report.malformed, 1u);
}

/// A protocol of before there were payloads.
class Old final : public sensor::Protocol {
 public:
  [[nodiscard]] std::string_view name() const override { return "old"; }
  [[nodiscard]] bool recognises(std::span<const std::byte>) const override { return true; }
  Verdict receive(HostTime, sensor::Peer, std::span<const std::byte>, sensor::Inbox&) override {
    return Verdict::taken;
  }
};

TEST(Payload, IsMalformedInAProtocolWithoutAny) {
  Session::Parts parts;
  parts.rig = sensor::parse_rig(test::kCameraRig, "camera").value();
  parts.trackers.push_back(std::make_unique<PictureTracker>());
  parts.protocols.push_back(std::make_unique<Old>());
  const auto session = Session::create(std::move(parts)).value();
  EXPECT_EQ(session->receive({}, 0, datagram_of(0)).verdict, Verdict::taken);
  EXPECT_EQ(session->receive({}, 0, datagram_of(1), test::picture(1, 10)).verdict, Verdict::malformed);
}

TEST(Payload, ReducersAreOfAProtocolThatIsThereOneEachAndHaveAHash) {
  const auto created = [](std::vector<ProtocolReducer> reducers) {
    std::vector<std::unique_ptr<sensor::Protocol>> protocols;
    protocols.push_back(std::make_unique<test::PictureProtocol>());
    return Receiver::create(sensor::parse_rig(test::kCameraRig, "camera").value(), std::move(protocols),
                            std::move(reducers));
  };
  const auto reducers = [](std::vector<std::pair<const char*, std::uint32_t>> wanted) {
    std::vector<ProtocolReducer> out;
    for (const auto& [protocol, scale] : wanted)
      out.push_back({protocol, std::make_unique<test::PictureReducer>(scale)});
    return out;
  };
  EXPECT_TRUE(created(reducers({{"picture", 1}})));
  EXPECT_EQ(created(reducers({{"sound", 1}})).error().code, ErrorCode::bad_usage);
  EXPECT_EQ(created(reducers({{"picture", 1}, {"picture", 2}})).error().code, ErrorCode::bad_usage);
  EXPECT_EQ(created(reducers({{"picture", 30}})).error().code, ErrorCode::bad_usage)
      << "no hexadecimal digit";
}

TEST(Payload, IsReceivedWithoutAnAllocation) {
  for (const auto scale : {std::optional<std::uint32_t>(), std::optional<std::uint32_t>(1)}) {
    const auto session = test::picture_session(scale);
    const std::vector<std::byte> picture = test::picture(1, sensor::kMaxPayload);
    std::size_t allocated = 0;
    for (std::uint32_t n = 0; n < 200; ++n) {
      const std::vector<std::byte> datagram = datagram_of(n);
      const std::size_t before = mien::test::allocation_count();
      const auto received = session->receive(arrival_of(n), 0, datagram, picture);
      if (n >= 20) allocated += mien::test::allocation_count() - before;
      EXPECT_EQ(received.verdict, Verdict::taken);
      while (const auto tick = session->due(arrival_of(n))) session->tick(tick->frame, tick->fired);
    }
    EXPECT_EQ(allocated, 0u) << (scale ? "reduced" : "raw");
  }
}

}  // namespace
}  // namespace mien::session::payload_test
