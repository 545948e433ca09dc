// A headset's session as the program makes it, from its cameras' pictures to a take and back.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "mien/core/files.h"
#include "mien/headset/feature_record.h"
#include "mien/headset/picture_packet.h"
#include "mien/headset/wearer_calibration.h"
#include "mien/modalities/modalities.h"
#include "mien/session/replay.h"
#include "mien/take/take.h"
#include "tests/folder.h"
#include "tests/headset/small_jpeg.h"
#include "tests/headset/small_model.h"
#include "tests/project_path.h"

namespace mien::modalities::camera_session_test {
namespace {

using headset::test::Bytes;
using sensor::Verdict;

const std::string kCalibrate = R"({"command": "calibrate", "kind": "short"})";
const std::string kCalibrateGaze = R"({"command": "calibrate", "kind": "gaze"})";

class Headset : public ::testing::Test {
 protected:
  Headset() {
    EXPECT_TRUE(headset::write_views_file(model_, headset::test::small_views_file()));
    for (int n = 0; n < 40; ++n) pictures_.push_back(headset::test::grey_jpeg(64, 64, n));
  }
  [[nodiscard]] std::unique_ptr<session::Session> session(Pictures pictures = Pictures::reduced) const {
    return make_session(headset::test::headset_rig(), model_, {}, {}, pictures).value();
  }
  struct Recorded {
    std::string hash;
    std::size_t measured = 0;  ///< Frames in which the jaw was.
    std::size_t calibrated = 0;
    std::vector<face::OutputFrame> frames;
  };
  /// Whether a camera sends no picture of this number.
  using Lost = std::function<bool(std::uint32_t camera, std::uint32_t number)>;
  static bool right_eye_for_a_while(std::uint32_t camera, std::uint32_t number) {
    return camera == 1 && number > 300 && number < 330;
  }
  /// Six seconds of four cameras with clocks of their own, into a take: `command_`, a calibration, then a
  /// camera that is lost.
  Recorded record(session::Session& session, const std::filesystem::path& path,
                  const Lost& lost = right_eye_for_a_while) {
    take::Header header;
    header.rig_toml = headset::test::headset_rig_text();
    take::TakeWriter writer = take::TakeWriter::create(path, header, false).value();
    Recorded out;
    std::int64_t entry = 0;
    const auto fire = [&](HostTime now) {
      while (const auto tick = session.due(now)) {
        const face::OutputFrame& frame = session.tick(tick->frame, tick->fired);
        out.frames.push_back(frame);
        if (frame.provenance[face::shape("jawOpen")] == face::Provenance::measured) ++out.measured;
        writer.add_tick({tick->index, entry, tick->fired, tick->frame});
      }
    };
    for (std::uint32_t n = 0; n < pictures_each_; ++n) {
      for (std::uint32_t c = 0; c < 4; ++c) {
        if (lost(c, n)) continue;
        const HostTime arrival(frame_offset(n) + std::chrono::milliseconds(6 + c));
        fire(arrival);
        if (n == 60 && c == 0) {
          EXPECT_TRUE(session.command(arrival, command_));
          entry = writer.add_entry(arrival, std::string(session::kPageSource),
                                   std::as_bytes(std::span(command_)));
        }
        ByteWriter packet;
        EXPECT_TRUE(headset::write_picture_packet({.from = {headset::test::kHeadset + c, 0},
                                                   .sequence = n,
                                                   .time = DeviceTime(clock_(c, n)),
                                                   .first = n == 0},
                                                  packet));
        const std::string source = "http://127.0.0.1:" + std::to_string(8081 + c) + "/";
        const auto received =
            session.receive(arrival, {c, source}, packet.bytes(), pictures_[(n + 7 * c) % 40]);
        EXPECT_EQ(received.verdict, Verdict::taken);
        entry = writer.add_entry(arrival, source, received.log, received.payload);
        for (const sensor::Sample& sample : received.samples) writer.add_sample(entry, arrival, sample);
        fire(arrival);
      }
    }
    const auto finished = writer.finish();
    EXPECT_TRUE(finished) << finished.error().message();
    out.calibrated = session.versions().size();
    out.hash = session.hash();
    return out;
  }
  static std::string replayed(const std::filesystem::path& path, session::Session& session) {
    const auto take = take::Take::open(path).value();
    const auto done = session::replay(take, session, [](const auto&, const auto&) { return true; });
    EXPECT_TRUE(done) << done.error().message();
    return session.hash();
  }

