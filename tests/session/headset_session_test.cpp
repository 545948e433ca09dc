// A headset's session: its views and its cameras' places change by commands, and the log replays to the same
// bits.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mien/headset/feature_record.h"
#include "mien/headset/headset_tracker.h"
#include "mien/headset/picture_packet.h"
#include "mien/headset/picture_protocol.h"
#include "mien/session/replay.h"
#include "mien/take/take.h"
#include "tests/folder.h"
#include "tests/headset/small_jpeg.h"
#include "tests/headset/small_model.h"

namespace mien::session::headset_session_test {
namespace {

using headset::test::Bytes;
using headset::test::kHeadset;
using testing::HasSubstr;

/// With `kept` pictures are logged and tracked as they are.
std::unique_ptr<Session> headset_session(bool kept = false, std::uint64_t seed = 1) {
  const sensor::Rig rig = headset::test::headset_rig();
  const auto model = headset::test::small_model(seed);
  Session::Parts parts;
  parts.rig = rig;
  parts.trackers.push_back(headset::HeadsetTracker::create(rig, model).value());
  parts.protocols.push_back(std::make_unique<headset::PictureProtocol>());
  if (!kept)
    parts.reducers.push_back(
        {std::string(headset::PictureProtocol::kName),
         std::make_unique<headset::FeatureReducer>(headset::FeatureReducer::create(rig, model).value())});
  return Session::create(std::move(parts)).value();
}

const Bytes& picture_of(int number) {
  static const std::vector<Bytes> pictures = [] {
    std::vector<Bytes> made;
    for (int n = 0; n < 40; ++n) made.push_back(headset::test::grey_jpeg(64, 64, n));
    return made;
  }();
  return pictures[static_cast<std::size_t>(number)];
}
/// A finger's, which differ in their noise.
const Bytes& finger(int number) {
  static const std::vector<Bytes> pictures = [] {
    std::vector<Bytes> made;
    for (int n = 0; n < 4; ++n) {
      std::vector<std::uint8_t> grey(64 * 64, static_cast<std::uint8_t>(20 + n));
      made.push_back(render::encode_jpeg(64, 64, render::JpegPixels::grey, 85, grey).value());
    }
    return made;
  }();
  return pictures[static_cast<std::size_t>(number % 4)];
}

/// Four cameras at 60 Hz for a while, as a live session has them; commands at their frames.
class Worn {
 public:
  explicit Worn(Session& session, const std::filesystem::path& path = {}) : session_(session) {
    take::Header header;
    header.rig_toml = headset::test::headset_rig_text();
    if (!path.empty()) writer_.emplace(take::TakeWriter::create(path, header, false).value());
  }
  std::optional<std::uint64_t> covered;  ///< The device whose lens is.
  std::vector<face::OutputFrame> frames;
  std::vector<headset::FeatureRecord> newest = std::vector<headset::FeatureRecord>(4);  ///< By device.
  std::vector<std::string> reducers;  ///< Of what was logged.

  void run(int count) {
    for (int i = 0; i < count; ++i, ++n_)
      for (std::uint64_t camera = 0; camera < 4; ++camera) send(camera);
  }
  Result<void> command(std::string_view json) {
    fire();
    if (writer_) entry_ = writer_->add_entry(now(), std::string(kPageSource), std::as_bytes(std::span(json)));
    return session_.command(now(), json);
  }
  std::string finish() {
    if (writer_) {
      const auto finished = writer_->finish();
      EXPECT_TRUE(finished) << finished.error().message();
    }
    return session_.hash();
  }

