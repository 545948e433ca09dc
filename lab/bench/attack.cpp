#include "lab/bench/attack.h"

#include <utility>  // Before Asio 1.74, which forgets it.
//
#include <algorithm>
#include <array>
#include <boost/asio/buffer.hpp>
#include <chrono>
#include <cmath>
#include <string>

#include "lab/bench/attack_programs.h"
#include "lab/bench/clock.h"
#include "mien/core/bytes.h"
#include "mien/core/units.h"
#include "mien/imu/packets/node_message.h"
#include "mien/imu/packets/packet.h"
#include "mien/imu/packets/slimevr.h"
#include "mien/mocap/marker_packet.h"
#include "mien/sensor/bindings.h"

namespace mien::lab {
namespace {

namespace asio = boost::asio;
using asio::ip::udp;
using Bytes = std::vector<std::byte>;

constexpr int kSamples = 4;  // A packet, as our nodes send them.
constexpr double kSampleRateHz = 240;
constexpr double kPacketRateHz = kSampleRateHz / kSamples;
/// Of a forged clock, so that forged jumps back stay above zero.
constexpr double kClockBegins_s = 1000;

Bytes hello(std::uint64_t device, std::string site) {
  imu::Hello hello;
  hello.device = device;
  hello.sites = {site.size() > imu::kMaxNodeText ? std::string() : std::move(site)};
  ByteWriter out;
  (void)imu::encode_node_message(hello, out);  // All of its fields are in range.
  return out.release();
}

/// What a forged sensor measures, ...
enum class Content {
  still,  ///< It lies on a table.
  noise,  ///< Far beyond what a face does.
  zeros,
};
/// ... and how its clock goes.
enum class ForgedClock {
  right,
  leaps,     ///< An hour ahead, every second.
  creeps,    ///< Sixteen times too fast.
  restarts,  ///< Four times a second, from zero.
};

DeviceTime forged_time(ForgedClock clock, double time_s) {
  switch (clock) {
    case ForgedClock::right:
      return DeviceTime(from_seconds(kClockBegins_s + time_s));
    case ForgedClock::leaps:
      return DeviceTime(from_seconds(kClockBegins_s + time_s + 3600 * std::floor(time_s)));
    case ForgedClock::creeps:
      return DeviceTime(from_seconds(kClockBegins_s + 16 * time_s));
    case ForgedClock::restarts:
      return DeviceTime(from_seconds(std::fmod(time_s, 0.25)));
  }
  return {};
}

imu::Packet forged_packet(std::uint64_t device, Content content, DeviceTime time, Random& random) {
  imu::Packet packet;
  packet.device = device;
  packet.time = DeviceTime(std::chrono::floor<std::chrono::microseconds>(time.time_since_epoch()));
  packet.interval = from_seconds(1 / kSampleRateHz);
  packet.count = kSamples;
  for (std::size_t i = 0; i < kSamples; ++i) {
    const double gyro = content == Content::noise ? 5 : content == Content::still ? 0.01 : 0;
    const double accel = content == Content::noise ? 30 : content == Content::still ? 0.05 : 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      packet.values[i][axis] = static_cast<float>(random.normal(0, gyro));
      packet.values[i][3 + axis] = static_cast<float>(random.normal(0, accel));
    }
    if (content == Content::still) packet.values[i][4] += static_cast<float>(kStandardGravity_m_s2);
  }
  return packet;
}

/// Sends as the rig's own boards, a socket a board.
class Impostor final : public Speech {
 public:
  struct Manner {
    Content content = Content::still;
    ForgedClock clock = ForgedClock::right;
    bool reference_only = false;  ///< Only as the sensor whose clock carries the frames.
    bool rebinds = false;         ///< Announces itself at another board's site now and then.
  };
  Impostor(const Victims& victims, Random random, Manner manner)
      : rig_(victims.rig), random_(random), manner_(manner), said_(victims.rig.sensors.size()) {}

