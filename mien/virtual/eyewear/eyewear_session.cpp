#include "mien/virtual/eyewear/eyewear_session.h"

#include <utility>

#include "mien/virtual/eyewear/eyewear_boards.h"
#include "mien/virtual/node.h"
#include "mien/virtual/reception.h"

namespace mien::virt {

Result<Sent> send_eyewear(const performer::PrologueMotion& motion, const EyewearWearer& wearer,
                          const sensor::Rig& rig, const EyewearFaults& faults, const Random& random) {
  if (motion.motion.frames.empty())
    return fail(ErrorCode::bad_usage, "the motion has no frames", motion.motion.name);
  const face::MotionCurve curve(motion.motion);
  MIEN_TRY_ASSIGN(EyewearBoards boards, EyewearBoards::put_on(wearer, rig, faults, random));
  Sent sent;
  while (boards.scanned_s() < curve.duration_s() + kDeviceMarginS)
    MIEN_TRY(boards.scan([&](double true_s) { return curve.at(true_s).weights; }, sent.datagrams));
  sent.reference = boards.clock();
  return sent;
}

Result<VirtualSession> play_eyewear(const performer::PrologueMotion& motion, const EyewearWearer& wearer,
                                    const sensor::Rig& rig, const EyewearFaults& faults,
                                    const Random& random) {
  MIEN_TRY_ASSIGN(Sent sent, send_eyewear(motion, wearer, rig, faults, random));
  return receive_all(std::move(sent), motion, rig);
}

}  // namespace mien::virt
