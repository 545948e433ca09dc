#include "mien/virtual/eyewear/worn_eyewear.h"

#include "mien/virtual/eyewear/eyewear_boards.h"
#include "mien/virtual/eyewear/eyewear_session.h"
#include "mien/virtual/node.h"
#include "mien/virtual/speaking_node.h"

namespace mien::virt {
namespace {

/// A scan arrives this long after its end at the latest.
constexpr double kOnTheWireS = 0.02;

class EyewearOnNetwork final : public NodeDevices {
 public:
  EyewearOnNetwork(EyewearBoards boards, const PlayedMotion& motion)
      : boards_(std::move(boards)), motion_(motion), end_s_(motion.curve.duration_s() + kDeviceMarginS) {
    for (std::size_t board = 0; board < boards_.count(); ++board) nodes_.emplace_back(boards_.device(board));
  }
  [[nodiscard]] std::vector<Node*> nodes() override {
    std::vector<Node*> all;
    for (SpeakingNode& node : nodes_) all.push_back(&node);
    return all;
  }
  [[nodiscard]] Result<void> simulate() override {
    sent_.clear();
    MIEN_TRY(boards_.scan(
        [this](double true_s) {
          return (motion_.encore ? motion_.encore->at(motion_.curve, true_s) : motion_.curve.at(true_s))
              .weights;
        },
        sent_));
    for (Datagram& scan : sent_) nodes_[scan.source].hand_over(std::move(scan));
    return {};
  }
  [[nodiscard]] double simulated_s() const override { return boards_.scanned_s() - kOnTheWireS; }
  [[nodiscard]] bool done() const override { return !motion_.encore && boards_.scanned_s() >= end_s_; }

 private:
  EyewearBoards boards_;
  std::vector<SpeakingNode> nodes_;
  PlayedMotion motion_;
  double end_s_;
  std::vector<Datagram> sent_;
};

}  // namespace

performer::PrologueNeeds WornEyewear::prologue(const Stage&) const {
  return performer::kEyewearPrologue;
}

Result<Sent> WornEyewear::send(const Stage& stage, const Progress&) const {
  return send_eyewear(stage.motion, wearer_, rig_, faults_, stage.devices);
}

Result<std::unique_ptr<NodeDevices>> WornEyewear::on_network(const Stage& stage, const PlayedMotion& motion,
                                                             NodeLanguage language) const {
  if (language == NodeLanguage::slimevr)
    return fail(ErrorCode::bad_usage, "eyewear does not speak SlimeVR's language", rig_.name,
                "send to udp://HOST:PORT");
  MIEN_TRY_ASSIGN(EyewearBoards boards, EyewearBoards::put_on(wearer_, rig_, faults_, stage.devices));
  return std::make_unique<EyewearOnNetwork>(std::move(boards), motion);
}

Result<std::shared_ptr<const WornDevices>> wear_eyewear(const StageRequest& request, face::Face face,
                                                        const Random& root, const Stage& stage) {
  if (stage.lab)
    return fail(ErrorCode::bad_usage, "the profile lab is of sensors on the skin, and these look at it",
                stage.rig.name, "use --devices device");
  if (request.unlike > 0)
    return fail(ErrorCode::bad_usage, "only sensors that are glued to it feel how skin turns", stage.rig.name,
                "leave out --unlike");
  MIEN_TRY_ASSIGN(const FaultsText faults, read_faults(request, stage.rig));
  MIEN_TRY_ASSIGN(EyewearFaults drawn, parse_eyewear_faults(faults.toml, faults.where));
  MIEN_TRY_ASSIGN(EyewearWearer wearer, seat_eyewear(std::move(face), stage.rig, drawn, root.fork("wearer")));
  return std::make_shared<const WornEyewear>(stage.rig, std::move(drawn), std::move(wearer));
}

}  // namespace mien::virt
