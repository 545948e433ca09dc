// `mien live` from outside: packets into its port, a take and a hash out; killed, and with a full disk.

#include <arpa/inet.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <nlohmann/json.hpp>
#include <span>
#include <sstream>
#include <thread>

#include "mien/core/bytes.h"
#include "mien/core/random.h"
#include "mien/core/time.h"
#include "mien/face/profile.h"
#include "mien/performer/prologue.h"
#include "mien/phone/packet.h"
#include "mien/sensor/seal.h"
#include "mien/take/take.h"
#include "mien/virtual/imu/imu_session.h"
#include "tests/app/program.h"
#include "tests/gaze/osc_bytes.h"
#include "tests/project_path.h"
#include "tests/virtual/three_sensors.h"

namespace mien::app::test::live_test {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;
using testing::HasSubstr;

/// What three sensors say of a performer who calibrates them and then talks for two seconds: 14 s.
const virt::VirtualSession& performance() {
  static const virt::VirtualSession performed = [] {
    const performer::PrologueMotion motion =
        performer::with_prologue(virt::test::talking(120), performer::PrologueKind::brief, Random(3));
    return virt::play_devices(motion, virt::test::three_sites(), virt::test::three_sensors(),
                              virt::test::mild_faults(), Random(11))
        .value();
  }();
  return performed;
}

/// Sends packets, those of the performance unless told others, to a port as they would arrive, from a socket
/// of its own; those of its first seconds.
class Sender {
 public:
  explicit Sender(std::uint16_t port, double seconds = 60,
                  const std::vector<take::LogEntry>& entries = performance().entries)
      : seconds_(seconds), entries_(entries), thread_([this, port] { send(port); }) {}
  ~Sender() {
    stop_ = true;
    thread_.join();
  }
  void wait() {
    while (!done_) std::this_thread::sleep_for(milliseconds(20));
  }
  [[nodiscard]] bool begun() const { return sent_ > 50; }

