#pragma once

#include <string>

#include "mien/core/sha256.h"
#include "mien/face/output_frame.h"

namespace mien::face {

/// SHA-256 over a run of output frames, as the contract has it: for each frame its device time (i64 ns), the
/// 53 weights (f32), head w,x,y,z (f32), eyes yaw and pitch left then right (f32), the 53 provenances, the
/// head's and the eyes' (u8), and where it is known the head's position x,y,z (f32). Two runs with one hash
/// gave the same bits. No allocation in add.
class FrameHash {
 public:
  void add(const OutputFrame& frame);
  /// Of all that was added. Add nothing afterwards.
  [[nodiscard]] std::string hex() { return hash_.hex(); }

 private:
  Sha256 hash_;
};

}  // namespace mien::face
