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

#include "mien/builtin_face/builtin_face.h"
#include "mien/core/cobs.h"
#include "mien/core/files.h"
#include "mien/eyewear/eyewear_protocol.h"
#include "mien/eyewear/eyewear_tracker.h"
#include "mien/session/replay.h"
#include "tests/eyewear/glasses.h"
#include "tests/folder.h"
#include "tests/live/pseudo_terminal.h"

namespace mien::live::serial_session_test {
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

/// The first sensor's light opens the jaw.
std::unique_ptr<session::Session> session() {
  const builtin_face::MarkerSet markers = eyewear::test::mouth_markers();
  const auto placed = builtin_face::PlacedMarkers::place(builtin_face::make_builtin(), markers).value();
  face::BlendshapeWeights open;
  open[face::shape("jawOpen")] = 1;
  Eigen::MatrixXd gain_m = Eigen::MatrixXd::Zero(placed.at({}).size(), kChannels);
  gain_m.col(0) = placed.at(open) - placed.at({});
  session::Session::Parts parts;
  parts.rig = sensor::parse_rig(rig_toml(), "glasses").value();
  parts.trackers.push_back(
      eyewear::EyewearTracker::create(parts.rig, eyewear::test::marked_mouth(),
                                      std::make_unique<eyewear::test::LinearRegressor>(std::move(gain_m)))
          .value());
  parts.protocols.push_back(
      std::make_unique<eyewear::EyewearProtocol>(eyewear::EyewearProtocol::create().value()));
  return session::Session::create(std::move(parts)).value();
}

/// Steps of light that the board sees: steady at first, then the first sensor's comes and goes.
std::uint16_t light(std::uint32_t scan, std::size_t channel) {
  constexpr std::uint32_t kSteady = 600;
  if (scan < kSteady || channel > 0) return 300;
  return static_cast<std::uint16_t>(400 - 100 * std::cos(0.02 * (scan - kSteady)));
}

/// A pair of glasses at 200 scans a second on a cable: one frame in sixteen is damaged, one in ten comes
/// twice, and there is garbage between them.
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
        packet.light[c] = {static_cast<std::uint16_t>(light(i, c) + i % 2),
                           static_cast<std::uint16_t>(10 * c)};
      std::vector<std::byte> frame;
      cobs_encode(eyewear::encode_packet(packet).value(), frame);
      if (i % 16 == 7) frame[40] ^= std::byte{0x55};
      frame.push_back(std::byte{0});
      if (i % 10 == 4) {
        const std::vector<std::byte> again = frame;
        frame.insert(frame.end(), again.begin(), again.end());
      }
      if (i % 25 == 3)
        for (int b = 0; b < 40; ++b) frame.push_back(static_cast<std::byte>(i * 7 + 13 * b));
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
  settings.out = {"csv:" + (folder / "faces.csv").string()};
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
  EXPECT_TRUE(test::run_until(network, [&] {
    const nlohmann::json status = page.last("status");
    return status.is_object() && status["calibration"]["state"] == "done";
  })) << "steady light is its neutral";
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
  for (const session::Report::Link& link : summary->report.links) {
    EXPECT_GT(link.health.doubled, 10u);
    EXPECT_GT(link.health.lost, 10u);
    EXPECT_GT(link.health.malformed, 10u);
  }
  EXPECT_GT(summary->sinks.front().sent, 120u);
  const std::string csv = read_text(folder / "faces.csv").value();
  EXPECT_GE(std::ranges::count(csv, '\n'), 120);
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
  ASSERT_TRUE(
      session::replay(*take, *again, [](const take::Tick&, const face::OutputFrame&) { return true; }));
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
}  // namespace mien::live::serial_session_test