  Bytes next(double time_s, std::size_t socket) override {
    const std::size_t sensor =
        manner_.reference_only ? rig_.find(rig_.reference).value_or(0) : socket % said_.size();
    const std::uint64_t device = sensor::virtual_device(sensor);
    const std::uint32_t number = said_[sensor]++;
    if (manner_.rebinds && number % 10 == 0)
      return hello(device, rig_.sensors[(sensor + 1) % said_.size()].name);
    imu::Packet packet = forged_packet(device, manner_.content, forged_time(manner_.clock, time_s), random_);
    packet.sequence = manner_.clock == ForgedClock::restarts ? number % 15 : number;
    return imu::encode_packet(packet).value_or(Bytes());
  }

 private:
  const sensor::Rig& rig_;
  Random random_;
  Manner manner_;
  std::vector<std::uint32_t> said_;  // Datagrams as each board.
};

/// Says what was overheard again, as it was.
class Replayer final : public Speech {
 public:
  Replayer(const Victims& victims, Random random) : overheard_(victims.overheard), random_(random) {}
  Bytes next(double, std::size_t) override { return overheard_.draw(random_); }

 private:
  const Overheard& overheard_;
  Random random_;
};

/// Says what was overheard with something wrong in it; every second time the checksum is right all the same,
/// so that what lies behind it is reached.
class Mutator final : public Speech {
 public:
  Mutator(const Victims& victims, Random random) : overheard_(victims.overheard), random_(random) {}
  Bytes next(double, std::size_t) override { return damaged(overheard_.draw(random_), random_); }

 private:
  const Overheard& overheard_;
  Random random_;
};

class Junk final : public Speech {
 public:
  Junk(const Victims&, Random random) : random_(random) {}
  Bytes next(double, std::size_t) override {
    Bytes bytes(random_.below(256));
    for (std::byte& byte : bytes) byte = static_cast<std::byte>(random_.below(256));
    return bytes;
  }

 private:
  Random random_;
};

/// A motion capture server on each socket.
class MarkerServers final : public Speech {
 public:
  MarkerServers(const Victims&, Random) {}
  Bytes next(double time_s, std::size_t socket) override {
    mocap::MarkerPositionsPacket packet;
    packet.device = 0x0200'0000'0000ULL + socket;
    packet.sequence = number_++;
    packet.time = DeviceTime(std::chrono::floor<std::chrono::microseconds>(from_seconds(time_s)));
    packet.count = 60;
    for (Vec3f& position : packet.position_m) position = Vec3f(0.1F, 1.5F, 0.2F);
    return mocap::encode_marker_positions(packet).value_or(Bytes());
  }

 private:
  std::uint32_t number_ = 0;
};

/// A board that nobody knows on each socket, which says that it is there and nothing else.
class UnknownBoards final : public Speech {
 public:
  UnknownBoards(const Victims&, Random) {}
  Bytes next(double, std::size_t socket) override { return hello(0x0200'0000'0000ULL + socket, {}); }
};

/// Boards with SlimeVR's firmware and the numbers of the rig's own: handshakes and rotations.
class SlimeVrBoards final : public Speech {
 public:
  SlimeVrBoards(const Victims& victims, Random) : said_(victims.rig.sensors.size()) {}
  Bytes next(double, std::size_t socket) override {
    namespace slimevr = imu::slimevr;
    const std::size_t sensor = socket % said_.size();
    const std::uint64_t number = said_[sensor]++;
    slimevr::TrackerMessage message = slimevr::Rotation{.xyzw = {0, 0, 0, 1}};
    if (number % 100 == 0) message = slimevr::Handshake{.mac = sensor::virtual_device(sensor)};
    if (number % 100 == 1) message = slimevr::SensorInfo{};
    ByteWriter out;
    (void)slimevr::encode_tracker_message(number + 1, message, out);  // All of its fields are in range.
    return out.release();
  }

