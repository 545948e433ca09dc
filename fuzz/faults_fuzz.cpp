#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string_view>
#include <vector>

#include "mien/imu/packets/packet.h"
#include "mien/virtual/imu/device_faults.h"
#include "mien/virtual/imu/imu_simulator.h"

namespace {

/// A patch of skin that never moves, for a twentieth of a second.
std::vector<mien::virt::VirtualPacket> play(const mien::virt::DeviceFaults& faults) {
  using namespace mien;
  std::vector<virt::SkinSite> sites(1);
  for (auto& c : sites[0].shape_covariance) c.setZero();
  for (auto& d : sites[0].shape_shift_m) d.setZero();
  face::Motion still;
  still.frames.resize(4);
  for (std::size_t f = 0; f < still.frames.size(); ++f)
    still.frames[f].time_s = static_cast<double>(f) / kFrameRateHz;
  const face::MotionCurve curve(still);
  return virt::ImuSimulator(faults, 0, Random(1)).play(virt::trace_skin(curve, sites, 0, 0.05));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto faults =
      mien::virt::parse_faults(std::string_view(reinterpret_cast<const char*>(data), size), "input");
  if (!faults) return 0;
  // What was accepted can be played, and no packet is anything that a reader refuses.
  for (const mien::virt::VirtualPacket& sent : play(*faults)) {
    const auto packet = mien::imu::make_packet(sent.samples);
    if (!packet || !mien::imu::encode_packet(*packet)) std::abort();
  }
  return 0;
}
