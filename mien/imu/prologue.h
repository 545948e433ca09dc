#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "mien/core/rotation.h"
#include "mien/core/time.h"
#include "mien/imu/calibration.h"
#include "mien/imu/heading.h"
#include "mien/sensor/rig.h"

namespace mien::imu {

/// Gathers the prologue frame by frame and makes the calibration of it. No frame is kept: sums hold all.
class Prologue {
 public:
  explicit Prologue(const sensor::Rig& rig);

  /// What one frame says. `face` holds one entry a face sensor; an absent one is missing.
  struct Frame {
    DeviceTime time;  ///< Reference sensor's clock.
    Quat q_world_ear;
    Vec3 ear_rate_rad_s = Vec3::Zero();  ///< Without bias, the ear sensor's axes.
    Vec3 ear_force_world_m_s2 = Vec3::Zero();
    bool ear_fresh = true;  ///< Heard for this frame, not held over a gap.
    struct Face {
      bool present = false;
      bool fresh = true;  ///< Of a present one: heard for this frame, not held over a gap.
      Quat q_world_face;
      Vec3 force_world_m_s2 = Vec3::Zero();
      Vec3 rate_rad_s = Vec3::Zero();  ///< Without bias, its own axes; for who watches for stillness.
    };
    std::vector<Face> face;
  };

  void begin_neutral();
  void add_neutral(const Frame& frame);
  void begin_nod();
  void add_nod(const Frame& frame);
  void begin_shake();
  void add_shake(const Frame& frame);

  /// What is known now. Complete when neutral and nod are in and the ear sensor was there; scores judge what
  /// is in.
  [[nodiscard]] Calibration solve() const;

 private:
  struct Sway {
    Mat3 rate_square = Mat3::Zero();  // Sum of rate rate^T.
    std::size_t count = 0;
    double largest_rad = 0;  // From neutral.
    void add(const Vec3& rate_rad_s, double angle_rad);
    [[nodiscard]] Vec3 axis() const;          // The one turned about most; sign free.
    [[nodiscard]] double axis_share() const;  // Of the turning, how much is about it.
    [[nodiscard]] double rms_rad_s() const;
  };
  // A face sensor's vertical acceleration less the ear's, and the head's angular acceleration: sums for their
  // linear regression.
  struct Swing {
    std::size_t count = 0;
    double accel = 0;
    Vec3 turn = Vec3::Zero(), product = Vec3::Zero();
    Mat3 turn_square = Mat3::Zero();
    void add(double accel_m_s2, const Vec3& turn_rad_s2);
    // About `left`, times count.
    [[nodiscard]] double covariance(const Vec3& left) const;
    [[nodiscard]] double variance(const Vec3& left) const;
  };
  [[nodiscard]] Vec3 from_neutral(const Quat& q_world_ear) const;
  /// How far the face's sensors lie ahead of the ear's where `left` is to the left, m, as the nod's swing
  /// tells; 0 where it does not.
  [[nodiscard]] double ahead_m(const Vec3& left) const;

  std::vector<std::string> names_;
  std::vector<std::optional<Vec3>> outward_;
  std::vector<HeadingSums> hold_;
  std::vector<HeadingSums> nod_;
  // Face less ear force over the hold is linear in cos and sin of the heading too; it is averaged after Z is
  // known.
  struct ForceSums {
    Vec3 constant = Vec3::Zero(), cosine = Vec3::Zero(), sine = Vec3::Zero();
  };
  std::vector<ForceSums> force_;
  Mat3 ear_sum_ = Mat3::Zero();  // Of R_h over the hold.
  Vec3 ear_up_sum_ = Vec3::Zero();
  Sway still_;
  Sway nodding_;
  Sway shaking_;
  double face_side_ = 1;      // 1: the face is ahead of the head's sensor, -1: behind it; 0: beside it.
  std::vector<Swing> swing_;  // In the nod.
  struct Turning {
    DeviceTime time;  ///< Reference sensor's clock.
    Vec3 rate_rad_s;
  };
  std::optional<Turning> last_nod_;
  std::optional<Vec3> first_turn_;
};

}  // namespace mien::imu
