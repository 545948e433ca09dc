// A whole session on a serial line: a device speaks at its full rate, is unplugged and plugged in again, and
// the take replays to the same bits. Nothing here measures time: what is waited for comes, or the test fails.
#include "tests/live/page_client.h"

#include "mien/live/engine.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <atomic>
#include <mutex>
#include <stop_token>
#include <thread>

#include "mien/core/cobs.h"
#include "mien/eyewear/ambient.h"
#include "mien/eyewear/eyewear_protocol.h"
#include "mien/live/replay.h"
#include "tests/folder.h"
#include "tests/live/pseudo_terminal.h"

namespace mien::live {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr std::size_t kChannels = 20;
constexpr std::uint64_t kDevice = 0x024D49454E40;

std::string rig_toml() {
  std::string text = "name = \"glasses\"\nreference = \"s0\"\n";
  for (std::size_t c = 0; c < kChannels; ++c)
    text += fmt::format(
        "[[sensor]]\nname = \"s{0}\"\nkind = \"photo\"\nsite = \"s{0}\"\nside = \"M\"\nrole = "
        "\"face\"\ndevice = "
        "\"02:4D:49:45:4E:40/{0}\"\n",
        c);
  return text;
}

/// A tracker that can be checked by hand: each sensor's light is a shape's weight.
class LightShapes final : public tracker::Tracker {
 public:
  [[nodiscard]] std::string_view modality() const override { return "eyewear"; }
  void add(HostTime, const sensor::Sample& sample) override {
    light_[sample.sensor] = std::max(0.0, filters_[sample.sensor].add(sample));
    heard_[sample.sensor] = sample.time;
  }
  void forget(std::uint16_t sensor) override { filters_[sensor].reset(); }
  void pulse(std::uint16_t, std::uint32_t, DeviceTime) override {}
  std::size_t tick(DeviceTime frame, face::OutputFrame& out) override {
    out = {};
    out.time = frame;
    std::size_t felt = 0;
    for (std::size_t c = 0; c < kChannels; ++c) {
      out.weights[c] = static_cast<float>(light_[c]);
      felt += heard_[c] && frame - *heard_[c] < std::chrono::milliseconds(100) ? 1 : 0;
    }
    out.provenance.fill(face::Provenance::measured);
    out.confidence.fill(static_cast<float>(felt) / kChannels);
    return felt;
  }
  void guide(tracker::Step, DeviceTime, DeviceTime) override {}
  void cancel_guidance() override {}
  [[nodiscard]] tracker::CalibrationState calibration_state() const override { return {}; }
  [[nodiscard]] std::string calibration() const override { return {}; }
  [[nodiscard]] std::vector<sensor::Score> scores() const override { return {}; }
  [[nodiscard]] int calibration_count() const override { return 0; }
  [[nodiscard]] std::vector<tracker::PerformedStep> found_steps() const override { return {}; }
  [[nodiscard]] Result<void> restore(std::string_view) override { return {}; }
  [[nodiscard]] std::optional<double> heading_sigma_rad(std::uint16_t) const override { return {}; }

 private:
  std::array<eyewear::AmbientFilter, kChannels> filters_;
  std::array<double, kChannels> light_{};
  std::array<std::optional<DeviceTime>, kChannels> heard_;
};

std::unique_ptr<Session> session() {
  Session::Parts parts;
  parts.rig = sensor::parse_rig(rig_toml(), "glasses").value();
  parts.tracker = std::make_unique<LightShapes>();
  parts.protocols.push_back(
      std::make_unique<eyewear::EyewearProtocol>(eyewear::EyewearProtocol::create().value()));
  return Session::create(std::move(parts)).value();
}

/// A pair of glasses at 200 scans a second on a cable, with garbage now and then.
class Glasses {
 public:
  explicit Glasses(const std::filesystem::path& line)
      : cable_(line), thread_([this](const std::stop_token& asked) { speak(asked); }) {}

  [[nodiscard]] std::string address() const { return cable_.address(); }
  void unplug() {
    const std::lock_guard lock(mutex_);
    cable_.unplug();
  }
  void plug() {
    const std::lock_guard lock(mutex_);
    cable_.plug();
  }
  void stop() {
    thread_.request_stop();
    thread_.join();
  }