  std::string command_ = kCalibrate;
  std::uint32_t pictures_each_ = 360;
  /// What a camera's clock says at a picture.
  std::function<Duration(std::uint32_t camera, std::uint32_t number)> clock_ = [](std::uint32_t camera,
                                                                                  std::uint32_t number) {
    return frame_offset(number) + std::chrono::seconds(3 + 2 * camera);
  };
  mien::test::Folder folder_{mien::test::Folder::On::memory};
  std::filesystem::path model_ = folder_ / "headset.safetensors";
  std::vector<Bytes> pictures_;
};

TEST_F(Headset, LiveWithAndWithoutPicturesAndReplaysGiveTheSameBits) {
  const Recorded reduced = record(*session(), folder_ / "reduced.mien");
  EXPECT_GT(reduced.measured, 330U);
  EXPECT_EQ(reduced.calibrated, 1U);
  const Recorded kept = record(*session(Pictures::kept), folder_ / "kept.mien");
  EXPECT_EQ(kept.hash, reduced.hash);
  for (const char* take : {"reduced.mien", "kept.mien"}) {
    EXPECT_EQ(replayed(folder_ / take, *session()), reduced.hash) << take;
    EXPECT_EQ(replayed(folder_ / take, *session(Pictures::kept)), reduced.hash) << take;
  }
}

TEST_F(Headset, ACalibrationOfGazeReplaysToTheSameBits) {
  command_ = kCalibrateGaze;
  pictures_each_ = 60 * 21;  // 1 s before it, 18 s of it.
  const auto live = session();
  const Recorded played = record(*live, folder_ / "gaze.mien");
  ASSERT_EQ(live->versions().size(), 1U);
  const session::CalibrationVersion& made = live->versions().front();
  EXPECT_EQ(made.origin, "guided");
  const auto calibration = headset::parse_wearer_calibration(made.json, "calibration");
  ASSERT_TRUE(calibration) << calibration.error().message();
  EXPECT_TRUE(calibration->gaze);
  EXPECT_NE(std::ranges::find(made.scores, "gaze targets", &sensor::Score::name), made.scores.end());
  std::vector<std::string> looked;
  for (const take::Event& event : live->take_events())
    if (event.kind == "gaze") looked.push_back(event.json);
  ASSERT_EQ(looked.size(), 5U);
  EXPECT_EQ(looked[1], R"({"name": "look left", "yaw_deg": 15.0, "pitch_deg": 0.0})");
  for (const Pictures pictures : {Pictures::reduced, Pictures::kept})
    EXPECT_EQ(replayed(folder_ / "gaze.mien", *session(pictures)), played.hash);
}

TEST_F(Headset, ATakeHoldsAPictureOnlyWhereItWasAskedFor) {
  record(*session(), folder_ / "reduced.mien");
  record(*session(Pictures::kept), folder_ / "kept.mien");
  const auto payload = [&](const char* name, std::int64_t entry) {
    const auto take = take::Take::open(folder_ / name).value();
    EXPECT_TRUE(take.check());
    auto reader = take.payloads().value();
    const sensor::Payload read = reader.of(entry).value();
    return std::pair(Bytes(read.bytes.begin(), read.bytes.end()), std::string(read.reducer));
  };
  const auto [features, reducer] = payload("reduced.mien", 2);
  EXPECT_TRUE(headset::is_feature_record(features));
  EXPECT_EQ(features.size(), headset::feature_record_bytes(8));
  EXPECT_TRUE(sensor::is_reducer_hash(reducer));
  EXPECT_EQ(payload("kept.mien", 2), std::pair(pictures_[7], std::string()));
}

TEST_F(Headset, AMouthThatNoCameraSeesIsHeldThenNeutralWhileTheEyesAreSeen) {
  const auto played =
      record(*session(), folder_ / "lost.mien",
             [](std::uint32_t camera, std::uint32_t number) { return camera >= 2 && number >= 250; });
  const auto at = [&](std::size_t frame, const char* shape) {
    return played.frames.at(frame).provenance[face::shape_index(shape)];
  };
  EXPECT_EQ(at(245, "jawOpen"), face::Provenance::measured);
  EXPECT_EQ(at(270, "jawOpen"), face::Provenance::held);
  EXPECT_EQ(at(270, "eyeBlink_L"), face::Provenance::measured);
  EXPECT_EQ(at(340, "jawOpen"), face::Provenance::neutral);
  EXPECT_EQ(at(340, "eyeBlink_R"), face::Provenance::measured);
}

TEST_F(Headset, GoesOnWhateverACamerasClockDoes) {
  const auto nothing_lost = [](std::uint32_t, std::uint32_t) { return false; };
  const auto right = clock_;
  const std::size_t quiet = record(*session(), folder_ / "right.mien", nothing_lost).frames.size();
  const auto hour = std::chrono::hours(1);
  struct Wrong {
    const char* name;
    std::function<Duration(Duration right, std::uint32_t number)> time;
  };
  for (const Wrong& wrong : {
           Wrong{"stands still", [](Duration, std::uint32_t) { return Duration(std::chrono::seconds(5)); }},
           Wrong{"runs back",
                 [](Duration, std::uint32_t n) { return std::chrono::seconds(9) - frame_offset(n); }},
           Wrong{"an hour ahead", [&](Duration t, std::uint32_t) { return t + hour; }},
           Wrong{"an hour ahead at times",
                 [&](Duration t, std::uint32_t n) { return n % 50 == 0 ? t + hour : t; }},
           Wrong{"an hour ahead and back by turns",
                 [&](Duration t, std::uint32_t n) { return n % 2 == 0 ? t + hour : t; }},
       })
    for (const std::uint32_t which : {0U, 2U}) {  // The rig's reference, and another.
      SCOPED_TRACE(fmt::format("camera {} {}", which, wrong.name));
      clock_ = [&](std::uint32_t camera, std::uint32_t number) {
        const Duration time = right(camera, number);
        return camera == which && number >= 100 ? wrong.time(time, number) : time;
      };
      const auto played = record(*session(), folder_ / "wrong.mien", nothing_lost);
      EXPECT_NEAR(static_cast<double>(played.frames.size()), static_cast<double>(quiet), 3);
      EXPECT_EQ(played.frames.back().provenance[face::shape("jawOpen")], face::Provenance::measured);
      EXPECT_EQ(replayed(folder_ / "wrong.mien", *session()), played.hash);
      std::filesystem::remove(folder_ / "wrong.mien");
    }
}

TEST_F(Headset, TakesAnotherNetworksFeaturesForNone) {
  record(*session(), folder_ / "reduced.mien");
  headset::ViewsFile wide = headset::test::small_views_file();
  wide.architecture.features = 16;
  Random random(5);
  wide.network.clear();
  for (const model::TensorSpec& spec : model::network_tensors(wide.architecture)) {
    std::size_t count = 1;
    for (const std::size_t n : spec.shape) count *= n;
    std::vector<float> values(count);
    for (float& value : values) value = static_cast<float>(random.uniform(-0.4, 0.5));
    wide.network.push_back({.name = spec.name, .shape = spec.shape, .values = std::move(values)});
  }
  ASSERT_TRUE(headset::write_views_file(folder_ / "wide.safetensors", wide));
  const auto other = make_session(headset::test::headset_rig(), folder_ / "wide.safetensors").value();
  replayed(folder_ / "reduced.mien", *other);
  EXPECT_EQ(other->sensors_present(), 0U);
}

TEST_F(Headset, AModelThatIsNotThereIsToBeTrained) {
  const auto missing = make_session(headset::test::headset_rig(), folder_ / "none.safetensors");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::not_found);
  EXPECT_NE(missing.error().message().find("mien train models/recipes/headset.toml"), std::string::npos);
  ASSERT_TRUE(write_file(folder_ / "text.safetensors", std::as_bytes(std::span("no model", 8))));
  const auto broken = make_session(headset::test::headset_rig(), folder_ / "text.safetensors");
  ASSERT_FALSE(broken);
  EXPECT_NE(broken.error().message().find("text.safetensors"), std::string::npos);
  EXPECT_FALSE(has_window_models(headset::test::headset_rig()));
}

TEST_F(Headset, IsOneOfSeveralKindsOfSensors) {
  sensor::Rig rig = headset::test::headset_rig();
  rig.sensors.push_back({.name = "phone", .kind = "weights", .role = "face", .device = "02:4D:49:45:4E:70"});
  const auto both = make_session(rig, model_);
  ASSERT_TRUE(both) << both.error().message();
  EXPECT_EQ((*both)->modality(), "camera+weights");
}

TEST_F(Headset, WithAKeyNobodyOnANetworkSendsPictures) {
  const sensor::SealKey key{.id = 4, .secret = {std::byte{9}}};
  const Protocols protocols = make_protocols({key}).value();
  ASSERT_EQ(protocols.size(), 3U);
  EXPECT_EQ(protocols[0]->name(), "sound");
  EXPECT_EQ(protocols[1]->name(), "picture");
  EXPECT_TRUE(make_session(headset::test::headset_rig(), model_, {}, {key}));
}

}  // namespace
}  // namespace mien::modalities::camera_session_test
