#include "mien/virtual/eyewear/eyewear_boards.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "mien/eyewear/packet.h"
#include "mien/sensor/protocol.h"

namespace mien::virt {
namespace {

/// Scans that are simulated at once: some 17 ms, in which light changes evenly enough.
constexpr int kScansAtOnce = 4;
/// A byte on a serial line of 250,000 bit/s, with its start and stop bit.
constexpr double kByteS = 10 / 250'000.0;

}  // namespace

Result<EyewearBoards> EyewearBoards::put_on(const EyewearWearer& wearer, const sensor::Rig& rig,
                                            const EyewearFaults& faults, const Random& random) {
  std::map<std::uint64_t, std::map<std::uint8_t, std::uint16_t>> channels;
  for (std::uint16_t s = 0; s < rig.sensors.size(); ++s) {
    const sensor::Mount& mount = rig.sensors[s];
    if (mount.device.empty())
      return fail(ErrorCode::bad_usage, fmt::format("sensor {} belongs to no board", mount.name), rig.name,
                  "give it a device, \"id/channel\", in the rig file");
    MIEN_TRY_ASSIGN(const sensor::DeviceKey key, sensor::parse_device(mount.device));
    channels[key.device][key.channel] = s;
  }
  std::vector<Board> boards;
  for (const auto& [device, sensors] : channels) {
    Board& board = boards.emplace_back();
    board.device = device;
    for (const auto& [channel, s] : sensors) {
      if (channel != board.sensors.size() || board.sensors.size() == eyewear::kMaxChannels)
        return fail(ErrorCode::bad_usage,
                    fmt::format("the board of {} has channels that are not 0, 1, 2, ... in a row",
                                rig.sensors[s].name),
                    rig.name, fmt::format("a board has {} channels at the most", eyewear::kMaxChannels));
      board.sensors.push_back(s);
    }
  }
  return EyewearBoards(wearer, faults, random, std::move(boards), rig.sensors.size());
}

EyewearBoards::EyewearBoards(const EyewearWearer& wearer, const EyewearFaults& faults, const Random& random,
                             std::vector<Board> boards, std::size_t sensors)
    : simulator_(wearer, faults, random),
      adc_bits_(static_cast<std::uint8_t>(
          std::clamp<double>(faults.adc_bits, eyewear::kMinAdcBits, eyewear::kMaxAdcBits))),
      boards_(std::move(boards)),
      sensors_(sensors) {
  simulator_.put_on();
}

Result<void> EyewearBoards::scan(const std::function<face::BlendshapeWeights(double)>& weights_at,
                                 std::vector<Datagram>& sent) {
  const double period_s = simulator_.pair_period_s();
  const double begin_s = scanned_s_;
  const double end_s = begin_s + kScansAtOnce * period_s;
  const std::vector<sensor::Sample> samples =
      simulator_.play(begin_s, kScansAtOnce, weights_at(begin_s), weights_at(end_s));
  std::vector<sensor::Sample> scan;
  for (std::size_t p = 0; p < kScansAtOnce; ++p)
    for (std::size_t b = 0; b < boards_.size(); ++b) {
      const Board& board = boards_[b];
      scan.clear();
      Duration offsets{};  // A scan has one time, its middle.
      for (const std::uint16_t s : board.sensors) {
        scan.push_back(samples[p * sensors_ + s]);
        offsets += scan.back().time - scan.front().time;
      }
      const DeviceTime middle = scan.front().time + offsets / static_cast<std::int64_t>(scan.size());
      for (sensor::Sample& sample : scan) sample.time = middle;
      MIEN_TRY_ASSIGN(eyewear::Packet packet, eyewear::make_packet(scan, adc_bits_));
      packet.device = board.device;
      MIEN_TRY_ASSIGN(std::vector<std::byte> bytes, eyewear::encode_packet(packet));
      const double heard_s =
          begin_s + static_cast<double>(p + 1) * period_s + kByteS * static_cast<double>(bytes.size());
      sent.push_back({HostTime(from_seconds(heard_s)), static_cast<std::uint16_t>(b), std::move(bytes)});
    }
  scanned_s_ = end_s;
  return {};
}

}  // namespace mien::virt
