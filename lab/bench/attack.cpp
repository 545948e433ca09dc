#include "lab/bench/attack.h"

#include <utility>  // Before Asio 1.74, which forgets it.
//
#include <algorithm>
#include <array>
#include <boost/asio/buffer.hpp>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>

#include "lab/bench/clock.h"
#include "mien/core/bytes.h"
#include "mien/core/units.h"
#include "mien/gaze/packet.h"
#include "mien/imu/packets/node_message.h"
#include "mien/imu/packets/packet.h"
#include "mien/imu/packets/slimevr.h"
#include "mien/mocap/marker_packet.h"
#include "mien/phone/packet.h"
#include "mien/sensor/bindings.h"
#include "mien/sensor/packet_envelope.h"
#include "mien/sensor/protocol.h"
#include "mien/sink/live_link.h"

namespace mien::lab {
namespace {

using Bytes = std::vector<std::byte>;

/// OSC's padding: to a multiple of four, with at least one zero.
void write_osc_text(std::string_view text, ByteWriter& out) {
  out.append(text);
  for (std::size_t i = text.size() % 4; i < 4; ++i) out.little(std::uint8_t{0});
}

/// A message whose arguments are these bytes, whatever its types say.
Bytes osc_message(std::string_view address, std::string_view types, std::span<const float> numbers) {
  ByteWriter out;
  write_osc_text(address, out);
  write_osc_text(types, out);
  for (const float number : numbers) out.big(number);
  return out.release();
}

Bytes in_bundle(std::span<const std::byte> element, std::uint32_t said_size) {
  ByteWriter out;
  write_osc_text("#bundle", out);
  out.big(std::uint64_t{1});
  out.big(said_size);
  out.append(element);
  return out.release();
}

constexpr std::array<std::string_view, 6> kCoordinates = {
    "/avatar/parameters/v2/EyeLeftX",  "/avatar/parameters/v2/EyeLeftY", "/avatar/parameters/v2/EyeRightX",
    "/avatar/parameters/v2/EyeRightY", "/tracking/eye/LeftRightVec",     "/avatar/parameters/v2/EyeLidLeft"};

float any_number(Random& random) {
  switch (random.below(6)) {
    case 0:
      return std::numeric_limits<float>::quiet_NaN();
    case 1:
      return 1e30F;
    case 2:
      return -std::numeric_limits<float>::infinity();
    default:
      return static_cast<float>(random.uniform(-1.5, 1.5));
  }
}

class OscPrograms {
 public:
  explicit OscPrograms(Random random) : random_(random) {}

  Bytes operator()(double time_s, std::size_t) {
    const std::string_view address = kCoordinates[said_++ % kCoordinates.size()];
    const std::array right = {0.5F * static_cast<float>(std::sin(40 * time_s))};
    const Bytes whole = osc_message(address, ",f", right);
    switch (random_.below(8)) {
      case 0: {  // Numbers that none should be.
        const std::array wrong = {any_number(random_)};
        return osc_message(address, ",f", wrong);
      }
      case 1:  // Other types than the bytes are, among them a blob of a gigabyte and more by its length.
        return osc_message(address, std::array{",s", ",d", ",ffff", ",b", ",["}[random_.below(5)], right);
      case 2:  // An element of 4 GB by its length.
        return in_bundle(whole, 0xFFFF'FFFCU);
      case 3: {  // A hundred bundles, one in the other.
        Bytes deep = whole;
        for (int level = 0; level < 100; ++level)
          deep = in_bundle(deep, static_cast<std::uint32_t>(deep.size()));
        return deep;
      }
      case 4: {  // An address without an end.
        Bytes endless(4 * (1 + random_.below(256)), std::byte{'a'});
        endless[0] = std::byte{'/'};
        return endless;
      }
      case 5:
        return damaged(whole, random_);
      default:
        return whole;
    }
  }

 private:
  Random random_;
  std::size_t said_ = 0;
};

/// The device of the rig's sensor of this kind, or a stranger's.
std::uint64_t device_of(const sensor::Rig& rig, std::string_view kind) {
  for (const auto& sensor : rig.sensors)
    if (sensor.kind == kind)
      if (const auto device = sensor::parse_device(sensor.device)) return device->device;
  return 0x0200'0000'00F0ULL;
}

class FacePrograms {
 public:
  FacePrograms(const sensor::Rig& rig, Random random)
      : gaze_(device_of(rig, "gaze")), weights_(device_of(rig, "weights")), random_(random) {}

