#pragma once

#include "mien/speech/listener.h"

namespace mien::lab {

/// What loudness alone tells, as puppets have it: the jaw opens with the level above a floor that follows the
/// room's (up to 0.4 at 30 dB), lips are closed where the level falls 12 dB below what it was lately. A
/// baseline.
class LoudnessListener final : public speech::Listener {
 public:
  speech::Heard push(DeviceTime time, const speech::Block& block) override;
  void reset() override;

 private:
  double floor_db_ = 0, peak_db_ = 0;
  bool begun_ = false;
};

}  // namespace mien::lab
