#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "mien/core/random.h"
#include "mien/face/motion.h"
#include "mien/face/output_frame.h"
#include "mien/sink/live_link.h"
#include "mien/virtual/network.h"
#include "mien/virtual/phone/phone_faults.h"
#include "mien/virtual/virtual_clock.h"

namespace mien::virt {

/// One phone before a performer's face, frame after frame of its own counter, in packets of Live Link Face
/// (docs/reference/phones.md). The same stream gives the same packets. Not thread-safe.
class PhoneSimulator {
 public:
  /// `motion_start_s`: true time of the motion's time 0.
  PhoneSimulator(const PhoneFaults& faults, double motion_start_s, const Random& random);

  /// Of its frames' times.
  [[nodiscard]] const VirtualClock& clock() const { return clock_; }
  /// How much older the face that it tells is than its frame, s.
  [[nodiscard]] double lag_s() const { return lag_s_; }
  /// True time of its next frame, s from the performance's time 0: up to there all has been filmed.
  [[nodiscard]] double filmed_s() const;

  /// The performance at a true time, s; asked for times before 0 and after its end, too.
  using Performed = std::function<face::MotionFrame(double true_s)>;
  /// The next frame: appends its packet, at its arrival, unless it is dropped. No packet arrives before one
  /// that was sent earlier.
  void film(const Performed& performed, std::vector<Datagram>& sent);

 private:
  [[nodiscard]] bool sees_face(double frame_s) const;
  /// The face as it was at this moment, smoothed, with the phone's own error.
  [[nodiscard]] face::OutputFrame told(const Performed& performed, double shown_s) const;
  void let_noise_go_on();

  PhoneFaults faults_;
  double motion_start_s_;
  VirtualClock clock_;
  double lag_s_;
  std::int64_t next_;  // Frame, of rate_hz.
  std::array<float, face::kShapeCount> rest_{}, gain_{}, noise_{};
  Random noises_, delays_, drops_, losses_;
  double lost_until_s_;
  HostTime newest_ = HostTime::min();
  sink::LiveLinkSource source_;
  sink::Datagrams packet_;
};

}  // namespace mien::virt
