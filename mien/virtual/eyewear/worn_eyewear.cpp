#include "mien/virtual/eyewear/worn_eyewear.h"

#include "mien/virtual/eyewear/eyewear_boards.h"
#include "mien/virtual/node.h"
#include "mien/virtual/reception.h"
#include "mien/virtual/speaking_node.h"

namespace mien::virt {
namespace {

/// A scan arrives this long after its end at the latest.
constexpr double kOnTheWireS = 0.02;

class EyewearOnNetwork final : public SpeakingDevices {
 public:
  EyewearOnNetwork(EyewearBoards boards, const PlayedMotion& motion)
      : SpeakingDevices(motion, motion.curve.duration_s() + kDeviceMarginS), boards_(std::move(boards)) {
    for (std::size_t board = 0; board < boards_.count(); ++board) nodes_.emplace_back(boards_.device(board));
    simulated_s_ = boards_.scanned_s();
  }
  [[nodiscard]] Result<void> simulate() override {
    sent_.clear();
    MIEN_TRY(boards_.scan([this](double true_s) { return motion_.at(true_s).weights; }, sent_));
    for (Datagram& scan : sent_) nodes_[scan.source].hand_over(std::move(scan));
    simulated_s_ = boards_.scanned_s();
    return {};
  }
  [[nodiscard]] double simulated_s() const override { return simulated_s_ - kOnTheWireS; }

 private:
  EyewearBoards boards_;
  std::vector<Datagram> sent_;
};

}  // namespace

performer::PrologueNeeds WornEyewear::prologue(const Stage&) const {
  return performer::kEyewearPrologue;
}

Result<Sent> WornEyewear::send(const Stage& stage, const Progress&) const {
  MIEN_TRY_ASSIGN(const face::MotionCurve curve, curve_of(stage.motion));
  MIEN_TRY_ASSIGN(EyewearBoards boards, EyewearBoards::put_on(wearer_, rig_, faults_, stage.devices));
  Sent sent;
  while (boards.scanned_s() < curve.duration_s() + kDeviceMarginS)
    MIEN_TRY(boards.scan([&](double true_s) { return curve.at(true_s).weights; }, sent.datagrams));
  sent.reference = boards.clock();
  return sent;
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