 private:
  void send(std::uint16_t port) {
    const int out = ::socket(AF_INET, SOCK_DGRAM, 0);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(port);
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const auto begun = Clock::now();
    for (const take::LogEntry& entry : entries_) {
      if (stop_ || entry.arrival.time_since_epoch() > from_seconds(seconds_)) break;
      std::this_thread::sleep_until(begun + entry.arrival.time_since_epoch());
      ::sendto(out, entry.bytes.data(), entry.bytes.size(), 0, reinterpret_cast<const sockaddr*>(&to),
               sizeof(to));
      ++sent_;
    }
    ::close(out);
    done_ = true;
  }
  double seconds_;
  const std::vector<take::LogEntry>& entries_;
  std::atomic<bool> stop_ = false;
  std::atomic<bool> done_ = false;
  std::atomic<int> sent_ = 0;
  std::thread thread_;
};

void send_once(std::uint16_t port, std::span<const std::byte> datagram) {
  const int out = ::socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(port);
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  ::sendto(out, datagram.data(), datagram.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof(to));
  ::close(out);
}

/// A session that runs, and the port that it listens on.
struct Live {
  pid_t process = -1;
  std::uint16_t port = 0;
  Clock::time_point listening;
};

/// The number behind "127.0.0.1:" in what a session says of its port; 0 while it says nothing.
std::uint16_t port_in(const std::string& text) {
  const std::size_t at = text.find("udp://127.0.0.1:");
  if (at == std::string::npos || text.find('\n', at) == std::string::npos) return 0;
  return static_cast<std::uint16_t>(std::atoi(text.c_str() + at + std::strlen("udp://127.0.0.1:")));
}

void wait_for_port(Live& live, const std::string& said) {
  for (int i = 0; i < 3000 && live.port == 0; ++i) {
    std::this_thread::sleep_for(milliseconds(10));
    live.port = port_in(content(said));
  }
  live.listening = Clock::now();
}

int finish(pid_t process) {
  int status = 0;
  ::waitpid(process, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

class LiveProgram : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(std::filesystem::path(project_path("models/live.safetensors"))))
      GTEST_SKIP() << "there is no models/live.safetensors";
    write(folder / "rig.toml", virt::test::kRig);
  }
  Live start_live(const std::string& name, std::vector<std::string> more, const char* command = "live") {
    std::vector<std::string> arguments = {
        command, "--rig", folder / "rig.toml", "--listen", "udp://127.0.0.1:0", "--page", "off"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    Live live;
    live.process = start(arguments, folder / (name + ".out"), folder / (name + ".err"));
    wait_for_port(live, folder / (name + ".err"));
    return live;
  }
  Folder folder;
};

TEST_F(LiveProgram, ATakeReplaysToTheBitsOfTheSessionThatRecordedIt) {
  const std::string take = folder / "live.mien";
  const Live live = start_live("live", {"--record", take, "--json", "--out", "csv:" + (folder / "live.csv"),
                                        "--out", "livelink://127.0.0.1:9"});
  ASSERT_GT(live.port, 0) << content(folder / "live.err");
  {
    Sender sender(live.port);
    sender.wait();
    std::this_thread::sleep_for(milliseconds(300));
  }
  ::kill(live.process, SIGINT);
  ASSERT_EQ(finish(live.process), 0) << content(folder / "live.err");
  const auto summary = nlohmann::json::parse(content(folder / "live.out"));
  EXPECT_GT(summary["frames"], 800);
  EXPECT_EQ(summary["missed"], 0);
  EXPECT_EQ(summary["malformed"], 0);
  EXPECT_GE(summary["calibrations"], 1);
  for (int i = 0; i < 3; ++i) {
    const Outcome again = run({"live", "--replay", take, "--json"});
    ASSERT_EQ(again.status, 0) << again.err;
    const auto replayed = nlohmann::json::parse(again.out);
    EXPECT_EQ(replayed["hash"], summary["hash"]);
    EXPECT_EQ(replayed["frames"], summary["frames"]);
    EXPECT_EQ(replayed["kernels"], summary["kernels"]);
    EXPECT_NE(summary["kernels"].get<std::string>().find("bf16"), std::string::npos) << summary["kernels"];
    EXPECT_EQ(replayed["live_hash"], summary["hash"]);
  }
  // What a log already says cannot be said again.
  for (const char* option : {"--rig", "--page", "--for"})
    EXPECT_EQ(run({"live", "--replay", take, option, "1"}).status, 2) << option;
  EXPECT_EQ(run({"take", "check", take}).status, 0);
  EXPECT_EQ(std::filesystem::status(take).permissions(),
            std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  // Nobody knows what the face did: that is said before anything is solved.
  const Outcome measured = run({"evaluate", take});
  EXPECT_EQ(measured.status, 2);
  EXPECT_EQ(measured.err.find("mien: " + take + ": the take has no truth"), 0U) << measured.err;
  // The CSV is one that any importer takes.
  const Outcome imported = run({"import", folder / "live.csv", "--take", folder / "again.mien"});
  EXPECT_EQ(imported.status, 0) << imported.err;
  const Outcome again = run({"evaluate", folder / "again.mien", "--wears", "3"});
  EXPECT_EQ(again.status, 2);
  EXPECT_NE(again.err.find("only performed takes can be worn again"), std::string::npos) << again.err;
}

/// The column of a CSV with a header.
std::vector<double> column(const std::string& csv, const std::string& name) {
  std::vector<double> values;
  std::istringstream lines(csv);
  std::string line, cell;
  std::getline(lines, line);
  std::istringstream header(line);
  std::size_t at = 0;
  while (std::getline(header, cell, ',') && cell != name) ++at;
  while (std::getline(lines, line)) {
    std::istringstream cells(line);
    for (std::size_t i = 0; i <= at; ++i) std::getline(cells, cell, ',');
    values.push_back(std::atof(cell.c_str()));
  }
  return values;
}

TEST_F(LiveProgram, RulesOfOnesOwnAreObeyedAndAReplayNeedsNoFile) {
  const std::string take = folder / "ruled.mien", rules = folder / "rules.toml";
  write(rules,
        "# A jaw that hardly opens.\n[[conditional]]\na = \"jawOpen\"\nb = \"jawLeft\"\nat_most = [[0, "
        "0.05]]\n");
  const Live live = start_live("ruled", {"--record", take, "--json", "--constraints", rules, "--blinks", "40",
                                         "--out", "csv:" + (folder / "ruled.csv")});
  ASSERT_GT(live.port, 0) << content(folder / "ruled.err");
  {
    Sender sender(live.port);
    sender.wait();
  }
  ::kill(live.process, SIGINT);
  ASSERT_EQ(finish(live.process), 0) << content(folder / "ruled.err");
  const std::vector<double> jaw = column(content(folder / "ruled.csv"), "JawOpen");
  ASSERT_GT(jaw.size(), 700U);
  EXPECT_NEAR(*std::ranges::max_element(jaw), 0.05, 1e-3) << "the performer talks";
  const std::vector<double> lid = column(content(folder / "ruled.csv"), "EyeBlinkLeft");
  EXPECT_GT(*std::ranges::max_element(lid), 0.9) << "no sensor observes the lids";
  std::filesystem::remove(rules);
  const Outcome again = run({"live", "--replay", take, "--json"});
  ASSERT_EQ(again.status, 0) << again.err;
  EXPECT_EQ(nlohmann::json::parse(again.out)["hash"],
            nlohmann::json::parse(content(folder / "ruled.out"))["hash"]);
  EXPECT_EQ(run({"live", "--replay", take, "--constraints", "off"}).status, 2) << "the log says it";
}

/// An eye tracker: about 0.4 rad to the left and 0.1 up, by OSC, sixty rounds a second.
std::vector<take::LogEntry> osc_of_an_eye_tracker(double seconds) {
  std::vector<take::LogEntry> entries;
  for (int n = 0; n < 60 * seconds; ++n)
    for (const char* eye : {"Left", "Right"})
      for (const auto& [axis, rad] : {std::pair("X", -0.4), std::pair("Y", 0.1)})
        entries.push_back(
            {.arrival = HostTime(frame_offset(n)),
             .bytes = gaze::test::message(fmt::format("/avatar/parameters/v2/Eye{}{}", eye, axis),
                                          {static_cast<float>(std::tan(rad + 0.002 * std::sin(n)))})});
  return entries;
}

/// A phone that sees a brow and the head: ARKit's names, thirty packets a second.
std::vector<take::LogEntry> weights_of_a_phone(double seconds) {
  std::vector<take::LogEntry> entries;
  for (int n = 0; n < 30 * seconds; ++n) {
    phone::Packet packet{.device = 0x024D'4945'4E70ULL, .sequence = static_cast<std::uint32_t>(n)};
    packet.time = DeviceTime(std::chrono::seconds(300) + std::chrono::microseconds(n * 1'000'000LL / 30));
    packet.face.set = phone::ShapeSet::arkit52;
    packet.face.origin = phone::Origin::measured;
    packet.face.weights[face::arkit_index("browOuterUpLeft")] = 0.4F;
    packet.face.head = phone::ToldHead{.position_m = {0, 1, 0}, .position_known = true};
    entries.push_back(
        {.arrival = HostTime(2 * frame_offset(n)), .bytes = phone::encode_packet(packet).value()});
  }
  return entries;
}

TEST_F(LiveProgram, AnEyeTrackerAndAPhoneStandBesideTheImus) {
  std::string imu_rig = virt::test::kRig;
  for (int i = 3; i-- > 0;) {
    std::size_t at = 0;
    for (int n = 0; n <= i; ++n) at = imu_rig.find("kind =", at + 1);
    imu_rig.insert(at, fmt::format("device = \"02:4D:49:45:4E:0{}\"\n", i));
  }
  write(folder / "rig.toml", imu_rig +
                                 "[[sensor]]\nname = \"eyes\"\nkind = \"gaze\"\nrole = \"face\"\n"
                                 "device = \"02:4D:49:47:5A:00\"\n"
                                 "[[sensor]]\nname = \"phone\"\nkind = \"weights\"\nrole = \"face\"\n"
                                 "device = \"02:4D:49:45:4E:70\"\n");
  const std::string take = folder / "three.mien";
  const Live live =
      start_live("three", {"--record", take, "--json", "--out", "csv:" + (folder / "three.csv")});
  ASSERT_GT(live.port, 0) << content(folder / "three.err");
  {
    constexpr double kEyes_s = 60, kPhone_s = 9;  // The phone is lost.
    constexpr std::chrono::milliseconds kAfterwards(3800);
    const auto gaze = osc_of_an_eye_tracker(kEyes_s);
    const auto phone = weights_of_a_phone(kPhone_s);
    Sender imus(live.port), eyes(live.port, kEyes_s, gaze), other(live.port, kPhone_s, phone);
    other.wait();
    std::this_thread::sleep_for(kAfterwards);
    // While the others still send: on a busy machine a session may end long after it is told to.
    ::kill(live.process, SIGINT);
    ASSERT_EQ(finish(live.process), 0) << content(folder / "three.err");
  }
  const auto summary = nlohmann::json::parse(content(folder / "three.out"));
  EXPECT_EQ(summary["malformed"], 0);

  const std::string csv = content(folder / "three.csv");
  const std::vector<double> brow = column(csv, "BrowOuterUpLeft"), look = column(csv, "EyeLookOutLeft"),
                            jaw = column(csv, "JawOpen");
  ASSERT_GT(brow.size(), 700U);
  // While the phone is there the brow is its; the last seconds' brow is the IMUs'.
  EXPECT_NEAR(brow[brow.size() / 2], 0.4, 1e-3);
  EXPECT_LT(brow.back(), 0.3);
  EXPECT_NEAR(look.back(), 0.4 / face::kEyeTurnRadPerUnit, 0.01) << "lids follow the eyes";
  EXPECT_GT(*std::ranges::max_element(jaw), 0.1) << "the IMUs'";
  for (const auto& link : summary["links"])
    EXPECT_EQ(link["state"] == "lost", link["device"] == "02:4D:49:45:4E:70") << link;

  // Each has a clock and a health of its own.
  const auto recorded = take::Take::open(take);
  ASSERT_TRUE(recorded) << recorded.error().message();
  std::vector<take::Event> lost = recorded->events().value();
  std::erase_if(lost, [](const take::Event& event) { return event.kind != "sensor_lost"; });
  ASSERT_FALSE(lost.empty());
  EXPECT_THAT(lost.front().json, HasSubstr("phone"));
  for (int i = 0; i < 10; ++i) {
    const Outcome again = run({"live", "--replay", take, "--json"});
    ASSERT_EQ(again.status, 0) << again.err;
    ASSERT_EQ(nlohmann::json::parse(again.out)["hash"], summary["hash"]) << i;
  }
}

TEST_F(LiveProgram, RecordAsksForPosesWritesThemAndEndsWithThem) {
  const std::string take = folder / "poses.mien";
  write(folder / "poses.toml",
        "seconds = 1\n[[prompt]]\nname = \"rest\"\n[[prompt]]\nname = \"smile\"\nweights = { mouthSmile = "
        "0.5 }\n");
  const Live live =
      start_live("record", {"--out", take, "--prompts", folder / "poses.toml", "--json"}, "record");
  ASSERT_GT(live.port, 0) << content(folder / "record.err");
  Sender sender(live.port);
  ASSERT_EQ(finish(live.process), 0) << content(folder / "record.err");  // By itself, while they still send.
  const auto summary = nlohmann::json::parse(content(folder / "record.out"));
  EXPECT_GT(summary["frames"], 60 * 4);
  EXPECT_EQ(summary["take"], take);

  const auto recorded = take::Take::open(take);
  ASSERT_TRUE(recorded) << recorded.error().message();
  EXPECT_EQ(recorded->header().script, folder / "poses.toml");
  std::vector<take::Event> events = recorded->events().value();
  std::erase_if(events, [](const take::Event& event) { return event.kind != "prompt"; });
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(events[0].json, R"({"name": "rest", "target": {}})");
  EXPECT_EQ(events[1].json, R"({"name": "smile", "target": {"mouthSmile_L": 0.5, "mouthSmile_R": 0.5}})");
  EXPECT_EQ(events[1].end - events[0].begin, std::chrono::seconds(2));

  const Outcome again = run({"live", "--replay", take, "--json"});
  ASSERT_EQ(again.status, 0) << again.err;
  EXPECT_EQ(nlohmann::json::parse(again.out)["hash"], summary["hash"]);
}

TEST_F(LiveProgram, KilledWhileRecordingItLosesASecondAtMost) {
  const char* wanted = std::getenv("MIEN_KILLS");
  const int kills = wanted == nullptr ? 6 : std::atoi(wanted);
  /// A session that is heard, to be killed at a moment of its own.
  struct Recording {
    Live live;
    std::string take;
    std::unique_ptr<Sender> sender;
    void kill() {
      if (live.process <= 0) return;
      ::kill(live.process, SIGKILL);
      finish(live.process);
      live.process = -1;
    }
    ~Recording() { kill(); }
  };
  Random random(7);
  double worst_s = 0, total_s = 0;
  constexpr int kAtOnce = 6;
  for (int begun = 0; begun < kills; begun += kAtOnce) {
    std::vector<Recording> recordings(static_cast<std::size_t>(std::min(kAtOnce, kills - begun)));
    std::vector<double> at_s(recordings.size());
    for (double& one_s : at_s) one_s = random.uniform(0.5, 3);
    std::ranges::sort(at_s);
    for (std::size_t i = 0; i < recordings.size(); ++i) {
      const std::string name = "kill" + std::to_string(static_cast<std::size_t>(begun) + i);
      Recording& r = recordings[i];
      r.take = folder / (name + ".mien");
      r.live = start_live(name, {"--record", r.take, "--json"});
      ASSERT_GT(r.live.port, 0) << content(folder / (name + ".err"));
      r.sender = std::make_unique<Sender>(r.live.port);
    }
    const Clock::time_point all_there = Clock::now();
    for (std::size_t i = 0; i < recordings.size(); ++i) {
      Recording& r = recordings[i];
      while (!r.sender->begun()) std::this_thread::sleep_for(milliseconds(5));
      std::this_thread::sleep_until(all_there + from_seconds(at_s[i]));
      const double killed_s = std::chrono::duration<double>(Clock::now() - r.live.listening).count();
      r.kill();
      ASSERT_EQ(run({"take", "check", r.take}).status, 0);
      const auto opened = take::Take::open(r.take);
      ASSERT_TRUE(opened) << opened.error().message();
      const auto entries = opened->entries().value();
      ASSERT_FALSE(entries.empty());
      const double lost_s = killed_s - to_seconds(entries.back().arrival.time_since_epoch());
      EXPECT_LE(lost_s, 1.0);
      worst_s = std::max(worst_s, lost_s);
      total_s += lost_s;
      std::filesystem::remove(r.take);
    }
  }
  std::printf("%d kills: mean loss %.3f s, worst %.3f s\n", kills, total_s / kills, worst_s);
}

TEST_F(LiveProgram, AFullDiskIsSaidAndTheCaptureGoesOn) {
  // A limit on the size of files stands for the disk: 400 blocks of 512 bytes, and no signal for who exceeds
  // it.
  const std::string take = folder / "full.mien";
  const std::string line = std::string("ulimit -f 400; trap '' XFSZ; exec ") + test::program_path() +
                           " live --rig " + (folder / "rig.toml") +
                           " --listen udp://127.0.0.1:0 --page off --json --record " + take;
  Live live;
  live.process = ::fork();
  if (live.process == 0) {
    std::freopen((folder / "full.out").c_str(), "w", stdout);
    std::freopen((folder / "full.err").c_str(), "w", stderr);
    ::execl("/bin/sh", "sh", "-c", line.c_str(), nullptr);
    ::_exit(127);
  }
  wait_for_port(live, folder / "full.err");
  ASSERT_GT(live.port, 0) << content(folder / "full.err");
  {
    Sender sender(live.port, 6);
    sender.wait();
    std::this_thread::sleep_for(milliseconds(300));
  }
  ::kill(live.process, SIGINT);
  EXPECT_EQ(finish(live.process), 1);
  const std::string said = content(folder / "full.err");
  EXPECT_NE(said.find("the recording ended"), std::string::npos) << said;
  const auto summary = nlohmann::json::parse(content(folder / "full.out"));
  EXPECT_GT(summary["frames"], 240) << "the disk was full after two seconds";
  EXPECT_FALSE(summary["recording_error"].get<std::string>().empty());
  // What was written until then is whole.
  EXPECT_EQ(run({"take", "check", take}).status, 0);
}

TEST_F(LiveProgram, ASessionThatHearsWhatItCannotReadSaysWhy) {
  const auto ending_after = [this](const char* name, std::span<const std::byte> datagram) {
    const Live live = start_live(name, {"--json", "--for", "2"});
    send_once(live.port, datagram);
    EXPECT_EQ(finish(live.process), 1) << name;
    return content(folder / (std::string(name) + ".err"));
  };
  EXPECT_THAT(ending_after("garbage", std::as_bytes(std::span("hello world"))),
              HasSubstr("mien: no frame came: packets did, but none that could be read; "));
  ByteWriter sealed;
  ASSERT_TRUE(sensor::seal_packet({.id = 7}, {.key_id = 7, .device = 1, .counter = 1, .session = 1},
                                  performance().entries.front().bytes, sealed));
  EXPECT_THAT(
      ending_after("sealed", sealed.bytes()),
      HasSubstr("mien: no frame came: packets did that are sealed with a key; give the devices' key with "
                "--key\n"));
  std::vector<std::byte> newer = performance().entries.front().bytes;
  newer[4] = std::byte{9};
  const std::string said = ending_after("newer", newer);
  EXPECT_THAT(said, HasSubstr("sends mien packets of version 9, which this program does not know"));
  EXPECT_THAT(said, HasSubstr("packets did of versions that this program does not know: mien version 9; "
                              "update this program, or what sends there\n"));
}

TEST_F(LiveProgram, ASessionThatHearsNothingSaysSo) {
  const std::string why =
      "mien: no frame came: nothing was received; see that the devices are on, and send to where the session "
      "listened\n";
  const std::vector<std::string> live = {"live",  "--listen", "udp://127.0.0.1:0", "--page", "off",
                                         "--for", "0.2"};
  Outcome outcome = run(live);
  EXPECT_EQ(outcome.status, 1) << outcome.out;
  EXPECT_EQ(outcome.err, why);
  EXPECT_NE(outcome.out.find("0 frames, 0 missed; no latency"), std::string::npos) << outcome.out;
  EXPECT_EQ(outcome.out.find("0.00 ms"), std::string::npos) << outcome.out;

  std::vector<std::string> arguments = live;
  arguments.push_back("--json");
  outcome = run(arguments);
  EXPECT_EQ(outcome.status, 1);
  EXPECT_TRUE(outcome.err.ends_with(why)) << outcome.err;
  const auto summary = nlohmann::json::parse(outcome.out);
  for (const char* which : {"p50", "p99", "max"})
    EXPECT_TRUE(summary.at("latency_ms").at(which).is_null()) << which;

  outcome = run({"record", "--listen", "udp://127.0.0.1:0", "--page", "off", "--for", "0.2", "--out",
                 folder / "nothing.mien"});
  EXPECT_EQ(outcome.status, 1) << outcome.out;
  EXPECT_TRUE(outcome.err.ends_with(why)) << outcome.err;
}

TEST_F(LiveProgram, WhoCanSendIsSaidAtTheStart) {
  const std::vector<std::string> live = {"live", "--page", "off", "--for", "0.2", "--listen"};
  std::vector<std::string> arguments = live;
  arguments.emplace_back("udp://0.0.0.0:0");
  Outcome outcome = run(arguments);
  EXPECT_NE(outcome.out.find(", every interface: "), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("lo 127.0.0.1\n"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("There is no key, so anybody there can send"), std::string::npos) << outcome.out;
  arguments.emplace_back("--json");
  outcome = run(arguments);
  EXPECT_NE(outcome.err.find("anybody there can send"), std::string::npos) << outcome.err;
  const auto summary = nlohmann::json::parse(outcome.out);
  const auto port = summary.at("listening").at(0);
  EXPECT_EQ(port.at("every_interface"), true);
  EXPECT_EQ(port.at("interfaces").back(), (nlohmann::json{{"name", "lo"}, {"address", "127.0.0.1"}}));
  EXPECT_EQ(summary.at("sealed"), false);
  EXPECT_EQ(summary.at("only"), "");
  EXPECT_EQ(summary.at("elsewhere"), 0);
  // On loopback nobody else can.
  arguments = live;
  arguments.emplace_back("udp://127.0.0.1:0");
  EXPECT_EQ(run(arguments).out.find("anybody"), std::string::npos);
}

TEST_F(LiveProgram, ThePagesTokenComesFromAFile) {
  write(folder / "token", "0123456789abcdef\n");
  const std::vector<std::string> live = {"live",  "--listen", "udp://127.0.0.1:0", "--page", "127.0.0.1:0",
                                         "--for", "0.2"};
  std::vector<std::string> arguments = live;
  arguments.insert(arguments.end(), {"--token-file", folder / "token"});
  Outcome outcome = run(arguments);
  if (outcome.err.find("built without its page") != std::string::npos) GTEST_SKIP() << outcome.err;
  EXPECT_NE(outcome.out.find("/?token=0123456789abcdef\n"), std::string::npos) << outcome.out << outcome.err;
  arguments.insert(arguments.end(), {"--token", "0123456789abcdef"});
  outcome = run(arguments);
  EXPECT_EQ(outcome.status, 2) << outcome.out;
  EXPECT_NE(run({"live", "--help"}).out.find("Other users"), std::string::npos);
}

TEST_F(LiveProgram, BadInputIsOneLine) {
  const auto line = [](std::vector<std::string> arguments, const std::string& part) {
    arguments.insert(arguments.begin(), "live");
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.status, 2) << joined(arguments) << outcome.out;
    EXPECT_NE(outcome.err.find(part), std::string::npos) << outcome.err;
    EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << outcome.err;
  };
  line({"--listen", "tcp://127.0.0.1:1", "--page", "off"}, "not an address to listen on");
  line({"--listen", "udp://127.0.0.1:99999", "--page", "off"}, "the port is no number");
  for (const char* page : {"nowhere", "", "127.0.0.1:x", ":8740", "0.0.0.0:99999", "[::1"})
    line({"--listen", "udp://127.0.0.1:0", "--page", page}, "not an address for the page");
  line({"--listen", "udp://127.0.0.1:0", "--page", "off", "--out", "fax://127.0.0.1"}, "livelink");
  // Which output it was.
  line({"--listen", "udp://127.0.0.1:0", "--page", "off", "--out", "vmc://127.0.0.1", "--out",
        "vmc://127.0.0.1?shapes=round"},
       "mien: --out vmc://127.0.0.1?shapes=round: there are no shapes 'round'");
  line({"--listen", "udp://127.0.0.1:0", "--page", "off", "--out", "vmc://127.0.0.1", "--out", "vmc//there"},
       "mien: --out vmc//there: ");
  line({"--listen", "udp://127.0.0.1:0", "--page", "off", "--record", folder / "x.txt"}, ".mien");
  line({"--listen", "udp://127.0.0.1:0", "--page", "off", "--key", folder / "rig.toml"}, "not a key file");
  // Rules, before anything is opened; all comments that fit into a file do not fit into a command.
  write(folder / "rules.toml", "[[exclusive]]\na = \"jawLeft\"\nb = \"jawRihgt\"\n");
  line({"--listen", "udp://127.0.0.1:0", "--page", "off", "--constraints", folder / "rules.toml"},
       "mien: " + (folder / "rules.toml") + ", line 3: no shape is called 'jawRihgt'");
  write(folder / "long.toml", "#" + std::string(140'000, '-') + "\n");
  line({"--listen", "udp://127.0.0.1:0", "--page", "off", "--constraints", folder / "long.toml"},
       "take comments out");
  line({"--listen", "udp://127.0.0.1:0", "--page", "off", "--constraints", folder / "none.toml"},
       "none.toml");
  line({"--model", (std::filesystem::path(project_path("models/default.safetensors"))).string(), "--page",
        "off", "--listen", "udp://127.0.0.1:0"},
       "causal");
}

}  // namespace
}  // namespace mien::app::test::live_test
