#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/random.h"
#include "mien/core/rotation.h"
#include "mien/face/face.h"
#include "mien/sensor/rig.h"

namespace mien::virt {

/// Radius of the patch of skin that a sensor is glued to.
inline constexpr double kPatchRadiusM = 0.005;

/// How one patch of skin turns and moves with the weights. The least-squares rigid rotation of the patch
/// needs only the cross-covariance of its neutral and its moved points, and that is linear in the weights:
/// C(w) = C_0 + sum_k w_k C_k. Frame H (metres).
struct SkinSite {
  std::string sensor;
  Vec3 position_m = Vec3::Zero();                          ///< Patch centroid at neutral.
  Vec3 normal = Vec3::UnitZ();                             ///< Outward, unit.
  Mat3 covariance = Mat3::Identity();                      ///< C_0, m^2.
  std::array<Mat3, face::kShapeCount> shape_covariance{};  ///< C_k, m^2 per unit weight.
  std::array<Vec3, face::kShapeCount> shape_shift_m{};     ///< Centroid displacement per unit weight.

  /// E: the patch's rotation from the neutral B0, in the head frame.
  [[nodiscard]] Quat rotation(const face::BlendshapeWeights& weights) const;
  /// The patch's centroid.
  [[nodiscard]] Vec3 position(const face::BlendshapeWeights& weights) const;
};

/// The sites of every sensor of the rig, in its order, on this face. On the ICT mesh they stand at the rig's
/// vertices; on the built-in face at its own anatomical sites of the same names; on any other face at the
/// nearest point of the skin to the built-in face's sites after the 68 landmarks are aligned (rigid with
/// scale). `offset_m` (empty, or one a sensor) moves each site before it is projected to the skin again:
/// placement error. Errors: not_found (a face without landmarks that is neither ICT nor built-in; an unknown
/// site), mismatch.
[[nodiscard]] Result<std::vector<SkinSite>> skin_sites(const face::Face& face, const sensor::Rig& rig,
                                                       std::span<const Vec3> offset_m = {});

/// How each patch turns with each shape alone: its rotation vector (frame H, rad) at the weight `step`, a
/// unit of weight. Row 3 s + axis for site s, a column a shape.
[[nodiscard]] Eigen::MatrixXd rotation_slopes(std::span<const SkinSite> sites, float step);

/// Placement error for skin_sites: one offset a sensor, normal with `sigma_m` an axis.
[[nodiscard]] std::vector<Vec3> draw_placement(const sensor::Rig& rig, double sigma_m, Random random);

/// The same sites with the skin of each lying another way: turned about an axis of its own by an angle of
/// this standard deviation, so that every shape turns it about axes as far off.
[[nodiscard]] std::vector<SkinSite> draw_turns(const std::vector<SkinSite>& sites, double sigma_rad,
                                               Random random);

/// How much a drawn performer's skin differs from the mesh's own. What the training faces' sites do decides
/// more than which network is trained.
struct KinematicsSpread {
  double gain = 0.30;           ///< Standard deviation of each site's and shape's gain.
  double direction_rad = 0.26;  ///< 15 degrees: spread of the direction in which each shape moves each patch.
  /// The same people, each only by this share as unlike.
  [[nodiscard]] KinematicsSpread times(double share) const { return {share * gain, share * direction_rad}; }
  bool operator==(const KinematicsSpread&) const = default;
};

/// The same sites with every shape's effect drawn anew around what it was.
[[nodiscard]] std::vector<SkinSite> draw_kinematics(const std::vector<SkinSite>& sites,
                                                    const KinematicsSpread& spread, Random random);

}  // namespace mien::virt
