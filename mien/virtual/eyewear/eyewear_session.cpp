#include "mien/virtual/eyewear/eyewear_session.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "mien/virtual/eyewear/eyewear_boards.h"
#include "mien/virtual/imu/skin_trajectory.h"
#include "mien/virtual/node.h"
#include "mien/virtual/prologue_record.h"
#include "mien/virtual/reception.h"

namespace mien::virt {

Result<VirtualSession> play_eyewear(const performer::PrologueMotion& motion, const EyewearWearer& wearer,
                                    const sensor::Rig& rig, const EyewearFaults& faults,
                                    const Random& random) {
  if (motion.motion.frames.empty())
    return fail(ErrorCode::bad_usage, "the motion has no frames", motion.motion.name);
  const face::MotionCurve curve(motion.motion);
  MIEN_TRY_ASSIGN(EyewearBoards boards, EyewearBoards::put_on(wearer, rig, faults, random));
  MIEN_TRY_ASSIGN(Reception reception, Reception::create(rig));
  std::vector<Datagram> sent;
  while (boards.scanned_s() < curve.duration_s() + kDeviceMarginS)
    MIEN_TRY(boards.scan([&](double true_s) { return curve.at(true_s).weights; }, sent));
  // By arrival; of one moment by board and sequence, as they stand.
  sort_by_time(sent);

  VirtualSession session;
  session.events = prologue_events(motion.times, boards.clock());
  session.motion_start = boards.clock().device(motion.times.motion_start_s);
  reception.log_all(std::move(sent), session, [&](const take::Tick& tick, const sensor::TimeLines&) {
    session.truth.push_back(
        truth_at(curve, boards.clock().true_s(tick.frame), motion.times.motion_start_s, tick.frame));
  });
  return session;
}

}  // namespace mien::virt