  Bytes operator()(double time_s, std::size_t) {
    ++said_;
    Bytes packet = said_ % 2 == 0 ? gaze_packet(time_s) : weights_packet(time_s);
    switch (random_.below(4)) {
      case 0:
        return damaged(std::move(packet), random_);
      case 1: {  // A number that none should be, somewhere behind the head, under a checksum that is right.
        ByteWriter number;
        number.little(any_number(random_));
        const std::size_t at = 4 * (8 + random_.below(packet.size() / 4 - 9));
        std::ranges::copy(number.bytes(), packet.begin() + static_cast<std::ptrdiff_t>(at));
        mend_checksum(packet);
        return packet;
      }
      default:
        return packet;
    }
  }

 private:
  static DeviceTime device_time(double time_s) {
    return DeviceTime(std::chrono::floor<std::chrono::microseconds>(from_seconds(100 + time_s)));
  }
  Bytes gaze_packet(double time_s) const {
    gaze::Packet packet{.device = gaze_, .sequence = static_cast<std::uint32_t>(said_)};
    packet.time = device_time(time_s);
    packet.eyes.fill({.yaw_rad = 1.5F, .pitch_rad = -1.5F, .confidence = 1, .openness = 0.0F});
    return gaze::encode_packet(packet).value_or(Bytes());
  }
  Bytes weights_packet(double time_s) const {
    phone::Packet packet{.device = weights_, .sequence = static_cast<std::uint32_t>(said_)};
    packet.time = device_time(time_s);
    packet.face.set = phone::ShapeSet::unified;
    packet.face.origin = phone::Origin::measured;
    packet.face.weights.fill(1);
    packet.face.confidence.fill(1);
    packet.face.head =
        phone::ToldHead{.position_m = {99, -99, 99}, .position_known = true, .rotation = {0, 1, 0, 0}};
    return phone::encode_packet(packet).value_or(Bytes());
  }

  std::uint64_t gaze_, weights_;
  Random random_;
  std::size_t said_ = 0;
};

class FacePhones {
 public:
  explicit FacePhones(Random random) : random_(random) {}

  Bytes operator()(double time_s, std::size_t socket) {
    sink::LiveLinkSource source = sources_[socket / 2 % sources_.size()];
    sink::LiveLinkFrame frame;
    frame.number = kBegins + std::llround(frame.rate_hz * time_s);
    frame.values.emplace().fill(0.9F);
    const std::uint64_t manner = random_.below(8);
    if (manner == 1) source.subject = "somebody else";
    if (manner == 2) frame.number += std::int64_t{3600} * frame.rate_hz;
    if (manner == 3) frame.values.reset();
    if (manner == 4) (*frame.values)[random_.below(frame.values->size())] = any_number(random_);
    out_.clear();
    sink::encode_live_link(frame, source, out_);
    Bytes packet(out_[0].begin(), out_[0].end());
    return manner == 0 ? damaged(std::move(packet), random_) : packet;
  }

 private:
  static constexpr std::int64_t kBegins = 500'000;
  std::array<sink::LiveLinkSource, 2> sources_ = {sink::live_link_source("a phone"),
                                                  sink::live_link_source("another phone")};
  Random random_;
  sink::Datagrams out_;
};

namespace asio = boost::asio;
using asio::ip::udp;

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
class Impostor {
 public:
  struct Manner {
    Content content = Content::still;
    ForgedClock clock = ForgedClock::right;
    bool reference_only = false;  ///< Only as the sensor whose clock carries the frames.
    bool rebinds = false;         ///< Announces itself at another board's site now and then.
  };
  Impostor(const Victims& victims, Random random, Manner manner)
      : rig_(victims.rig), random_(random), manner_(manner), said_(victims.rig.sensors.size()) {}

