// A microphone on the network, from its packets to the mouth: its clock, bad sound, gaps, the switch.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "mien/imu/packets/packet.h"
#include "mien/modalities/modalities.h"
#include "mien/sensor/packet_envelope.h"
#include "mien/session/command.h"
#include "mien/session/session.h"
#include "mien/speech/sound_block.h"
#include "mien/speech/speech_tracker.h"
#include "mien/virtual/sealed_node.h"
#include "mien/virtual/speaking_node.h"
#include "mien/virtual/speech/microphone_simulator.h"
#include "tests/allocation_count.h"
#include "tests/project_path.h"

namespace mien::session::microphone_session_test {
namespace {

using face::Provenance;
using sensor::Verdict;

const std::size_t kJaw = face::shape("jawOpen");
constexpr std::uint64_t kChin = 0x024D'4945'4E00ULL;

sensor::Rig rig_of(int microphones, bool chin = false) {
  sensor::Rig rig{.name = "heard", .reference = chin ? "chin" : "microphone"};
  if (chin)
    rig.sensors.push_back(
        {.name = "chin", .kind = "imu", .role = "face", .device = sensor::format_device({kChin, 0})});
  for (int m = 0; m < microphones; ++m)
    rig.sensors.push_back(
        {.name = m == 0 ? "microphone" : "other",
         .kind = "speech",
         .role = "face",
         .device = sensor::format_device({speech::kAnyMicrophone + static_cast<std::uint64_t>(m), 0})});
  return rig;
}

/// Opens the jaw while it is loud, from the loud block's beginning.
class Loud final : public speech::Listener {
 public:
  speech::Heard push(DeviceTime time, const speech::Block& block) override {
    speech::Heard heard{.time = time, .weights = {}, .voice = 1};
    heard.weights[kJaw] = speech::loudness_of(block).peak > 0.2F ? 1 : 0;
    return heard;
  }
  void reset() override {}
};

std::unique_ptr<speech::SpeechTracker> loud_tracker(const sensor::Rig& rig) {
  return speech::SpeechTracker::create(
             rig, [] { return Result<std::unique_ptr<speech::Listener>>(std::make_unique<Loud>()); })
      .value();
}

/// A session in which sound is heard by its loudness.
std::unique_ptr<Session> loud_session(const sensor::Rig& rig) {
  Session::Parts parts;
  parts.rig = rig;
  parts.trackers.push_back(loud_tracker(rig));
  parts.protocols = modalities::make_protocols().value();
  return Session::create(std::move(parts)).value();
}

/// A block of what `sample(i)` says, as the microphone of this number sends it when it is over.
template <class SampleOf>
virt::Datagram block(std::uint64_t number, SampleOf sample, std::uint64_t microphone = 0) {
  speech::Block samples;
  for (std::size_t i = 0; i < samples.size(); ++i)
    samples[i] = static_cast<std::int16_t>(sample(number * speech::kBlockSamples + i));
  const HostTime arrival{speech::kBlockDuration * static_cast<std::int64_t>(number + 1)};
  return {arrival, static_cast<std::uint16_t>(microphone),
          speech::encode_packet({speech::kAnyMicrophone + microphone, number}, samples).value()};
}

int tone(std::size_t i) {
  return static_cast<int>(10'000 * std::sin(2 * std::numbers::pi * 200 * static_cast<double>(i) / 16'000));
}

/// All frames that the datagrams make.
std::vector<face::OutputFrame> play(Session& session, const std::vector<virt::Datagram>& arrived) {
  std::vector<face::OutputFrame> frames;
  const auto fire = [&](HostTime now) {
    while (const auto due = session.due(now)) frames.push_back(session.tick(due->frame, due->fired));
  };
  for (const virt::Datagram& datagram : arrived) {
    fire(datagram.time);
    session.receive(datagram.time, {datagram.source, datagram.source == 0 ? "udp://a:1" : "udp://b:2"},
                    datagram.bytes);
    fire(datagram.time);
  }
  // What is not heard any more lets frames go on too.
  fire(arrived.back().time + std::chrono::seconds(1));
  return frames;
}

struct Feed final : SampleConsumer {
  explicit Feed(tracker::Tracker& t) : tracker(t) {}
  void add(HostTime arrival, const sensor::Sample& sample, std::span<const std::byte> payload) override {
    tracker.add_with_payload(arrival, sample, payload);
  }
  void rebound(std::uint16_t, const sensor::DeviceKey&, bool) override {}
  tracker::Tracker& tracker;
};

/// Half a second of every ten is loud.
struct Drifted {
  double worst_s = 0;         ///< Of all times at which the jaw opened, against when it truly got loud.
  std::size_t opened = 0;     ///< How often.
  std::size_t allocated = 0;  ///< After the first minute.
};
Drifted hear_for(double seconds, double drift_ppm) {
  const sensor::Rig rig = rig_of(1, true);
  const auto receiver = Receiver::create(rig, modalities::make_protocols().value()).value();
  const auto tracker = loud_tracker(rig);
  Feed feed(*tracker);
  const virt::SoundInAir sound =
      virt::SoundInAir::of(
          {.rate_hz = speech::kRateHz, .samples = std::vector<float>(speech::kRateHz / 2, 0.5F)})
          .value();
  virt::MicrophoneFaults faults;
  faults.radio_delay_ms = 2;
  faults.packet_loss = 0.002;
  const virt::VirtualClock chin{.offset_s = 5, .rate = 1 - 20e-6};
  virt::MicrophoneSimulator microphone(sound, faults, speech::kAnyMicrophone, Random(7),
                                       {.offset_s = 40, .rate = 1 + 1e-6 * drift_ppm});
  Drifted drifted;
  float jaw = 0;
  const auto receive = [&](const virt::Datagram& datagram) {
    const std::size_t before = mien::test::allocation_count();
    receiver->receive(datagram.time, {datagram.source, datagram.source == 0 ? "udp://a:1" : "udp://b:2"},
                      datagram.bytes, feed);
    while (const auto due = receiver->due(datagram.time)) {
      face::OutputFrame out;
      tracker->tick(due->frame, receiver->lines(), out);
      const double true_s = chin.true_s(due->frame);
      if (out.weights[kJaw] > 0.5F && jaw <= 0.5F && true_s > 9) {
        drifted.worst_s = std::max(drifted.worst_s, std::abs(true_s - 10 * std::round(true_s / 10)));
        ++drifted.opened;
      }
      jaw = out.weights[kJaw];
    }
    if (datagram.time > HostTime(std::chrono::minutes(1)))
      drifted.allocated += mien::test::allocation_count() - before;
  };
  std::vector<virt::Datagram> sent;
  std::uint32_t sequence = 0;
  for (double now_s = 0; now_s < seconds; now_s += 0.04) {
    sensor::Sample still{
        .kind = sensor::SampleKind::imu_raw,
        .time =
            DeviceTime(std::chrono::floor<std::chrono::microseconds>(chin.device(now_s).time_since_epoch())),
        .count = 6,
        .values = {0, 0, 0, 0, 9.8F, 0}};
    imu::Packet packet = imu::make_packet({&still, 1}).value();
    packet.device = kChin;
    packet.sequence = sequence++;
    receive({HostTime(from_seconds(now_s + 0.001)), 1, imu::encode_packet(packet).value()});
    sent.clear();
    while (microphone.heard_s() < now_s + 0.04) {
      const double begun_s = 10 * std::floor((microphone.heard_s() + 0.01) / 10);
      EXPECT_TRUE(microphone.hear([begun_s](double true_s) { return true_s - begun_s; }, sent));
    }
    for (const virt::Datagram& datagram : sent) receive(datagram);
  }
  return drifted;
}

TEST(MicrophoneSession, AnHourOfSoundThatRuns300PpmFastStaysInStep) {
  const Drifted fast = hear_for(3'600, 300);
  EXPECT_GT(fast.opened, 340U);
  EXPECT_LT(fast.worst_s, 0.04) << "a block of 20 ms, and a frame of 17";
  EXPECT_EQ(fast.allocated, 0U) << "after the first minute nothing grows";
  // Beyond 100 ppm a clock model lets a clock go from its line for as long as it remembers: a minute, 12 ms.
  const Drifted slow = hear_for(600, -300);
  EXPECT_GT(slow.opened, 50U);
  EXPECT_LT(slow.worst_s, 0.04);
  RecordProperty("worst_fast_ms", static_cast<int>(1e3 * fast.worst_s));
  RecordProperty("worst_slow_ms", static_cast<int>(1e3 * slow.worst_s));
}

TEST(MicrophoneSession, OfTwoTheFirstIsListenedToAndTheOtherIsReported) {
  std::vector<virt::Datagram> alone, both;
  for (std::uint64_t n = 0; n < 150; ++n) {
    const auto says = [&](std::size_t i) { return n % 50 < 20 ? tone(i) : 0; };
    alone.push_back(block(n, says));
    both.push_back(alone.back());
    both.push_back(block(
        n, [](std::size_t i) { return 3 * tone(i); }, 1));
  }
  const auto one = loud_session(rig_of(2)), two = loud_session(rig_of(2));
  const std::vector<face::OutputFrame> expected = play(*one, alone), frames = play(*two, both);
  ASSERT_EQ(frames.size(), expected.size());
  std::size_t open = 0;
  for (std::size_t f = 0; f < frames.size(); ++f) {
    EXPECT_EQ(frames[f].weights[kJaw], expected[f].weights[kJaw]) << f;
    open += frames[f].weights[kJaw] > 0.5F ? 1 : 0;
  }
  EXPECT_GT(open, 30U);
  Report report;
  two->report(both.back().time, report);
  ASSERT_EQ(report.links.size(), 2U);
  for (const Report::Link& link : report.links) EXPECT_EQ(link.health.state, sensor::LinkState::good);
  EXPECT_GT(report.links[1].level.value_or(0), 0.8F) << "it is there and loud, and nobody listens to it";
}

TEST(MicrophoneSession, OneThatVanishesInMidSentenceComesBack) {
  std::vector<virt::Datagram> sent;
  for (std::uint64_t n = 0; n < 300; ++n)
    if (n < 100 || n >= 200) sent.push_back(block(n, tone));
  const auto session = loud_session(rig_of(1));
  std::size_t gone = 0, back = 0;
  for (const face::OutputFrame& frame : play(*session, sent)) {
    for (const float weight : frame.weights.values) ASSERT_TRUE(std::isfinite(weight));
    const double s = to_seconds(frame.time.time_since_epoch());
    if (s > 2.7 && s < 3.9) {
      EXPECT_EQ(frame.provenance[kJaw] == Provenance::audio, false) << s;
      ++gone;
    }
    if (s > 4.5 && s < 5.8 && frame.weights[kJaw] > 0.9F && frame.provenance[kJaw] == Provenance::audio)
      ++back;
  }
  EXPECT_GT(gone, 60U);
  EXPECT_GT(back, 70U);
}

/// What the network of speech makes of sound that is none.
class BadSound : public ::testing::TestWithParam<std::pair<const char*, int (*)(std::size_t)>> {};

TEST_P(BadSound, DoesNotTalk) {
  const sensor::Rig rig = rig_of(1);
  const auto session = modalities::make_session(rig, project_path("models/speech.safetensors")).value();
  std::vector<virt::Datagram> sent;
  for (std::uint64_t n = 0; n < 500; ++n) sent.push_back(block(n, GetParam().second));
  std::size_t moves = 0, later = 0;
  const std::vector<face::OutputFrame> frames = play(*session, sent);
  EXPECT_GT(frames.size(), 500U);
  for (const face::OutputFrame& frame : frames) {
    float most = 0;
    for (const float weight : frame.weights.values) {
      ASSERT_TRUE(std::isfinite(weight));
      ASSERT_LE(std::abs(weight), 1.0F);
      most = std::max(most, std::abs(weight));
    }
    moves += most > 0.05F ? 1 : 0;
    later += most > 0.05F && frame.time > DeviceTime(std::chrono::seconds(1)) ? 1 : 0;
  }
  // Its beginning is a click, which may be a burst of the lips.
  EXPECT_LT(moves, 45U);
  EXPECT_EQ(later, 0U);
}

INSTANTIATE_TEST_SUITE_P(MicrophoneSession, BadSound,
                         ::testing::Values(std::pair(
                                               "silence", +[](std::size_t) { return 0; }),
                                           std::pair(
                                               "direct current", +[](std::size_t) { return 12'000; }),
                                           std::pair(
                                               "full scale", +[](std::size_t) { return 32'767; }),
                                           std::pair(
                                               "negative full scale", +[](std::size_t) { return -32'768; }),
                                           std::pair(
                                               "alternating samples",
                                               +[](std::size_t i) { return i % 2 == 0 ? 32'767 : -32'768; }),
                                           std::pair(
                                               "alternating blocks",
                                               +[](std::size_t i) {
                                                 return i / 320 % 2 == 0 ? 32'767 : -32'768;
                                               })),
                         [](const auto& one) {
                           std::string name = one.param.first;
                           std::erase(name, ' ');
                           return name;
                         });

TEST(MicrophoneSession, ASwitchThatIsOffKeepsNothingOfIt) {
  const auto session = loud_session(rig_of(1));
  const virt::Datagram first = block(0, tone);
  EXPECT_EQ(session->receive(first.time, {0, "udp://a:1"}, first.bytes).log.size(), speech::kPacketBytes);
  ASSERT_TRUE(session->command(first.time, write_command(Shape{R"({"merge": {"audio": false}})"})));
  const virt::Datagram second = block(1, tone);
  const auto received = session->receive(second.time, {0, "udp://a:1"}, second.bytes);
  EXPECT_EQ(received.verdict, Verdict::ignored);
  EXPECT_TRUE(received.log.empty()) << "a voice that nobody asked for is not recorded";
  EXPECT_TRUE(received.samples.empty());
  ASSERT_TRUE(session->command(second.time, write_command(Shape{R"({"merge": {"audio": true}})"})));
  const virt::Datagram third = block(2, tone);
  EXPECT_EQ(session->receive(third.time, {0, "udp://a:1"}, third.bytes).samples.size(), 1U);
}

TEST(MicrophoneSession, StrangersAreNotRecorded) {
  // A rig without a microphone, and one whose microphone is another.
  for (const int microphones : {0, 1}) {
    const auto receiver =
        Receiver::create(rig_of(microphones, true), modalities::make_protocols().value()).value();
    struct Nobody final : SampleConsumer {
      void add(HostTime, const sensor::Sample&, std::span<const std::byte>) override { ADD_FAILURE(); }
      void rebound(std::uint16_t, const sensor::DeviceKey&, bool) override { ADD_FAILURE(); }
    } nobody;
    const virt::Datagram stranger = block(0, tone, 7);
    const auto received = receiver->receive(stranger.time, {1, "udp://b:2"}, stranger.bytes, nobody);
    EXPECT_EQ(received.verdict, Verdict::ignored);
    EXPECT_TRUE(received.log.empty()) << "nobody asked for this voice";
  }
}

TEST(MicrophoneSession, OneThatIsToTakeNoSoundTakesNoneWhateverItIsTold) {
  const auto session = loud_session(rig_of(1));
  session->take_no_sound();
  const HostTime now{};
  ASSERT_TRUE(session->command(now, write_command(Shape{R"({"merge": {"audio": true}})"})));
  ASSERT_TRUE(session->command(now, write_command(Bind{"microphone", {speech::kAnyMicrophone + 1, 0}})));
  for (const std::uint64_t microphone : {0U, 1U}) {
    const virt::Datagram sound = block(0, tone, microphone);
    const auto received = session->receive(sound.time, {0, "udp://a:1"}, sound.bytes);
    EXPECT_TRUE(received.log.empty());
    EXPECT_TRUE(received.samples.empty());
  }
}

TEST(MicrophoneSession, WithAKeyOnlyASealedOneIsHeard) {
  const sensor::SealKey key{.id = 1, .secret = {std::byte{7}}};
  const auto receiver = Receiver::create(rig_of(1), modalities::make_protocols({key}).value()).value();
  struct Ear final : SampleConsumer {
    void add(HostTime, const sensor::Sample&, std::span<const std::byte> payload) override {
      heard = speech::samples_of(payload);
    }
    void rebound(std::uint16_t, const sensor::DeviceKey&, bool) override {}
    std::optional<speech::Block> heard;
  } ear;
  const virt::Datagram plain = block(0, tone);
  const Sender sender{0, "udp://a:1"};
  EXPECT_EQ(receiver->receive(plain.time, sender, plain.bytes, ear).verdict, Verdict::refused);
  // A header without its block, which only this machine's own sources have, says nothing either.
  const auto header = speech::encode_header({speech::kThisMachine, 0}).value();
  EXPECT_EQ(receiver->receive(plain.time, sender, header, ear).verdict, Verdict::malformed);

  virt::SpeakingNode microphone(speech::kAnyMicrophone);
  virt::SealedNode paired(microphone, key);
  const auto hello = paired.next_datagram(HostTime());
  ASSERT_TRUE(hello);
  const auto welcomed = receiver->receive(HostTime(), sender, *hello, ear);
  paired.receive(HostTime(), welcomed.reply);
  EXPECT_TRUE(paired.answered());
  paired.begin(HostTime());
  microphone.hand_over(plain);
  std::size_t blocks = 0;
  while (const auto sealed = paired.next_datagram(plain.time)) {
    const auto received = receiver->receive(plain.time, sender, *sealed, ear);
    if (received.samples.empty()) continue;
    ++blocks;
    EXPECT_TRUE(std::ranges::equal(received.log, plain.bytes)) << "a replay needs no key";
  }
  EXPECT_EQ(blocks, 1U);
  EXPECT_EQ(ear.heard, speech::logged_block(plain.bytes, {})->block);
}

}  // namespace
}  // namespace mien::session::microphone_session_test
