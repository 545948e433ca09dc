#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "mien/phone/live_link.h"
#include "mien/sensor/bindings.h"
#include "tests/phone/live_link_bytes.h"
#include "tests/session/session_run.h"

// A phone that is recorded beside IMUs and moves nothing.
namespace mien::session::phone_truth_test {
namespace {

using test::Played;

constexpr double kPhoneHz = 60;

sensor::Rig rig(bool with_phone) {
  sensor::Rig made = virt::test::three_sensors();
  for (std::size_t i = 0; i < made.sensors.size(); ++i)
    made.sensors[i].device = sensor::format_device({sensor::virtual_device(i), 0});
  if (with_phone)
    made.sensors.push_back({.name = "phone",
                            .kind = "weights",
                            .role = "truth",
                            .device = sensor::format_device({phone::kLiveLinkDevice, 0})});
  return made;
}

std::unique_ptr<Session> session(const sensor::Rig& of) {
  Session::Parts parts;
  parts.rig = of;
  parts.trackers.push_back(std::make_unique<imu::ImuTracker>(of, std::make_unique<test::TwoShapes>()));
  parts.protocols.push_back(std::make_unique<phone::LiveLinkProtocol>());
  parts.protocols.push_back(std::make_unique<imu::NodeProtocol>(imu::NodeProtocol::create().value()));
  return Session::create(std::move(parts)).value();
}

/// When a phone sees no face, s.
struct FaceGone {
  double from_s = 1e9, to_s = 1e9;
  double silent_from_s = 1e9, silent_to_s = 1e9;  ///< Within it sends nothing at all.
};

/// A phone's packets from three seconds before the IMUs' on, each 60 to 120 ms late; after `leaps_s` its
/// clock is an hour ahead.
std::vector<take::LogEntry> phone_entries(const virt::VirtualSession& imus, double leaps_s = 1e9,
                                          const FaceGone& gone = {}) {
  const double end_s = to_seconds(imus.entries.back().arrival.time_since_epoch());
  std::vector<take::LogEntry> entries;
  Random random(8);
  HostTime arrival{};
  for (int n = -180; n / kPhoneHz + 0.12 < end_s; ++n) {
    phone::test::LiveLinkFields fields{.device_id = "a phone", .frame = 500'000 + n};
    if (n / kPhoneHz > leaps_s) fields.frame += 3600 * 60;
    const double now_s = n / kPhoneHz;
    if (now_s >= gone.silent_from_s && now_s < gone.silent_to_s) continue;
    if (now_s < gone.from_s || now_s >= gone.to_s)
      // A face that moves: one that never varies is told as frozen.
      fields.values.emplace().fill(0.25F + 0.001F * static_cast<float>((n + 180) % 50));
    // None overtakes another.
    arrival = std::max(arrival, HostTime(from_seconds(10 + n / kPhoneHz + random.uniform(0.06, 0.12))));
    entries.push_back({0, arrival, "udp://10.0.0.9:1", phone::test::live_link_bytes(fields)});
  }
  return entries;
}

/// The IMUs' entries ten seconds later, so that a phone may begin before.
std::vector<take::LogEntry> imu_entries(const virt::VirtualSession& imus) {
  std::vector<take::LogEntry> entries = imus.entries;
  for (take::LogEntry& entry : entries) entry.arrival += std::chrono::seconds(10);
  return entries;
}

/// By arrival; those of one moment as they stood. (Not by stable_sort, whose buffer clang-19 calls
/// deprecated.)
std::vector<take::LogEntry> in_order(std::vector<take::LogEntry> entries) {
  const auto number = [&] {
    for (std::size_t i = 0; i < entries.size(); ++i) entries[i].id = static_cast<std::int64_t>(i + 1);
  };
  number();
  std::ranges::sort(entries, {},
                    [](const take::LogEntry& entry) { return std::pair(entry.arrival, entry.id); });
  number();
  return entries;
}

TEST(PhoneTruth, FramesAreTheSameBitsWithAndWithoutIt) {
  const virt::VirtualSession imus = test::performance(6);
  const auto alone_session = session(rig(false));
  const Played alone = test::run(*alone_session, in_order(imu_entries(imus)));
  ASSERT_GT(alone.frames.size(), 600U);
  for (const double leaps_s : {1e9, 8.0}) {
    std::vector<take::LogEntry> entries = imu_entries(imus);
    std::ranges::copy(phone_entries(imus, leaps_s), std::back_inserter(entries));
    const auto both_session = session(rig(true));
    const Played both = test::run(*both_session, in_order(std::move(entries)));
    EXPECT_EQ(both.hash, alone.hash);
    ASSERT_EQ(both.frames.size(), alone.frames.size());
    for (std::size_t i = 0; i < both.frames.size(); ++i) {
      EXPECT_EQ(both.frames[i].tick.frame, alone.frames[i].tick.frame);
      EXPECT_EQ(both.frames[i].tick.fired, alone.frames[i].tick.fired);
    }
  }
}

TEST(PhoneTruth, HasALinkAsAnyDevice) {
  const virt::VirtualSession imus = test::performance(3);
  std::vector<take::LogEntry> entries = imu_entries(imus);
  std::ranges::copy(phone_entries(imus), std::back_inserter(entries));
  const auto both = session(rig(true));
  const Played played = test::run(*both, in_order(std::move(entries)));
  ASSERT_EQ(played.report.links.size(), 4U);
  const Report::Link& phone = played.report.links[3];
  EXPECT_EQ(phone.device, sensor::format_device({phone::kLiveLinkDevice, 0}));
  EXPECT_EQ(phone.health.lost, 0U);
  EXPECT_EQ(phone.health.restarts, 0U);
  EXPECT_GT(phone.health.late, 10U);
  EXPECT_EQ(phone.health.state, sensor::LinkState::good) << "no frame waits for it";
  ASSERT_TRUE(phone.health.clock);
  // Its frame 500,000 was at ten seconds here, and came 60 ms later at the earliest.
  EXPECT_NEAR(to_seconds(phone.health.clock->offset), 10.06 - 500'000 / 60.0, 0.01);
}

/// What happened to the phone, in order: kinds, and when, s after the IMUs' first packets.
std::vector<std::pair<std::string, double>> news_of_the_phone(const Played& played) {
  std::vector<std::pair<std::string, double>> out;
  for (const take::Event& event : played.events)
    if (event.json.contains("phone"))
      out.emplace_back(event.kind, to_seconds(event.begin - played.frames.front().tick.frame));
  return out;
}

TEST(PhoneTruth, AFaceThatIsLostIsNoLostSensor) {
  const virt::VirtualSession imus = test::performance(6);
  std::vector<take::LogEntry> entries = imu_entries(imus);
  std::ranges::copy(phone_entries(imus, 1e9, {.from_s = 2, .to_s = 4}), std::back_inserter(entries));
  entries = in_order(std::move(entries));
  const auto live = session(rig(true));
  const Played played = test::run(*live, entries);
  const auto news = news_of_the_phone(played);
  ASSERT_EQ(news.size(), 2U);
  EXPECT_EQ(news[0].first, "face_lost");
  EXPECT_NEAR(news[0].second, 2.4, 0.2) << "the first frame fires a little later, too";
  EXPECT_EQ(news[1].first, "face_back");
  EXPECT_NEAR(news[1].second - news[0].second, 1.9, 0.1);
  EXPECT_EQ(played.count("sensor_lost"), 0U);
  const auto again = session(rig(true));
  const Played replayed = test::run(*again, entries);
  EXPECT_EQ(news_of_the_phone(replayed), news);
}

TEST(PhoneTruth, APhoneWithoutAFaceMayBeLostToo) {
  const virt::VirtualSession imus = test::performance(12);
  std::vector<take::LogEntry> entries = imu_entries(imus);
  std::ranges::copy(phone_entries(imus, 1e9, {.from_s = 2, .to_s = 9, .silent_from_s = 4, .silent_to_s = 7}),
                    std::back_inserter(entries));
  const auto live = session(rig(true));
  const Played played = test::run(*live, in_order(std::move(entries)));
  std::vector<std::string> kinds;
  for (const auto& [kind, time_s] : news_of_the_phone(played)) kinds.push_back(kind);
  EXPECT_EQ(kinds, (std::vector<std::string>{"face_lost", "sensor_lost", "sensor_back", "face_back"}));
}

TEST(PhoneTruth, APhoneThatNeverSawAFaceIsThere) {
  const virt::VirtualSession imus = test::performance(3);
  std::vector<take::LogEntry> entries = imu_entries(imus);
  std::ranges::copy(phone_entries(imus, 1e9, {.from_s = -10}), std::back_inserter(entries));
  const auto live = session(rig(true));
  const Played played = test::run(*live, in_order(std::move(entries)));
  ASSERT_EQ(played.report.links.size(), 4U);
  EXPECT_EQ(played.report.links[3].health.state, sensor::LinkState::no_face);
  EXPECT_EQ(played.count("face_lost"), 1U);
  EXPECT_EQ(played.count("sensor_lost"), 0U);
}

}  // namespace
}  // namespace mien::session::phone_truth_test
