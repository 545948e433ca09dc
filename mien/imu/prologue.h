#pragma once

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

/// Accumulates the prologue frame by frame and solves for the calibration. Only sums are stored, no frames.
/// Method: docs/method/calibration.md; symbols: docs/reference/frames.md. Thread: one at a time.
class Prologue {
 public:
  explicit Prologue(const sensor::Rig& rig);

  /// The orientations of one frame. `face`: one entry a face sensor, in the rig's order.
  struct Frame {
    DeviceTime time;                           ///< Reference sensor's clock.
    Quat q_world_ear;                          ///< R_h.
    Vec3 ear_rate_rad_s = Vec3::Zero();        ///< Bias removed, the ear sensor's axes.
    Vec3 ear_force_world_m_s2 = Vec3::Zero();  ///< Specific force, its fusion's world.
    bool ear_fresh = true;                     ///< Measured at this frame, not held over a gap.
    struct Face {
      bool present = false;
      bool fresh = true;                     ///< If present: measured at this frame, not held over a gap.
      Quat q_world_face;                     ///< R_i, its own fusion's world.
      Vec3 force_world_m_s2 = Vec3::Zero();  ///< Specific force, the same world.
      Vec3 rate_rad_s = Vec3::Zero();        ///< Bias removed, its own axes; for the detection of stillness.
    };
    std::vector<Face> face;
  };

  /// Each phase: begin, then its frames. begin_neutral() discards everything before it.
  void begin_neutral();
  void add_neutral(const Frame& frame);
  void begin_nod();
  void add_nod(const Frame& frame);
  void begin_shake();
  void add_shake(const Frame& frame);

  /// The calibration by the frames so far. Complete with a neutral hold and a nod in which the ear sensor was
  /// present; scores for the phases so far.
  [[nodiscard]] Calibration solve() const;

 private:
  struct Sway {
    Mat3 rate_square = Mat3::Zero();  // Sum of rate rate^T.
    std::size_t count = 0;
    double largest_rad = 0;  // Angle from neutral.
    void add(const Vec3& rate_rad_s, double angle_rad);
    [[nodiscard]] Vec3 axis() const;          // Principal axis of rotation; sign undetermined.
    [[nodiscard]] double axis_share() const;  // Share of the squared rate about that axis.
    [[nodiscard]] double rms_rad_s() const;
  };
  // Sums for the linear regression of a face sensor's vertical acceleration, less the ear's, on the head's
  // angular acceleration.
  struct Swing {
    std::size_t count = 0;
    double accel = 0;
    Vec3 turn = Vec3::Zero(), product = Vec3::Zero();
    Mat3 turn_square = Mat3::Zero();
    void add(double accel_m_s2, const Vec3& turn_rad_s2);
    // With, and of, the angular acceleration about `left`; times count.
    [[nodiscard]] double covariance(const Vec3& left) const;
    [[nodiscard]] double variance(const Vec3& left) const;
  };
  [[nodiscard]] Vec3 from_neutral(const Quat& q_world_ear) const;
  /// Mean lever arm of the face sensors ahead of the ear sensor, by that regression, m, for the head's left
  /// axis `left`; 0 where the nod is too slow for it.
  [[nodiscard]] double ahead_m(const Vec3& left) const;

  // The steps of solve(); each adds its scores. Axes are of the ear sensor.
  /// False: nothing was received.
  bool judge_hold(Calibration& out) const;
  /// From hold and nod together. Returns how far the face moved during the hold at most, rad.
  double find_headings(Calibration& out) const;
  /// The nod's level axis, as it began; none where there was no nod.
  std::optional<Vec3> judge_nod(const Vec3& up, Calibration& out) const;
  /// The head's left axis: which way along the nod's axis it points.
  Vec3 judge_direction(const Vec3& up, Vec3 left, Calibration& out) const;
  void judge_shake(const Vec3& up, Calibration& out) const;
  /// Each sensor's heading, and its acceleration at rest.
  void judge_sensors(Calibration& out) const;

  std::vector<std::string> names_;
  std::vector<std::optional<Vec3>> outward_;
  std::vector<HeadingSums> hold_;
  std::vector<HeadingSums> nod_;
  // Face less ear force over the hold: linear in cos and sin of the heading too, so it is averaged once Z is
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
  std::vector<Swing> swing_;  // Of the nod, by face sensor.
  struct Turning {
    DeviceTime time;  ///< Reference sensor's clock.
    Vec3 rate_rad_s;
  };
  std::optional<Turning> last_nod_;
  std::optional<Vec3> first_turn_;
};

}  // namespace mien::imu