  Bytes operator()(double time_s, std::size_t socket) {
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
Speech replayed(const Victims& victims, Random random) {
  return [&overheard = victims.overheard, random](double, std::size_t) mutable {
    return overheard.draw(random);
  };
}

/// Says what was overheard with something wrong in it; every second time the checksum is right all the same,
/// so that what lies behind it is reached.
Speech mutated(const Victims& victims, Random random) {
  return [&overheard = victims.overheard, random](double, std::size_t) mutable {
    return damaged(overheard.draw(random), random);
  };
}

Speech junk(const Victims&, Random random) {
  return [random](double, std::size_t) mutable {
    Bytes bytes(random.below(256));
    for (std::byte& byte : bytes) byte = static_cast<std::byte>(random.below(256));
    return bytes;
  };
}

/// A motion capture server on each socket.
Speech marker_servers(const Victims&, Random) {
  return [number = std::uint32_t{0}](double time_s, std::size_t socket) mutable {
    mocap::MarkerPositionsPacket packet;
    packet.device = 0x0200'0000'0000ULL + socket;
    packet.sequence = number++;
    packet.time = DeviceTime(std::chrono::floor<std::chrono::microseconds>(from_seconds(time_s)));
    packet.count = 60;
    for (Vec3f& position : packet.position_m) position = Vec3f(0.1F, 1.5F, 0.2F);
    return mocap::encode_marker_positions(packet).value_or(Bytes());
  };
}

/// A board that nobody knows on each socket, which says that it is there and nothing else.
Speech unknown_boards(const Victims&, Random) {
  return [](double, std::size_t socket) { return hello(0x0200'0000'0000ULL + socket, {}); };
}

/// Boards with SlimeVR's firmware and the numbers of the rig's own: handshakes and rotations.
Speech slimevr_boards(const Victims& victims, Random) {
  return [said = std::vector<std::uint64_t>(victims.rig.sensors.size())](double, std::size_t socket) mutable {
    namespace slimevr = imu::slimevr;
    const std::size_t sensor = socket % said.size();
    const std::uint64_t number = said[sensor]++;
    slimevr::TrackerMessage message = slimevr::Rotation{.xyzw = {0, 0, 0, 1}};
    if (number % 100 == 0) message = slimevr::Handshake{.mac = sensor::virtual_device(sensor)};
    if (number % 100 == 1) message = slimevr::SensorInfo{};
    ByteWriter out;
    (void)slimevr::encode_tracker_message(number + 1, message, out);  // All of its fields are in range.
    return out.release();
  };
}

template <Impostor::Manner kManner>
Speech impostor(const Victims& victims, Random random) {
  return Impostor(victims, random, kManner);
}

/// Eye trackers' OSC: rounds of coordinates as they should be, and messages that lie about their types,
/// numbers, lengths and depth.
Speech osc_programs(const Victims&, Random random) {
  return OscPrograms(random);
}

/// Our packets of gaze and of weights (types 11 and 12): as they should be, damaged, and with numbers that
/// none should have. As the rig's own programs where it has some, else as programs that nobody knows.
Speech face_programs(const Victims& victims, Random random) {
  return FacePrograms(victims.rig, random);
}

/// Phones with Live Link Face, two sockets of the same id each: packets as they should be, damaged, of
/// another name, of an hour later, without a face, and with numbers that none should have.
Speech face_phones(const Victims&, Random random) {
  return FacePhones(random);
}

using Begins = Attack::Begins;

/// One as each of twelve boards, at their own rate.
constexpr double kTwelve_hz = 12 * kPacketRateHz;

Attack of_camera(std::string_view name, std::string_view does, HostileCamera::Begin camera) {
  Attack attack{.name = name, .does = does};
  attack.camera = camera;
  return attack;
}

const std::array kAttacks = {
    Attack{"mutated", "what the devices sent, with something wrong in it", Begins::second, 5000, 4, 3,
           mutated},
    Attack{"replayed", "what the devices sent, again", Begins::second, kTwelve_hz, 1, 12, replayed},
    Attack{"junk", "random bytes from a hundred addresses", Begins::second, 50'000, 100, 1, junk},
    Attack{"markers", "well-formed marker packets from a hundred addresses", Begins::second, 9000, 100, 1,
           marker_servers},
    Attack{"osc", "eye trackers' OSC, right and wrong, from sixteen ports", Begins::second, 5000, 4, 4,
           osc_programs},
    Attack{"programs", "packets of gaze and weights, right and wrong, from sixteen ports", Begins::second,
           5000, 4, 4, face_programs},
    Attack{"phones",
           "phones with Live Link Face, two of each id, right and wrong, 2,000 packets a second each",
           Begins::second, 8000, 2, 2, face_phones},
    Attack{"table", "hellos of unknown boards from 300 ports", Begins::first, 600, 1, 300, unknown_boards},
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
           kTwelve_hz, 1, 12, slimevr_boards},
    Attack{.name = "slimevr-boards",
           .does = "the same, where the devices are SlimeVR boards themselves",
           .begins = Begins::second,
           .rate_hz = kTwelve_hz,
           .addresses = 1,
           .sockets = 12,
           .speech = slimevr_boards,
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
    of_camera("camera-endless", "a camera whose picture of 10 GB never ends", camera_endless_part),
    of_camera("camera-head", "a camera whose head never ends", camera_endless_head),
    of_camera("camera-flood", "a camera that sends pictures as fast as they are taken", camera_flood),
    of_camera("camera-lengths", "a camera whose lengths and chunks lie", camera_lying_lengths),
    of_camera("camera-trickle", "a camera that sends a byte a second", camera_trickle),
    of_camera("camera-hostile",
              "a camera that after a second of pictures sends broken ones, as fast as it can",
              camera_turned_hostile),
    of_camera("camera-redirect", "a camera that sends who asks elsewhere", camera_redirect),
    of_camera("camera-hangs-up", "a camera that gives one picture and hangs up", camera_hangs_up),
    of_camera("camera-clock", "a camera whose clock leaps, runs back and is no clock", camera_wild_clock),
};

/// 127.0.0.1 is the devices'; the strangers' begin with 127.0.1.1.
asio::ip::address_v4 stranger_address(std::size_t number) {
  return asio::ip::address_v4(0x7F000101U + static_cast<std::uint32_t>(number));
}

/// What has not left by then is not caught up: a machine that is busy is attacked less.
constexpr double kMostLate_s = 0.05;
constexpr auto kPace = std::chrono::milliseconds(2);

}  // namespace

std::vector<std::byte> damaged(std::vector<std::byte> datagram, Random& random) {
  switch (random.below(3)) {
    case 0:
      for (std::uint64_t flips = 1 + random.below(8); flips > 0; --flips)
        datagram[random.below(datagram.size())] ^= static_cast<std::byte>(1U << random.below(8));
      break;
    case 1:
      datagram.resize(1 + random.below(datagram.size()));
      break;
    default:
      for (std::uint64_t more = 1 + random.below(64); more > 0; --more)
        datagram.push_back(static_cast<std::byte>(random.below(256)));
  }
  if (!random.chance(0.5)) mend_checksum(datagram);
  return datagram;
}

void mend_checksum(std::vector<std::byte>& datagram) {
  if (datagram.size() <= sensor::kChecksumBytes) return;
  datagram.resize(datagram.size() - sensor::kChecksumBytes);
  ByteWriter mended;
  mended.append(datagram);
  sensor::write_checksum(0, mended);
  datagram = mended.release();
}

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
      const Bytes datagram = speech_(now_s, socket);
      boost::system::error_code code;  // A full buffer, or nobody there: the next may reach.
      sockets_[socket].send_to(asio::buffer(datagram), to_, 0, code);
      if (!code) ++sent_;
    }
    std::this_thread::sleep_for(kPace);
  }
}

}  // namespace mien::lab
