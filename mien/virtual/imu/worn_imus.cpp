#include "mien/virtual/imu/worn_imus.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <utility>

#include "mien/virtual/imu/imu_node.h"
#include "mien/virtual/imu/imu_session.h"
#include "mien/virtual/imu/imu_simulator.h"
#include "mien/virtual/imu/mien_node.h"
#include "mien/virtual/imu/skin_trajectory.h"
#include "mien/virtual/imu/slimevr_node.h"
#include "mien/virtual/imu/streamed_session.h"

namespace mien::virt {
namespace {

/// A stretch of the skin's trajectory: a packet of each sensor.
constexpr auto kStretchPoints = static_cast<std::size_t>(kTrajectoryRateHz / kFrameRateHz);
/// The newest points wait for those after them: a packet and what its samples' differences reach.
constexpr double kBehindS = 12 / kTrajectoryRateHz;

class ImusOnNetwork final : public NodeDevices {
 public:
  ImusOnNetwork(const Stage& stage, const sensor::Rig& rig, const DeviceFaults& faults,
                const std::vector<SkinSite>& sites, const PlayedMotion& motion, NodeLanguage language)
      : tracer_([motion](double time_s) { return motion.at(time_s); }, sites, -kDeviceMarginS,
                motion.encore ? std::numeric_limits<double>::infinity()
                              : motion.curve.duration_s() + kDeviceMarginS) {
    for (std::size_t s = 0; s < sites.size(); ++s) {
      simulators_.emplace_back(faults, static_cast<std::uint16_t>(s), stage.devices.fork("sensor", s));
      const VirtualClock& clock = simulators_.back().clock();
      if (language == NodeLanguage::slimevr)
        nodes_.push_back(std::make_unique<SlimeVrNode>(s, clock));
      else
        nodes_.push_back(std::make_unique<MienNode>(s, rig.sensors[s].name, clock, faults));
    }
  }
  [[nodiscard]] std::vector<Node*> nodes() override {
    std::vector<Node*> all;
    for (const auto& node : nodes_) all.push_back(node.get());
    return all;
  }
  [[nodiscard]] Result<void> simulate() override {
    const SkinTrajectory stretch = tracer_.next(kStretchPoints);
    for (std::size_t s = 0; s < nodes_.size(); ++s) MIEN_TRY(nodes_[s]->play(simulators_[s].play(stretch)));
    return {};
  }
  [[nodiscard]] double simulated_s() const override { return tracer_.traced_s() - kBehindS; }
  [[nodiscard]] bool done() const override { return tracer_.done(); }

 private:
  SkinTracer tracer_;
  std::vector<ImuSimulator> simulators_;
  std::vector<std::unique_ptr<ImuNode>> nodes_;
};

class ImuStream final : public SessionStream {
 public:
  explicit ImuStream(StreamedSession session) : session_(std::move(session)) {}
  [[nodiscard]] Result<Stretch> next(const Progress&) override {
    Stretch stretch;
    MIEN_TRY_ASSIGN(stretch.session, session_.next());
    stretch.share =
        done() ? 1 : std::clamp(session_.simulated_s() / (session_.duration_s() + kDeviceMarginS), 0.0, 1.0);
    return stretch;
  }
  [[nodiscard]] bool done() const override { return session_.done(); }

 private:
  StreamedSession session_;
};

}  // namespace

performer::PrologueNeeds WornImus::prologue(const Stage& stage) const {
  return {.gestures = !stage.lab};
}

Result<Sent> WornImus::send(const Stage& stage, const Progress& progress) const {
  if (stage.lab) return send_lab(stage.motion, sites_, rig_, stage.devices);
  return send_devices(stage.motion, sites_, rig_, faults_, stage.devices, progress);
}

Result<std::unique_ptr<SessionStream>> WornImus::stream(const Stage& stage) const {
  MIEN_TRY_ASSIGN(StreamedSession session,
                  StreamedSession::create(rig_, sites_, faults_, long_motion(stage), stage.devices));
  return std::make_unique<ImuStream>(std::move(session));
}

Result<std::unique_ptr<NodeDevices>> WornImus::on_network(const Stage& stage, const PlayedMotion& motion,
                                                          NodeLanguage language) const {
  return std::make_unique<ImusOnNetwork>(stage, rig_, faults_, sites_, motion, language);
}

Result<std::shared_ptr<const WornDevices>> wear_imus(const StageRequest& request, face::Face face,
                                                     const Random& root, const Stage& stage) {
  DeviceFaults drawn;
  if (!stage.lab) {
    MIEN_TRY_ASSIGN(const FaultsText faults, read_faults(request, stage.rig));
    MIEN_TRY_ASSIGN(drawn, parse_faults(faults.toml, faults.where));
  }
  const std::vector<Vec3> placement_m =
      draw_placement(stage.rig, 1e-3 * drawn.mount_position_mm, root.fork("placement"));
  MIEN_TRY_ASSIGN(std::vector<SkinSite> sites, skin_sites(face, stage.rig, placement_m));
  if (request.unlike > 0)
    sites = draw_kinematics(sites, KinematicsSpread().times(request.unlike), root.fork("kinematics"));
  return std::make_shared<const WornImus>(stage.rig, std::move(drawn), std::move(sites));
}

}  // namespace mien::virt
