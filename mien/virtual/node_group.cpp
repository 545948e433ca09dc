#include "mien/virtual/node_group.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "mien/virtual/mien_node.h"
#include "mien/virtual/slimevr_node.h"

namespace mien::virt {
namespace {

/// A stretch of the skin's trajectory: a packet of each sensor.
constexpr auto kStretchPoints = static_cast<std::size_t>(kTrajectoryRateHz / kFrameRateHz);
/// The newest points wait for those after them: a packet and what its samples' differences reach.
constexpr double kBehindS = 12 / kTrajectoryRateHz;

}  // namespace

NodeGroup::NodeGroup(Stage stage, NodeLanguage language, bool again)
    : stage_(std::move(stage)),
      encore_(again ? std::optional(add_encore(stage_.motion)) : std::nullopt),
      curve_(stage_.motion.motion),
      tracer_(curve_, stage_.sites, -kTrajectoryMarginS, curve_.duration_s() + kTrajectoryMarginS, encore_) {
  for (std::size_t s = 0; s < stage_.sites.size(); ++s) {
    simulators_.emplace_back(stage_.faults, static_cast<std::uint16_t>(s), stage_.devices.fork("sensor", s));
    const VirtualClock& clock = simulators_.back().clock();
    if (language == NodeLanguage::slimevr)
      nodes_.push_back(std::make_unique<SlimeVrNode>(s, clock));
    else
      nodes_.push_back(std::make_unique<MienNode>(s, stage_.rig.sensors[s].name, clock, stage_.faults));
  }
}

NodeGroup::Round NodeGroup::round_at(double time_s) const {
  const double end_s = curve_.duration_s();
  if (!encore_ || time_s < end_s) return {1, std::clamp(time_s / end_s, 0.0, 1.0)};
  const double rounds = (time_s - encore_->begin_s) / (encore_->end_s - encore_->begin_s);
  const double whole = std::floor(rounds);
  return {static_cast<std::size_t>(whole) + 1, rounds - whole};
}

void NodeGroup::begin(HostTime start) {
  for (const auto& node : nodes_) node->begin(start);
}

Result<void> NodeGroup::simulate() {
  const SkinTrajectory stretch = tracer_.next(kStretchPoints);
  for (std::size_t s = 0; s < nodes_.size(); ++s) MIEN_TRY(nodes_[s]->play(simulators_[s].play(stretch)));
  return {};
}

double NodeGroup::simulated_s() const {
  if (tracer_.done()) return std::numeric_limits<double>::infinity();
  return tracer_.traced_s() - kBehindS;
}

bool NodeGroup::finished() const {
  return tracer_.done() && std::ranges::all_of(nodes_, [](const auto& node) { return node->idle(); });
}

}  // namespace mien::virt