 private:
  HostTime now() const { return HostTime(frame_offset(n_) + std::chrono::milliseconds(3)); }
  void fire() {
    while (const auto tick = session_.due(now())) {
      frames.push_back(session_.tick(tick->frame, tick->fired));
      if (writer_) writer_->add_tick({tick->index, entry_, tick->fired, tick->frame});
    }
  }
  void send(std::uint64_t camera) {
    fire();
    ByteWriter packet;
    ASSERT_TRUE(headset::write_picture_packet({.from = {kHeadset + camera, 0},
                                               .sequence = static_cast<std::uint32_t>(n_),
                                               .time = DeviceTime(frame_offset(n_) + std::chrono::seconds(5)),
                                               .first = n_ == 0},
                                              packet));
    const Bytes datagram = packet.release();
    const auto number = static_cast<int>((static_cast<std::uint64_t>(n_) + 7 * camera) % 40);
    const Bytes& jpeg = covered == kHeadset + camera ? finger(number) : picture_of(number);
    const auto received = session_.receive(now(), 0, datagram, jpeg);
    ASSERT_EQ(received.verdict, sensor::Verdict::taken);
    if (headset::is_feature_record(received.payload.bytes)) {
      stored_[camera].assign(received.payload.bytes.begin(), received.payload.bytes.end());
      newest[camera] = headset::parse_feature_record(stored_[camera]).value();
    }
    if (reducers.empty() || reducers.back() != received.payload.reducer)
      reducers.emplace_back(received.payload.reducer);
    if (writer_) {
      entry_ = writer_->add_entry(now(), "camera", received.log, received.payload);
      for (const sensor::Sample& sample : received.samples) writer_->add_sample(entry_, now(), sample);
    }
    fire();
  }