 private:
  std::vector<std::uint64_t> said_;
};

template <class Its>
std::unique_ptr<Speech> speech(const Victims& victims, Random random) {
  return std::make_unique<Its>(victims, random);
}

template <Impostor::Manner kManner>
std::unique_ptr<Speech> impostor(const Victims& victims, Random random) {
  return std::make_unique<Impostor>(victims, random, kManner);
}

using Begins = Attack::Begins;

/// One as each of twelve boards, at their own rate.
constexpr double kTwelve_hz = 12 * kPacketRateHz;

const std::array kAttacks = {
    Attack{"mutated", "what the devices sent, with something wrong in it", Begins::second, 5000, 4, 3,
           speech<Mutator>},
    Attack{"replayed", "what the devices sent, again", Begins::second, kTwelve_hz, 1, 12, speech<Replayer>},
    Attack{"junk", "random bytes from a hundred addresses", Begins::second, 50'000, 100, 1, speech<Junk>},
    Attack{"markers", "well-formed marker packets from a hundred addresses", Begins::second, 9000, 100, 1,
           speech<MarkerServers>},
    Attack{"osc", "eye trackers' OSC, right and wrong, from sixteen ports", Begins::second, 5000, 4, 4,
           osc_programs},
    Attack{"programs", "packets of gaze and weights, right and wrong, from sixteen ports", Begins::second,
           5000, 4, 4, face_programs},
    Attack{"phones",
           "phones with Live Link Face, two of each id, right and wrong, 2,000 packets a second each",
           Begins::second, 8000, 2, 2, face_phones},
    Attack{"table", "hellos of unknown boards from 300 ports", Begins::first, 600, 1, 300,
           speech<UnknownBoards>},
    Attack{"noise-first", "noise as all boards", Begins::first, kTwelve_hz, 1, 12,
           impostor<Impostor::Manner{.content = Content::noise}>},
    Attack{"noise-second", "noise as all boards", Begins::second, kTwelve_hz, 1, 12,
           impostor<Impostor::Manner{.content = Content::noise}>},
    Attack{"zeros-first", "zeros as all boards", Begins::first, kTwelve_hz, 1, 12,
           impostor<Impostor::Manner{.content = Content::zeros}>},
    Attack{"leap-first", "as the reference, an hour ahead every second", Begins::first, kPacketRateHz, 1, 1,
           impostor<Impostor::Manner{.clock = ForgedClock::leaps, .reference_only = true}>},
    Attack{"leap-second", "as the reference, an hour ahead every second", Begins::second, kPacketRateHz, 1, 1,
           impostor<Impostor::Manner{.clock = ForgedClock::leaps, .reference_only = true}>},
    Attack{"creep-first", "as the reference, its clock 16 times too fast", Begins::first, kPacketRateHz, 1, 1,
           impostor<Impostor::Manner{.clock = ForgedClock::creeps, .reference_only = true}>},
    Attack{"restart", "restarts of all boards, announced at one another's sites", Begins::second, kTwelve_hz,
           1, 12, impostor<Impostor::Manner{.clock = ForgedClock::restarts, .rebinds = true}>},
    Attack{"slimevr", "SlimeVR's handshakes and rotations with the boards' numbers", Begins::second,
           kTwelve_hz, 1, 12, speech<SlimeVrBoards>},
    Attack{.name = "slimevr-boards",
           .does = "the same, where the devices are SlimeVR boards themselves",
           .begins = Begins::second,
           .rate_hz = kTwelve_hz,
           .addresses = 1,
           .sockets = 12,
           .speech = speech<SlimeVrBoards>,
           .devices = virt::NodeLanguage::slimevr},
    Attack{"sensor-second", "boards on a table as all boards", Begins::second, kTwelve_hz, 1, 12,
           impostor<Impostor::Manner{}>},
    Attack{.name = "sensor-first",
           .does = "boards on a table as all boards",
           .begins = Begins::first,
           .rate_hz = kTwelve_hz,
           .addresses = 1,
           .sockets = 12,
           .speech = impostor<Impostor::Manner{}>,
           .behaves = true},
    Attack{.name = "camera-endless",
           .does = "a camera whose picture of 10 GB never ends",
           .camera = camera_endless_part},
    Attack{.name = "camera-head", .does = "a camera whose head never ends", .camera = camera_endless_head},
    Attack{.name = "camera-flood",
           .does = "a camera that sends pictures as fast as they are taken",
           .camera = camera_flood},
    Attack{.name = "camera-lengths",
           .does = "a camera whose lengths and chunks lie",
           .camera = camera_lying_lengths},
    Attack{.name = "camera-trickle", .does = "a camera that sends a byte a second", .camera = camera_trickle},
    Attack{.name = "camera-hostile",
           .does = "a camera that after a second of pictures sends broken ones, as fast as it can",
           .camera = camera_turned_hostile},
    Attack{.name = "camera-redirect",
           .does = "a camera that sends who asks elsewhere",
           .camera = camera_redirect},
    Attack{.name = "camera-hangs-up",
           .does = "a camera that gives one picture and hangs up",
           .camera = camera_hangs_up},
    Attack{.name = "camera-clock",
           .does = "a camera whose clock leaps, runs back and is no clock",
           .camera = camera_wild_clock},
};

/// 127.0.0.1 is the devices'; the strangers' begin with 127.0.1.1.
asio::ip::address_v4 stranger_address(std::size_t number) {
  return asio::ip::address_v4(0x7F000101U + static_cast<std::uint32_t>(number));
}

/// What has not left by then is not caught up: a machine that is busy is attacked less.
constexpr double kMostLate_s = 0.05;
constexpr auto kPace = std::chrono::milliseconds(2);

}  // namespace

Overheard::Overheard(const sensor::Rig& rig) {
  Random random(1);
  for (std::size_t i = 0; i < rig.sensors.size(); ++i) {
    const std::uint64_t device = sensor::virtual_device(i);
    add(hello(device, rig.sensors[i].name));
    const auto packet = imu::encode_packet(
        forged_packet(device, Content::still, DeviceTime(from_seconds(kClockBegins_s)), random));
    if (packet) add(*packet);
  }
}

void Overheard::add(std::span<const std::byte> datagram) {
  if (datagram.empty()) return;
  const std::lock_guard lock(mutex_);
  if (datagrams_.size() < kKept) {
    datagrams_.emplace_back(datagram.begin(), datagram.end());
    return;
  }
  datagrams_[next_].assign(datagram.begin(), datagram.end());
  next_ = (next_ + 1) % kKept;
}

Bytes Overheard::draw(Random& random) const {
  const std::lock_guard lock(mutex_);
  return datagrams_[random.below(datagrams_.size())];
}

std::span<const Attack> attacks() {
  return kAttacks;
}

Stranger::Stranger(const Attack& attack, std::uint16_t port, const Victims& victims, double rate,
                   std::uint64_t seed)
    : rate_hz_(rate * attack.rate_hz),
      to_(asio::ip::address_v4::loopback(), port),
      speech_(attack.speech(victims, Random(seed).fork(attack.name))) {
  for (std::size_t a = 0; a < attack.addresses; ++a)
    for (std::size_t s = 0; s < attack.sockets; ++s) {
      sockets_.emplace_back(io_, udp::endpoint(stranger_address(a), 0));
      sockets_.back().non_blocking(true);
    }
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

void Stranger::run(const std::stop_token& stop) {
  const auto begun = Clock::now();
  double due = 0;  // Datagrams.
  std::uint64_t said = 0;
  double before_s = 0;
  while (!stop.stop_requested()) {
    const double now_s = seconds_since(begun);
    due = std::min(due + rate_hz_ * (now_s - before_s), std::max(1.0, rate_hz_ * kMostLate_s));
    before_s = now_s;
    for (; due >= 1; --due, ++said) {
      const std::size_t socket = said % sockets_.size();
      const Bytes datagram = speech_->next(now_s, socket);
      boost::system::error_code code;  // A full buffer, or nobody there: the next may reach.
      sockets_[socket].send_to(asio::buffer(datagram), to_, 0, code);
      if (!code) ++sent_;
    }
    std::this_thread::sleep_for(kPace);
  }
}

}  // namespace mien::lab
