#include "mien/shaping/head_position.h"

namespace mien::shaping {

void HeadPosition::apply(face::OutputFrame& frame, double return_s) {
  const bool known = frame.head_position_known;
  frame.head_position_known = true;
  if (begun_ && known != known_) ease_out_.begin(kPositionPart, shown_, frame);
  if (ease_out_.active()) ease_out_.apply(frame, to_seconds(frame.time - shown_.time), return_s);
  shown_ = frame;
  frame.head_position_known = known || ease_out_.active();
  known_ = known;
  begun_ = true;
}

}  // namespace mien::shaping
