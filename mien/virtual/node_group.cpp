#include "mien/virtual/node_group.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "mien/virtual/eyewear/eyewear_boards.h"
#include "mien/virtual/eyewear/eyewear_node.h"
#include "mien/virtual/imu/imu_simulator.h"
#include "mien/virtual/imu/mien_node.h"
#include "mien/virtual/imu/skin_trajectory.h"
#include "mien/virtual/imu/slimevr_node.h"

namespace mien::virt {
namespace {

/// A stretch of the skin's trajectory: a packet of each sensor.
constexpr auto kStretchPoints = static_cast<std::size_t>(kTrajectoryRateHz / kFrameRateHz);
/// The newest points wait for those after them: a packet and what its samples' differences reach.
constexpr double kBehindS = 12 / kTrajectoryRateHz;
/// A scan is heard this long after its end at the latest.
constexpr double kOnTheWireS = 0.02;

}  // namespace

class NodeGroup::Devices {
 public:
  virtual ~Devices() = default;
  [[nodiscard]] virtual std::vector<Node*> nodes() = 0;
  [[nodiscard]] virtual Result<void> simulate() = 0;
  [[nodiscard]] virtual double simulated_s() const = 0;
  [[nodiscard]] virtual bool done() const = 0;
};

class NodeGroup::Imus final : public Devices {
 public:
  Imus(const NodeGroup& group, NodeLanguage language)
      : tracer_(group.curve_, group.stage_.sites, -kTrajectoryMarginS,
                group.curve_.duration_s() + kTrajectoryMarginS, group.encore_) {
    const Stage& stage = group.stage_;
    for (std::size_t s = 0; s < stage.sites.size(); ++s) {
      simulators_.emplace_back(stage.faults, static_cast<std::uint16_t>(s), stage.devices.fork("sensor", s));
      const VirtualClock& clock = simulators_.back().clock();
      if (language == NodeLanguage::slimevr)
        nodes_.push_back(std::make_unique<SlimeVrNode>(s, clock));
      else
        nodes_.push_back(std::make_unique<MienNode>(s, stage.rig.sensors[s].name, clock, stage.faults));
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

class NodeGroup::Eyewear final : public Devices {
 public:
  Eyewear(const NodeGroup& group, EyewearBoards boards)
      : boards_(std::move(boards)),
        nodes_(boards_.count()),
        encore_(group.encore_),
        curve_(group.curve_),
        end_s_(group.curve_.duration_s() + kTrajectoryMarginS) {}
  [[nodiscard]] std::vector<Node*> nodes() override {
    std::vector<Node*> all;
    for (EyewearNode& node : nodes_) all.push_back(&node);
    return all;
  }
  [[nodiscard]] Result<void> simulate() override {
    sent_.clear();
    MIEN_TRY(boards_.scan(
        [this](double true_s) { return (encore_ ? encore_->at(curve_, true_s) : curve_.at(true_s)).weights; },
        sent_));
    for (Datagram& scan : sent_) nodes_[scan.source].hand_over(std::move(scan));
    return {};
  }
  [[nodiscard]] double simulated_s() const override { return boards_.scanned_s() - kOnTheWireS; }
  [[nodiscard]] bool done() const override { return !encore_ && boards_.scanned_s() >= end_s_; }

 private:
  EyewearBoards boards_;
  std::vector<EyewearNode> nodes_;
  const std::optional<performer::Encore>& encore_;
  const face::MotionCurve& curve_;
  double end_s_;
  std::vector<Datagram> sent_;
};

NodeGroup::NodeGroup(Stage stage, bool again)
    : stage_(std::move(stage)),
      encore_(again ? std::optional(performer::add_encore(stage_.motion)) : std::nullopt),
      curve_(stage_.motion.motion) {}

NodeGroup::~NodeGroup() = default;

Result<std::unique_ptr<NodeGroup>> NodeGroup::create(Stage stage, NodeLanguage language, bool again) {
  if (stage.lab)
    return fail(ErrorCode::bad_usage, "the profile lab has no devices that could be on a network",
                stage.rig.name, "use --devices device, or --take");
  if (stage.eyewear && language == NodeLanguage::slimevr)
    return fail(ErrorCode::bad_usage, "eyewear does not speak SlimeVR's language", stage.rig.name,
                "send to udp://HOST:PORT");
  std::unique_ptr<NodeGroup> group(new NodeGroup(std::move(stage), again));
  if (const auto& worn = group->stage_.eyewear) {
    MIEN_TRY_ASSIGN(EyewearBoards boards, EyewearBoards::put_on(worn->wearer, group->stage_.rig, worn->faults,
                                                                group->stage_.devices));
    group->devices_ = std::make_unique<Eyewear>(*group, std::move(boards));
  } else {
    group->devices_ = std::make_unique<Imus>(*group, language);
  }
  group->nodes_ = group->devices_->nodes();
  return group;
}

NodeGroup::Round NodeGroup::round_at(double time_s) const {
  const double end_s = curve_.duration_s();
  if (!encore_ || time_s < end_s) return {1, std::clamp(time_s / end_s, 0.0, 1.0)};
  const double rounds = (time_s - encore_->begin_s) / (encore_->end_s - encore_->begin_s);
  const double whole = std::floor(rounds);
  return {static_cast<std::size_t>(whole) + 1, rounds - whole};
}

void NodeGroup::begin(HostTime start) {
  for (Node* node : nodes_) node->begin(start);
}

Result<void> NodeGroup::simulate() {
  return devices_->simulate();
}

double NodeGroup::simulated_s() const {
  return devices_->done() ? std::numeric_limits<double>::infinity() : devices_->simulated_s();
}

bool NodeGroup::finished() const {
  return devices_->done() && std::ranges::all_of(nodes_, [](const Node* node) { return node->idle(); });
}

}  // namespace mien::virt
