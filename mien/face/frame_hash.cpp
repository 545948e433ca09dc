#include "mien/face/frame_hash.h"

namespace mien::face {

void FrameHash::add(const OutputFrame& frame) {
  hash_.add_value(static_cast<std::int64_t>(frame.time.time_since_epoch().count()));
  for (const float w : frame.weights.values) hash_.add_value(w);
  for (const double h : {frame.head.w(), frame.head.x(), frame.head.y(), frame.head.z()})
    hash_.add_value(static_cast<float>(h));
  for (const Eigen::Vector2f& eye : frame.eyes_rad) {
    hash_.add_value(eye.x());
    hash_.add_value(eye.y());
  }
  for (const Provenance p : frame.provenance) hash_.add_value(static_cast<std::uint8_t>(p));
  hash_.add_value(static_cast<std::uint8_t>(frame.head_provenance));
  hash_.add_value(static_cast<std::uint8_t>(frame.eyes_provenance));
  if (frame.head_position_known)
    for (const float x : frame.head_position_m) hash_.add_value(x);
}

}  // namespace mien::face
