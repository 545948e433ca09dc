// Payloads on the way of a live session: from a device inside the program through intake, tracker and
// recorder into a take, and what the temporary log does when it is full of them.
#include <utility>  // Before Asio 1.74, which forgets it.

#include "mien/live/payload_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <thread>

#include "mien/live/intake.h"
#include "mien/live/recorder.h"
#include "mien/live/spool.h"
#include "mien/live/tracker_loop.h"
#include "mien/session/replay.h"
#include "tests/folder.h"
#include "tests/session/picture_modality.h"

namespace mien::live::payload_test {
namespace {

using session::test::picture;
using ::testing::HasSubstr;

const std::string kHash(sensor::kReducerHashDigits, 'b');

take::Header header() {
  take::Header header;
  header.software = "test";
  header.rig_toml = session::test::kCameraRig;
  return header;
}

/// Waits for what another thread does; false when it does not.
template <class Done>
bool wait_until(Done done) {
  for (int i = 0; i < 1000; ++i) {
    if (done()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

void record_entry(Recorder& recorder, std::uint32_t n, std::span<const std::byte> payload,
                  std::string_view reducer = {}) {
  const std::array<std::byte, 40> bytes{static_cast<std::byte>(n)};
  recorder.entry(HostTime(frame_offset(n)), "camera:left", bytes, {}, {payload, reducer});
  recorder.tick({n, DeviceTime(frame_offset(n)), HostTime(frame_offset(n)), true});
}

TEST(RecordedPayloads, AreInATakeThatIsAskedForLate) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  Recorder recorder(folder.path());
  const auto size_of = [](std::uint32_t n) { return n == 50 ? sensor::kMaxPayload : 1000 + n; };
  const auto record_some = [&](std::uint32_t from, std::uint32_t to) {
    for (std::uint32_t n = from; n < to; ++n)
      record_entry(recorder, n, n % 3 == 0 ? std::vector<std::byte>() : picture(n, size_of(n)),
                   n % 3 == 1 ? std::string_view(kHash) : std::string_view());
  };
  record_some(0, 100);
  ASSERT_TRUE(recorder.start(folder / "a.mien", header(), false));
  record_some(100, 200);
  recorder.end({});
  ASSERT_TRUE(recorder.wait());

  const auto take = take::Take::open(folder / "a.mien");
  ASSERT_TRUE(take) << take.error().message();
  EXPECT_EQ(take->entries().value().size(), 200u);
  EXPECT_EQ(take->ticks().value().size(), 200u);
  auto payloads = take->payloads().value();
  for (std::uint32_t n = 0; n < 200; ++n) {
    const sensor::Payload payload = payloads.of(n + 1).value();
    if (n % 3 == 0) {
      EXPECT_TRUE(payload.bytes.empty()) << n;
      continue;
    }
    EXPECT_TRUE(std::ranges::equal(payload.bytes, picture(n, size_of(n)))) << n;
    EXPECT_EQ(payload.reducer, n % 3 == 1 ? kHash : "") << n;
  }
  const Spool::Usage log = recorder.state().log;
  EXPECT_GT(log.payload_bytes, sensor::kMaxPayload);
  EXPECT_GT(log.bytes, log.payload_bytes + 200 * 40);
  EXPECT_EQ(log.limit, Spool::kDefaultLimit);
  ASSERT_TRUE(log.seconds_left);
  EXPECT_GT(*log.seconds_left, 3600);
}

TEST(RecordedPayloads, MoreThanTheirQueueHoldsEndTheRecordingWithTheReason) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  Recorder recorder(folder.path());
  const std::vector<std::byte> large = picture(1, sensor::kMaxPayload);
  record_entry(recorder, 0, large);
  ASSERT_TRUE(recorder.start(folder / "a.mien", header(), false));
  // Faster than any disk.
  for (std::uint32_t n = 1; n < 6000 && recorder.state().unable.empty(); ++n)
    record_entry(recorder, n, large);
  ASSERT_TRUE(wait_until([&] { return !recorder.state().unable.empty(); }));
  EXPECT_THAT(recorder.state().unable, HasSubstr("too slow for the session's pictures"));
  EXPECT_FALSE(recorder.wait());
  EXPECT_TRUE(take::Take::open(folder / "a.mien")) << "what was written stays";
}

TEST(RecordedPayloads, ComingFasterThanTheyAreTakenTheyDoNotKeepTheRecorderFromItsOtherWork) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  Recorder recorder(folder.path(), 200'000'000);
  ASSERT_TRUE(recorder.start(folder / "a.mien", header(), false));
  const std::vector<std::byte> large = picture(1, sensor::kMaxPayload);
  const std::jthread device([&](const std::stop_token& stop) {
    for (std::uint32_t n = 0; !stop.stop_requested(); ++n) record_entry(recorder, n, large);
  });
  // Either the limit or the queue ends it; the recorder must see which.
  EXPECT_TRUE(wait_until([&] { return !recorder.state().unable.empty(); }));
  EXPECT_FALSE(recorder.wait());
}

TEST(RecordedPayloads, AtTheirHalfOfTheLimitNothingCanBeRecordedAnyMore) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  Recorder recorder(folder.path(), 1'000'000);
  for (std::uint32_t n = 0; n < 40; ++n) record_entry(recorder, n, picture(n, 10'000));
  ASSERT_TRUE(wait_until([&] { return recorder.state().log.payload_bytes == 400'000; }));
  EXPECT_EQ(recorder.state().unable, "");
  EXPECT_EQ(recorder.state().log.payload_limit, 500'000u);
  for (std::uint32_t n = 40; n < 60; ++n) record_entry(recorder, n, picture(n, 10'000));
  ASSERT_TRUE(wait_until([&] { return !recorder.state().unable.empty(); }));
  EXPECT_EQ(recorder.state().unable,
            "the session has run for too long to be recorded from its beginning: its pictures and sound have "
            "reached half of the 0.001 GB of --log-limit");
  EXPECT_FALSE(recorder.state().log.seconds_left);
  const auto started = recorder.start(folder / "a.mien", header(), false);
  ASSERT_FALSE(started);
  EXPECT_THAT(started.error().message(), HasSubstr("too long to be recorded"));
  record_entry(recorder, 60, picture(60, 10'000));  // The session goes on.
}

TEST(RecordedPayloads, TakeNoRoomFromWhatIsSmall) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  Spool spool(folder.path(), 1'000'000);
  const std::vector<std::byte> record(996), payload(100'000);
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(spool.append_payload(payload));
  EXPECT_FALSE(spool.append_payload(payload));
  for (int i = 0; i < 500; ++i) ASSERT_TRUE(spool.append(record)) << i;
  const auto full = spool.append(record);
  ASSERT_FALSE(full);
  EXPECT_THAT(full.error().what, HasSubstr("its log has reached the 0.001 GB of --log-limit"));

  // And without payloads all of it is theirs.
  Spool small(folder.path(), 1'000'000);
  for (int i = 0; i < 1000; ++i) ASSERT_TRUE(small.append(record)) << i;
  EXPECT_FALSE(small.append(record));
}

TEST(RecordedPayloads, TheLogTellsHowLongItLastsAtTheRateOfTheLastSeconds) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  Spool spool(folder.path(), 10'000'000);
  const std::vector<std::byte> record(996);
  int second = 0;
  const auto run = [&](int seconds, int records, int payloads) {
    for (; seconds > 0; --seconds) {
      for (int i = 0; i < records; ++i) EXPECT_TRUE(spool.append(record));
      for (int i = 0; i < payloads; ++i) EXPECT_TRUE(spool.append_payload(record));
      static_cast<void>(spool.usage(HostTime(std::chrono::seconds(++second))));
    }
    return spool.usage(HostTime(std::chrono::seconds(second))).seconds_left;
  };
  EXPECT_FALSE(spool.usage({}).seconds_left);
  EXPECT_NEAR(run(30, 10, 0).value(), (10e6 - 30 * 10e3) / 10e3, 1);
  EXPECT_NEAR(run(30, 100, 0).value(), (10e6 - 3.3e6) / 100e3, 1);
  // Payloads reach their half first.
  EXPECT_NEAR(run(30, 1, 50).value(), (5e6 - 30 * 50 * 996.0) / (50 * 996.0), 1);
  EXPECT_FALSE(run(30, 0, 0)) << "nothing comes any more";
}

class SourceTest : public ::testing::Test {
 protected:
  boost::asio::io_context network;
  HostTime now{};
  Intake intake{network, [this] { return now; }};
};

TEST_F(SourceTest, HandsOverDatagramAndPayloadInTheOrderOfArrival) {
  PayloadSource* const left = intake.add_source("camera:left").value();
  PayloadSource* const right = intake.add_source("camera:right").value();
  EXPECT_FALSE(intake.add_source("camera:left"));
  const std::vector<std::byte> datagram = picture(1, 20), large = picture(2, sensor::kMaxPayload);
  const auto at = [&](int ms) { now = HostTime(std::chrono::milliseconds(ms)); };
  at(3);
  EXPECT_TRUE(right->hand_over(datagram, large));
  at(5);
  EXPECT_TRUE(intake.command(7, 9, "{}"));
  at(4);
  EXPECT_TRUE(left->hand_over({}, picture(4, 1)));
  const auto first = intake.front();
  ASSERT_TRUE(first);
  EXPECT_EQ(first->source, "camera:right");
  EXPECT_EQ(first->arrival, HostTime(std::chrono::milliseconds(3)));
  EXPECT_TRUE(std::ranges::equal(first->bytes, datagram));
  EXPECT_TRUE(std::ranges::equal(first->payload, large));
  at(1);
  EXPECT_TRUE(left->hand_over(datagram, {}));
  EXPECT_EQ(intake.front()->payload.data(), first->payload.data()) << "until it is released";
  intake.release();
  EXPECT_EQ(intake.front()->payload.size(), 1u);
  EXPECT_EQ(intake.front()->source, "camera:left");
  intake.release();
  EXPECT_TRUE(intake.front()->payload.empty());
  intake.release();
  EXPECT_EQ(intake.front()->kind, Arrived::Kind::command);
  EXPECT_TRUE(intake.front()->payload.empty());
  intake.release();
  EXPECT_FALSE(intake.front());
}

TEST_F(SourceTest, RefusesAndCountsWhatIsTooLongOrTooMuch) {
  PayloadSource& source = *intake.add_source("camera").value();
  const std::vector<std::byte> large(sensor::kMaxPayload + 1), whole(sensor::kMaxPayload);
  EXPECT_FALSE(source.hand_over({}, large));
  EXPECT_FALSE(source.hand_over(std::vector<std::byte>(PayloadSource::kMaxDatagram + 1), {}));
  EXPECT_EQ(intake.counts().too_long, 2u);
  std::size_t waiting = 0;
  while (source.hand_over({}, whole)) ++waiting;
  EXPECT_GE(waiting, 30u);
  EXPECT_EQ(intake.counts().payload_overrun, 1u);
  EXPECT_EQ(intake.counts().overrun, 0u);
  EXPECT_EQ(intake.counts().received, waiting + 3);
  EXPECT_TRUE(intake.command(1, 1, "{}")) << "the network's queue is another";
}

/// A camera's thread, 100 pictures at twice the pace of the grid, through the whole live session.
std::string live_session(const std::filesystem::path& path, std::optional<std::uint32_t> scale) {
  boost::asio::io_context network;
  const auto begun = std::chrono::steady_clock::now();
  const auto clock = [begun] {
    return HostTime(std::chrono::duration_cast<Duration>(std::chrono::steady_clock::now() - begun));
  };
  const auto session = session::test::picture_session(scale);
  Intake intake(network, clock);
  PayloadSource& source = *intake.add_source("camera:left").value();
  Recorder recorder(path.parent_path());
  TrackerLoop loop(*session, intake, recorder, clock);
  EXPECT_TRUE(recorder.start(path, header(), false));
  loop.start();
  std::thread camera([&] {
    for (std::uint32_t n = 0; n < 100; ++n) {
      const auto datagram = session::test::picture_datagram(n, DeviceTime(frame_offset(n) / 2));
      EXPECT_TRUE(source.hand_over(datagram, picture(n, n == 7 ? sensor::kMaxPayload : 3000)));
      std::this_thread::sleep_for(std::chrono::milliseconds(8));
    }
  });
  camera.join();
  EXPECT_TRUE(wait_until([&] { return loop.report().frames >= 48; }));
  loop.stop();
  recorder.end({});
  const auto written = recorder.wait();
  EXPECT_TRUE(written) << written.error().message();
  return session->hash();
}

TEST(LivePayloads, AreTrackedRecordedAndReplayedToTheSameBits) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  for (const auto scale : {std::optional<std::uint32_t>(), std::optional<std::uint32_t>(1)}) {
    const auto path = folder / (scale ? "reduced.mien" : "raw.mien");
    const std::string live = live_session(path, scale);
    const auto take = take::Take::open(path);
    ASSERT_TRUE(take) << take.error().message();
    const auto entries = take->entries().value();
    ASSERT_EQ(entries.size(), 100u);
    EXPECT_EQ(entries[0].source, "camera:left");
    auto payloads = take->payloads().value();
    EXPECT_EQ(payloads.of(8).value().bytes.size(), scale ? 64u : sensor::kMaxPayload);
    const auto again = session::test::picture_session();
    ASSERT_TRUE(session::replay(*take, *again, [](const auto&, const auto&) { return true; }));
    EXPECT_EQ(again->hash(), live);
  }
}

}  // namespace
}  // namespace mien::live::payload_test
