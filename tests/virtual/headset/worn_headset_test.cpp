// A headset's cameras as a performer wears them: what they send, and the take that it makes.
#include "mien/virtual/headset/worn_headset.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <map>
#include <span>
#include <string>

#include "mien/core/files.h"
#include "mien/headset/picture_decoder.h"
#include "mien/headset/picture_packet.h"
#include "mien/session/command.h"
#include "mien/virtual/node.h"
#include "mien/virtual/node_group.h"
#include "mien/virtual/perform_take.h"
#include "tests/folder.h"
#include "tests/project_path.h"
#include "tests/virtual/three_sensors.h"

namespace mien::virt::worn_headset_test {
namespace {

using ::testing::HasSubstr;

/// Every `from` in the text becomes `to`.
std::string with(std::string text, std::string_view from, std::string_view to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
  return text;
}

std::string shipped() {
  return read_text(project_path("rigs/headset.toml")).value();
}
/// The shipped headset with small and few pictures.
std::string small() {
  return with(with(shipped(), "size = [240, 240]", "size = [64, 48]"), "rate_hz = 60.0", "rate_hz = 20.0");
}

class WornHeadsetTest : public ::testing::Test {
 protected:
  void SetUp() override {
    request_.motion = test::talking(61);  // A second.
    request_.prologue = performer::PrologueKind::none;
    request_.seed = 5;
  }
  StageRequest& with_rig(const std::string& toml) {
    EXPECT_TRUE(write_file(folder_ / "rig.toml", toml));
    request_.rig = folder_ / "rig.toml";
    return request_;
  }
  Error refused(const std::string& toml) {
    const auto stage = set_stage(with_rig(toml));
    EXPECT_FALSE(stage);
    return stage ? Error{} : stage.error();
  }
  mien::test::Folder folder_;
  StageRequest request_;
};

Sent sent_by(const StageRequest& request) {
  const Stage stage = set_stage(request).value();
  return stage.worn->send(stage, no_progress).value();
}

/// What every camera sent, by its device's last octet.
std::map<std::uint64_t, std::vector<headset::PicturePacket>> packets_of(const Sent& sent) {
  std::map<std::uint64_t, std::vector<headset::PicturePacket>> packets;
  for (const Datagram& datagram : sent.datagrams) {
    const auto packet = headset::parse_picture_packet(datagram.bytes).value();
    packets[packet.from.device & 0xFFU].push_back(packet);
  }
  return packets;
}

TEST_F(WornHeadsetTest, SendsEveryCamerasPicturesAtItsRate) {
  with_rig(with(small(), "lost = 0.002", "lost = 0"));
  const Sent sent = sent_by(request_);
  const auto packets = packets_of(sent);
  ASSERT_EQ(packets.size(), 4U);
  for (const auto& [camera, all] : packets) {
    // A second, and a quarter before and after.
    EXPECT_NEAR(static_cast<double>(all.size()), 20 * 1.5, 1) << camera;
    EXPECT_TRUE(all.front().first);
    for (std::size_t i = 0; i < all.size(); ++i) {
      EXPECT_EQ(all[i].sequence, i);
      EXPECT_EQ(all[i].first, i == 0);
      ASSERT_TRUE(all[i].time);
      if (i == 0) continue;
      EXPECT_NEAR(to_seconds(*all[i].time - *all[i - 1].time), 1.0 / 20, 0.003) << "jitter of 0.3 ms";
    }
  }
  EXPECT_NE(packets.at(0).front().time, packets.at(1).front().time) << "each board has a clock";
}

TEST_F(WornHeadsetTest, PicturesAreJpegsThatComeAfterTheyWereRead) {
  with_rig(small());
  const Sent sent = sent_by(request_);
  headset::PictureDecoder decoder = headset::PictureDecoder::create().value();
  std::map<std::uint16_t, HostTime> newest;
  for (const Datagram& datagram : sent.datagrams) {
    const auto picture = decoder.decode(datagram.payload, 64, 48);
    ASSERT_TRUE(picture) << datagram.source;
    EXPECT_EQ(picture->width, 64);
    EXPECT_EQ(picture->height, 48);
    const auto before = newest.emplace(datagram.source, datagram.time).first;
    EXPECT_GE(datagram.time, before->second);
    before->second = datagram.time;
    if (datagram.source != 0) continue;  // The reference, whose clock is known.
    const double read_s = sent.reference.true_s(*headset::parse_picture_packet(datagram.bytes)->time);
    const double late_s = to_seconds(datagram.time.time_since_epoch()) - read_s;
    EXPECT_GT(late_s, 0.008) << "rows are read for 8 ms";
    EXPECT_LT(late_s, 0.05);
  }
}

TEST_F(WornHeadsetTest, TheSameStreamGivesTheSameBytes) {
  request_.motion = test::talking(16);
  with_rig(small());
  const Sent one = sent_by(request_), two = sent_by(request_);
  ASSERT_EQ(one.datagrams.size(), two.datagrams.size());
  for (std::size_t i = 0; i < one.datagrams.size(); ++i) {
    EXPECT_EQ(one.datagrams[i].bytes, two.datagrams[i].bytes);
    EXPECT_EQ(one.datagrams[i].payload, two.datagrams[i].payload);
    EXPECT_EQ(one.datagrams[i].time, two.datagrams[i].time);
  }
  request_.seed = 6;
  EXPECT_NE(sent_by(request_).datagrams[0].payload, one.datagrams[0].payload);
}

TEST_F(WornHeadsetTest, LostPicturesAreCountedAndChangeNoOthers) {
  with_rig(with(small(), "lost = 0.002", "lost = 0"));
  const Sent whole = sent_by(request_);
  with_rig(with(small(), "lost = 0.002", "lost = 0.3"));
  const Sent gaps = sent_by(request_);
  EXPECT_NEAR(static_cast<double>(gaps.datagrams.size()), 0.7 * static_cast<double>(whole.datagrams.size()),
              0.15 * static_cast<double>(whole.datagrams.size()));
  std::map<std::pair<std::uint16_t, std::uint32_t>, const Datagram*> all;
  for (const Datagram& datagram : whole.datagrams)
    all[{datagram.source, headset::parse_picture_packet(datagram.bytes)->sequence}] = &datagram;
  for (const Datagram& datagram : gaps.datagrams) {
    const Datagram& same =
        *all.at({datagram.source, headset::parse_picture_packet(datagram.bytes)->sequence});
    EXPECT_EQ(same.payload, datagram.payload);
    EXPECT_EQ(same.time, datagram.time);
  }
}

TEST_F(WornHeadsetTest, ASlowerCameraTakesPartInAShareOfTheShots) {
  std::string rig = with(small(), "lost = 0.002", "lost = 0");
  const std::size_t last = rig.rfind("rate_hz = 20.0");
  rig.replace(last, 14, "rate_hz = 15.0");
  with_rig(rig);
  const auto packets = packets_of(sent_by(request_));
  EXPECT_NEAR(static_cast<double>(packets.at(0).size()), 30, 1);
  EXPECT_NEAR(static_cast<double>(packets.at(3).size()), 22.5, 1.5);
  EXPECT_EQ(packets.at(3).back().sequence, packets.at(3).size() - 1);
}

TEST(HeadsetBoards, JpegsHaveTheSizeOfTheBoards) {
  const sensor::Rig rig = sensor::read_rig(project_path("rigs/headset.toml")).value();
  HeadsetFaults faults = parse_headset_faults(rig.faults_toml, "rig").value();
  const auto mean_kb = [&](double quality) {
    faults.jpeg_quality = {quality, quality};
    double bytes = 0;
    std::vector<BoardPicture> pictures;
    for (std::uint64_t wearer = 0; wearer < 2; ++wearer) {
      const HeadsetWearer drawn = draw_headset_wearer(rig, faults, Random(wearer)).value();
      HeadsetBoards boards = HeadsetBoards::put_on(drawn, rig, faults, Random(wearer), {}).value();
      for (int i = 0; i < 2; ++i) EXPECT_TRUE(boards.shoot([](double) { return HeadsetMoment(); }, pictures));
    }
    for (const BoardPicture& picture : pictures) bytes += static_cast<double>(picture.jpeg.size());
    return 1e-3 * bytes / static_cast<double>(pictures.size());
  };
  const double fine = mean_kb(7), coarse = mean_kb(15);
  EXPECT_GT(fine, 7);
  EXPECT_LT(fine, 11);
  EXPECT_GT(coarse, 3.4);
  EXPECT_LT(coarse, 5.6);
  EXPECT_GT(jpeg_quality_of(4), jpeg_quality_of(7));
  EXPECT_GE(jpeg_quality_of(63), 1);
}

TEST_F(WornHeadsetTest, ATakeHoldsPicturesAndTruth) {
  request_.prologue = performer::PrologueKind::brief;
  PerformRequest request;
  static_cast<StageRequest&>(request) = with_rig(with(small(), "rate_hz = 20.0", "rate_hz = 10.0"));
  request.take = folder_ / "a.mien";
  const PerformSummary summary = perform_take(request, no_progress).value();
  const take::Take take = take::Take::open(request.take).value();
  EXPECT_TRUE(take.check());
  std::vector<take::LogEntry> entries = take.entries().value();
  EXPECT_EQ(entries.front().source, session::kPageSource) << "the calibration's command";
  entries.erase(entries.begin());
  EXPECT_EQ(entries.size(), summary.packets);
  EXPECT_NEAR(static_cast<double>(entries.size()), 40 * (summary.duration_s + 0.5), 12);
  take::PayloadReader payloads = take.payloads().value();
  headset::PictureDecoder decoder = headset::PictureDecoder::create().value();
  for (const take::LogEntry& entry : entries) {
    const sensor::Payload payload = payloads.of(entry.id).value();
    EXPECT_EQ(payload.reducer, "") << "raw: no model has seen them";
    ASSERT_TRUE(decoder.decode(payload.bytes, 64, 48)) << entry.id;
  }
  const std::vector<take::Tick> ticks = take.ticks().value();
  const std::vector<take::TruthFrame> truth = take.truth().value();
  ASSERT_EQ(truth.size(), ticks.size());
  // As the pictures, frames go on for half a second in which the last ones may still come.
  EXPECT_NEAR(static_cast<double>(ticks.size()), 60 * (summary.duration_s + 0.5), 20);
  EXPECT_GT(ticks.back().after_entry, static_cast<std::int64_t>(entries.size()) * 9 / 10);
  // A second of the motion is evaluated, the prologue is not; the jaw moves in it.
  EXPECT_NEAR(static_cast<double>(std::ranges::count_if(truth, &take::TruthFrame::evaluated)), 60, 4);
  const std::vector<take::Event> events = take.events().value();
  const auto neutral = std::ranges::find(events, "neutral", &take::Event::kind);
  ASSERT_NE(neutral, events.end());
  EXPECT_GE(to_seconds(neutral->end - neutral->begin), 2.9);
  EXPECT_EQ(std::ranges::find(events, "nod", &take::Event::kind), events.end());
}

TEST_F(WornHeadsetTest, AFailureThatBeginsWhenTheMotionIsOverIsRefused) {
  with_rig(small());
  request_.headset_failure = parse_timed_failure("sun@100-200").value();
  const auto refused = set_stage(request_);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::out_of_range);
}

TEST_F(WornHeadsetTest, AFailureHappensWhenItIsToAndStandsInTheTake) {
  with_rig(small());
  request_.headset_failure = parse_timed_failure("mask@0.4-0.7").value();
  const Stage stage = set_stage(request_).value();
  const VirtualSession session = play(stage).value();
  const auto event = std::ranges::find(session.events, "headset_failure", &take::Event::kind);
  ASSERT_NE(event, session.events.end());
  EXPECT_NEAR(to_seconds(event->end - event->begin), 0.3, 1e-3);
  EXPECT_NEAR(to_seconds(event->begin - session.motion_start), 0.4, 1e-3);
  EXPECT_EQ(event->json, R"({"name": "mask", "sees_upper": true, "sees_lower": false})");

  const auto* headset = headset_of(stage);
  ASSERT_NE(headset, nullptr);
  const std::optional<performer::Encore> once;
  const face::MotionCurve curve(stage.motion.motion);
  EXPECT_FALSE(headset->moment_at(stage, {curve, once}, 0.39).fails);
  EXPECT_TRUE(headset->moment_at(stage, {curve, once}, 0.41).fails);
  EXPECT_FALSE(headset->moment_at(stage, {curve, once}, 0.71).fails);
}

TEST_F(WornHeadsetTest, AWholeFailureIsThereFromTheBeginning) {
  request_.motion = test::talking(16);
  request_.headset_failure = parse_timed_failure("smear").value();
  const VirtualSession session = play(set_stage(with_rig(small())).value()).value();
  const auto event = std::ranges::find(session.events, "headset_failure", &take::Event::kind);
  ASSERT_NE(event, session.events.end());
  EXPECT_THAT(event->json, HasSubstr(R"("sees_upper": false, "sees_lower": false)"));
  EXPECT_NEAR(to_seconds(event->begin - session.motion_start), 0, 1e-3);
}

TEST(TimedFailure, IsReadAsPeopleWriteIt) {
  EXPECT_EQ(parse_timed_failure("hand"), (TimedFailure{.failure = HeadsetFailure::hand}));
  EXPECT_EQ(parse_timed_failure("mask@1.5-9"),
            (TimedFailure{.failure = HeadsetFailure::mask, .from_s = 1.5, .to_s = 9}));
  EXPECT_EQ(parse_timed_failure("sun@4-"), (TimedFailure{.failure = HeadsetFailure::sun, .from_s = 4}));
  for (const char* text : {"", "foot", "none", "hand@", "hand@4", "hand@-4", "hand@4-3", "hand@4-4",
                           "hand@a-b", "hand@1-2-3", "hand@nan-5", "hand@-1-5", "@1-2"}) {
    const auto parsed = parse_timed_failure(text);
    ASSERT_FALSE(parsed) << text;
    EXPECT_EQ(parsed.error().code, ErrorCode::bad_usage) << text;
  }
  EXPECT_THAT(parse_timed_failure("foot").error().fix, HasSubstr("hand, cup, mask"));
}

TEST_F(WornHeadsetTest, RefusesWhatCannotBe) {
  request_.headset_failure = parse_timed_failure("hand").value();
  EXPECT_THAT(refused(test::kRig).what, HasSubstr("no cameras"));
  request_.headset_failure.reset();
  request_.devices = "lab";
  EXPECT_EQ(refused(small()).code, ErrorCode::bad_usage);
  request_.devices = "device";
  request_.unlike = 1;
  EXPECT_EQ(refused(small()).code, ErrorCode::bad_usage);
  request_.unlike = 0;
  EXPECT_EQ(refused(with(small(), "lost = 0.002", "lost = 2")).code, ErrorCode::out_of_range);
  EXPECT_EQ(
      refused(with(small(), "position_m = [0.0500, 0.0200, 0.1245]", "position_m = [0, -0.02, 0.05]")).code,
      ErrorCode::out_of_range);

  const Stage stage = set_stage(with_rig(small())).value();
  const auto nodes = NodeGroup::create(stage, NodeLanguage::mien, false);
  ASSERT_FALSE(nodes);
  EXPECT_THAT(nodes.error().fix, HasSubstr("http://"));

  request_.motion = test::talking(16);
  request_.motion->frames.back().time_s = WornHeadset::kLongestS + 1;
  const Stage longest = set_stage(request_).value();
  EXPECT_EQ(longest.worn->send(longest, no_progress).error().code, ErrorCode::out_of_range);
}

TEST_F(WornHeadsetTest, StopsWhenAsked) {
  const Stage stage = set_stage(with_rig(small())).value();
  int asked = 0;
  const auto stopped = stage.worn->send(stage, [&](double, std::string_view) { return ++asked < 3; });
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, ErrorCode::cancelled);
  EXPECT_EQ(asked, 3);
}

}  // namespace
}  // namespace mien::virt::worn_headset_test