  Session& session_;
  std::optional<take::TakeWriter> writer_;
  std::array<Bytes, 4> stored_;
  std::int64_t n_ = 0;
  std::int64_t entry_ = 0;
};

std::string replayed(const std::filesystem::path& path, Session& session) {
  const auto take = take::Take::open(path);
  EXPECT_TRUE(take) << take.error().message();
  const auto done = replay(*take, session, [](const auto&, const auto&) { return true; });
  EXPECT_TRUE(done) << done.error().message();
  return session.hash();
}

constexpr std::string_view kTurned = R"({"command": "view", "sensor": "eye_L", "turn_deg": 90})";
constexpr std::string_view kCut =
    R"({"command": "view", "sensor": "mouth_R", "crop": [0.3, 0.2, 0.4, 0.5], "mirror": false})";

TEST(HeadsetSession, AViewThatChangesReplaysToTheSameBitsWithAndWithoutPictures) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  std::vector<std::string> hashes;
  for (const bool kept : {false, true}) {
    const std::filesystem::path path = folder / (kept ? "kept.mien" : "reduced.mien");
    const auto session = headset_session(kept);
    Worn run(*session, path);
    run.run(60);
    ASSERT_TRUE(run.command(kTurned));
    run.run(30);
    ASSERT_TRUE(run.command(kCut));
    run.run(60);
    hashes.push_back(run.finish());
    EXPECT_EQ(replayed(path, *headset_session(kept)), hashes.back()) << kept;
    EXPECT_EQ(replayed(path, *headset_session(!kept)), hashes.back()) << "whoever reduces: the log says it";
    EXPECT_EQ(run.reducers.size(), kept ? 1U : 3U) << "each view has a hash of its own";
  }
  EXPECT_EQ(hashes[0], hashes[1]) << "what is kept changes no bit";
  const auto without = headset_session();
  Worn unchanged(*without);
  unchanged.run(150);
  EXPECT_NE(unchanged.finish(), hashes[0]) << "views do something";
}

TEST(HeadsetSession, IsAfterAChangeWhatItIsWithSuchARig) {
  const auto session = headset_session();
  Worn run(*session);
  run.run(2);
  ASSERT_TRUE(run.command(kTurned));
  ASSERT_TRUE(run.command(kCut));
  run.run(2);
  sensor::Rig rig = headset::test::headset_rig();
  rig.sensors[0].camera->turn_deg = 90;
  rig.sensors[3].camera->crop = {0.3, 0.2, 0.4, 0.5};
  rig.sensors[3].camera->mirror = false;
  auto reducer = headset::FeatureReducer::create(rig, headset::test::small_model()).value();
  EXPECT_EQ(run.reducers.back(), reducer.hash());
  Bytes out(sensor::kMaxPayload);
  for (std::uint16_t camera = 0; camera < 4; ++camera) {
    const auto size = reducer.reduce_picture(camera, picture_of(3 + 7 * camera), out);
    ASSERT_TRUE(size);
    const auto expected = headset::parse_feature_record(std::span(out).first(*size)).value();
    ASSERT_EQ(run.newest[camera].count(), expected.count());
    for (std::size_t i = 0; i < expected.count(); ++i)
      EXPECT_EQ(run.newest[camera].feature(i), expected.feature(i)) << camera << ' ' << i;
  }
  Report report;
  session->report(HostTime(), report);
  EXPECT_EQ(report.links[0].view->turn_deg, 90);
  EXPECT_EQ(report.links[1].view, sensor::view_of(*rig.sensors[1].camera));
  EXPECT_THAT(report.links[3].view->crop, testing::ElementsAre(0.3, 0.2, 0.4, 0.5));
  EXPECT_EQ(session->rig().sensors[0].camera->turn_deg, 0) << "the rig is that of the beginning";
}

TEST(HeadsetSession, RefusesWhatIsNoView) {
  const auto session = headset_session();
  const auto refused = [&](const std::string& fields) {
    const auto done = session->command(HostTime(), R"({"command": "view", )" + fields + "}");
    EXPECT_FALSE(done) << fields;
    return done ? std::string() : done.error().message();
  };
  EXPECT_THAT(refused(R"("sensor": "eye_M", "mirror": true)"), HasSubstr("no sensor \"eye_M\""));
  EXPECT_THAT(refused(R"("sensor": "eye_L", "crop": [0.5, 0, 0.6, 1])"), HasSubstr("leaves the picture"));
  EXPECT_THAT(refused(R"("sensor": "eye_L", "crop": [0, 0, 0.01, 1])"), HasSubstr("too little"));
  EXPECT_THAT(refused(R"("sensor": "eye_L", "turn_deg": 45)"), HasSubstr("turn_deg"));
  EXPECT_THAT(refused(R"("sensor": "eye_L", "turn_deg": 92233720368547758)"), HasSubstr("turn_deg"));
  EXPECT_THAT(refused(R"("sensor": "eye_L")"), HasSubstr("changes nothing"));
  Report report;
  session->report(HostTime(), report);
  EXPECT_EQ(report.links[0].view, sensor::view_of(*session->rig().sensors[0].camera));
}

TEST(HeadsetSession, ACameraIsBoundByCoveringItsLensAndSeesFromItsNewPlace) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  const auto session = headset_session();
  Worn run(*session, folder / "covered.mien");
  run.run(30);
  ASSERT_TRUE(run.command(R"({"command": "cover", "sensor": "eye_L"})"));
  run.run(30);
  Report report;
  session->report(HostTime(), report);
  EXPECT_EQ(report.cover.sensor, "eye_L");
  run.covered = kHeadset + 1;
  run.run(40);
  session->report(HostTime(), report);
  EXPECT_EQ(report.cover.sensor, "");
  EXPECT_EQ(report.cover.trouble, "");
  EXPECT_EQ(report.links[0].device, sensor::format_device({kHeadset + 1, 0}));
  EXPECT_EQ(report.links[1].device, "") << "the right eye's place waits for another";
  run.covered.reset();
  run.run(30);
  EXPECT_EQ(run.newest[1].sensor, 0) << "its features are its new place's, whether pictures are kept or not";
  EXPECT_FALSE(run.newest[0].sensor) << "and the other's nobody's";
  session->report(HostTime(), report);
  EXPECT_EQ(session->sensors_present(), 3U);
  const std::string live = run.finish();
  EXPECT_EQ(replayed(folder / "covered.mien", *headset_session()), live);
  EXPECT_EQ(replayed(folder / "covered.mien", *headset_session(true)), live);
}

TEST(HeadsetSession, OnlyCamerasHaveALens) {
  const auto session = headset_session();
  EXPECT_TRUE(session->command(HostTime(), R"({"command": "cover", "sensor": ""})"));
  EXPECT_FALSE(session->command(HostTime(), R"({"command": "cover", "sensor": "nose"})"));
}

}  // namespace
}  // namespace mien::session::headset_session_test
