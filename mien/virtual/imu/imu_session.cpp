#include "mien/virtual/imu/imu_session.h"

#include <cmath>
#include <utility>

#include "mien/imu/packets/packet.h"
#include "mien/virtual/imu/imu_simulator.h"
#include "mien/virtual/node.h"
#include "mien/virtual/reception.h"

namespace mien::virt {

Result<Sent> send_devices(const performer::PrologueMotion& motion, const std::vector<SkinSite>& sites,
                          const sensor::Rig& rig, const DeviceFaults& faults, const Random& random,
                          const Progress& progress) {
  MIEN_TRY_ASSIGN(const face::MotionCurve curve, curve_of(motion));
  const SkinTrajectory trajectory =
      trace_skin(curve, sites, -kDeviceMarginS, curve.duration_s() + kDeviceMarginS);

  MIEN_TRY_ASSIGN(const std::vector<sensor::DeviceKey> devices, virtual_devices(rig));
  const std::uint16_t reference = rig.find(rig.reference).value_or(0);
  Sent sent;
  for (std::size_t s = 0; s < sites.size(); ++s) {
    if (!progress(static_cast<double>(s) / static_cast<double>(sites.size()), "performing"))
      return fail(ErrorCode::cancelled, "stopped", motion.motion.name);
    ImuSimulator simulator(faults, static_cast<std::uint16_t>(s), random.fork("sensor", s));
    if (s == reference) sent.reference = simulator.clock();
    for (const VirtualPacket& virtual_packet : simulator.play(trajectory)) {
      if (virtual_packet.lost) continue;
      MIEN_TRY_ASSIGN(std::vector<std::byte> bytes, encode_device_packet(virtual_packet, devices[s], faults));
      sent.datagrams.push_back({virtual_packet.arrival, static_cast<std::uint16_t>(s), std::move(bytes)});
    }
  }
  return sent;
}

Result<VirtualSession> play_devices(const performer::PrologueMotion& motion,
                                    const std::vector<SkinSite>& sites, const sensor::Rig& rig,
                                    const DeviceFaults& faults, const Random& random,
                                    const Progress& progress) {
  MIEN_TRY_ASSIGN(Sent sent, send_devices(motion, sites, rig, faults, random, progress));
  return receive_all(std::move(sent), motion, rig);
}

Result<Sent> send_lab(const performer::PrologueMotion& motion, const std::vector<SkinSite>& sites,
                      const sensor::Rig& rig, const Random& random, double noise_rad) {
  MIEN_TRY_ASSIGN(const face::MotionCurve curve, curve_of(motion));
  const std::vector<std::uint16_t> face_sensors = rig.face_sensors();
  MIEN_TRY_ASSIGN(const std::vector<sensor::DeviceKey> devices, virtual_devices(rig));
  std::vector<Random> noise;
  for (const std::uint16_t s : face_sensors) noise.push_back(random.fork("lab noise", s));

  Sent sent;  // All clocks are one.
  sent.frames = static_cast<std::int64_t>(std::floor((curve.duration_s() + kSameMomentS) * kFrameRateHz)) + 1;
  for (std::int64_t f = 0; f < *sent.frames; ++f) {
    const Duration at = frame_offset(f);
    const face::MotionFrame moment = curve.at(to_seconds(at));
    for (std::size_t i = 0; i < face_sensors.size(); ++i) {
      const std::uint16_t s = face_sensors[i];
      Random& draw = noise[i];
      Vec3 rotation = log_rotation(sites[s].rotation(moment.weights));
      for (Eigen::Index axis = 0; axis < 3; ++axis) rotation[axis] += noise_rad * draw.normal();
      sensor::Sample sample;
      sample.sensor = s;
      sample.kind = sensor::SampleKind::imu_head_relative;
      sample.sequence = static_cast<std::uint32_t>(f);
      sample.time = DeviceTime(at);
      sample.count = 3;
      for (std::size_t axis = 0; axis < 3; ++axis)
        sample.values[axis] = static_cast<float>(rotation[static_cast<Eigen::Index>(axis)]);
      MIEN_TRY_ASSIGN(imu::Packet packet, imu::make_packet({&sample, 1}));
      packet.device = devices[s].device;
      packet.channel = devices[s].channel;
      packet.sequence = sample.sequence;
      MIEN_TRY_ASSIGN(std::vector<std::byte> bytes, imu::encode_packet(packet));
      sent.datagrams.push_back({HostTime(at), s, std::move(bytes)});
    }
  }
  return sent;
}

Result<VirtualSession> play_lab(const performer::PrologueMotion& motion, const std::vector<SkinSite>& sites,
                                const sensor::Rig& rig, const Random& random, double noise_rad) {
  MIEN_TRY_ASSIGN(Sent sent, send_lab(motion, sites, rig, random, noise_rad));
  return receive_all(std::move(sent), motion, rig);
}

}  // namespace mien::virt
