#include "mien/virtual/node_group.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "mien/virtual/sealed_node.h"

namespace mien::virt {

NodeGroup::NodeGroup(Stage stage, bool again)
    : stage_(std::move(stage)),
      encore_(again ? std::optional(performer::add_encore(stage_.motion)) : std::nullopt),
      curve_(stage_.motion.motion) {}

NodeGroup::~NodeGroup() = default;

Result<std::unique_ptr<NodeGroup>> NodeGroup::create(Stage stage, NodeLanguage language, bool again) {
  if (stage.lab)
    return fail(ErrorCode::bad_usage, "the profile lab has no devices that could be on a network",
                stage.rig.name, "use --devices device, or --take");
  std::unique_ptr<NodeGroup> group(new NodeGroup(std::move(stage), again));
  const Stage& own = group->stage_;
  MIEN_TRY_ASSIGN(group->devices_,
                  own.worn->on_network(own, {.curve = group->curve_, .encore = group->encore_}, language));
  group->nodes_ = group->devices_->nodes();
  return group;
}

void NodeGroup::seal(const sensor::SealKey& key, std::uint32_t power_ons) {
  for (Node*& node : nodes_)
    node = sealed_.emplace_back(std::make_unique<SealedNode>(*node, key, power_ons)).get();
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