 private:
  void speak(const std::stop_token& asked) {
    const auto begun = std::chrono::steady_clock::now();
    for (std::uint32_t i = 0; !asked.stop_requested(); ++i) {
      const auto time = i * std::chrono::milliseconds(5);
      std::this_thread::sleep_until(begun + time);
      eyewear::Packet packet;
      packet.channels = kChannels;
      packet.device = kDevice;
      packet.sequence = i;
      packet.time = DeviceTime(time);
      for (std::size_t c = 0; c < kChannels; ++c)
        packet.light[c] = {static_cast<std::uint16_t>(300 + i % 500), static_cast<std::uint16_t>(10 * c)};
      std::vector<std::byte> frame;
      cobs_encode(eyewear::encode_packet(packet).value(), frame);
      if (i % 16 == 7) frame[40] ^= std::byte{0x55};
      frame.push_back(std::byte{0});
      const std::lock_guard lock(mutex_);
      cable_.write(frame);
    }
  }

  std::mutex mutex_;
  test::Cable cable_;
  std::jthread thread_;
};

TEST(SerialSession, RunsAtFullRateThroughDamageAndUnpluggingAndReplaysToItsBits) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  Glasses glasses(folder / "glasses");
  EngineSettings settings;
  settings.listen = {glasses.address()};
  settings.takes = folder.path();
  settings.record = folder / "whole.mien";
  settings.header.software = "test";
  settings.header.rig_toml = rig_toml();
  settings.page = PageSettings{.host = "127.0.0.1", .port = 0, .token = {}, .assets = {}};
  auto engine = Engine::open(std::move(settings), session());
  ASSERT_TRUE(engine) << engine.error().message();
  EXPECT_THAT((*engine)->listening().front(), HasSubstr("serial:"));
  std::atomic<bool> stop = false;
  Result<EngineSummary> summary = EngineSummary();
  std::vector<std::string> told;
  std::jthread running([&] {
    summary =
        (*engine)->run(stop, {.told = [&](const std::string& text) { told.push_back(text); }, .seen = {}});
  });

  boost::asio::io_context network;
  test::PageClient page(network, test::port_of((*engine)->page()));
  const auto all_are = [&](const char* state) {
    const nlohmann::json status = page.last("status");
    if (!status.is_object() || !status.contains("links")) return false;
    for (const auto& link : status["links"])
      if (link["state"] != state) return false;
    return true;
  };
  // One in sixteen is damaged: more than the twentieth that is called lossy.
  EXPECT_TRUE(test::run_until(network, [&] { return page.frames() >= 60 && all_are("lossy"); }));
  const auto line_is = [&](bool open, int unplugged) {
    const nlohmann::json status = page.last("status");
    return status["lines"][0]["open"] == open && status["lines"][0]["unplugged"] == unplugged;
  };
  for (int i = 1; i <= 2; ++i) {
    glasses.unplug();
    EXPECT_TRUE(test::run_until(network, [&] { return line_is(false, i) && all_are("lost"); }));
    glasses.plug();
    EXPECT_TRUE(test::run_until(network, [&] { return line_is(true, i) && all_are("lossy"); }));
  }
  EXPECT_TRUE(page.has_event("line_lost"));
  EXPECT_TRUE(page.has_event("line_back"));
  glasses.stop();
  stop = true;
  running.join();
  ASSERT_TRUE(summary) << summary.error().message();
  EXPECT_THAT(summary->recording_error, IsEmpty());
  EXPECT_GT(summary->malformed, 10u);
  EXPECT_EQ(summary->lines.size(), 1u);
  EXPECT_EQ(summary->lines.front().unplugged, 2u);
  EXPECT_TRUE(summary->lines.front().open);
  EXPECT_EQ(std::ranges::count(told, glasses.address() + " is back"), 2);
  engine->reset();
  EXPECT_TRUE(test::run_until(network, [&] { return page.ended(); }));

  const auto take = take::Take::open(folder / "whole.mien");
  ASSERT_TRUE(take) << take.error().message();
  const std::vector<take::LogEntry> entries = take->entries().value();
  for (const take::LogEntry& entry : entries) ASSERT_EQ(entry.source, glasses.address());
  const auto again = session();
  ASSERT_TRUE(replay(*take, *again, [](const take::Tick&, const face::OutputFrame&) { return true; }));
  EXPECT_EQ(again->frames(), summary->frames);
  EXPECT_EQ(again->hash(), summary->hash);
}

TEST(SerialSession, SaysAtOnceThatThereIsNoSuchLine) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  EngineSettings settings;
  settings.listen = {"serial:" + (folder / "nothing").string()};
  settings.takes = folder.path();
  const auto engine = Engine::open(std::move(settings), session());
  ASSERT_FALSE(engine);
  EXPECT_EQ(engine.error().code, ErrorCode::not_found);
}

}  // namespace
}  // namespace mien::live
