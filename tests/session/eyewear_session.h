#pragma once

#include <cmath>
#include <memory>
#include <vector>

#include "mien/builtin_face/builtin_face.h"
#include "mien/eyewear/eyewear_protocol.h"
#include "mien/eyewear/eyewear_tracker.h"
#include "mien/session/session.h"
#include "mien/virtual/eyewear/eyewear_simulator.h"
#include "mien/virtual/eyewear/worn_eyewear.h"
#include "mien/virtual/stage.h"
#include "tests/eyewear/glasses.h"
#include "tests/project_path.h"
#include "tests/virtual/three_sensors.h"

// Smart eyewear in a live session: a virtual wearer, and a regressor that can be checked by hand.
namespace mien::session::test {

inline const sensor::Rig& glasses() {
  static const sensor::Rig rig = sensor::read_rig(project_path("rigs/eyewear.toml")).value();
  return rig;
}

/// Glasses on the built-in face that neither sway nor slip, and skin without folds: what is left is the
/// board.
inline virt::EyewearFaults quiet_faults() {
  virt::EyewearFaults faults = virt::parse_eyewear_faults(glasses().faults_toml, "rig").value();
  faults.sway_mm = faults.sway_deg = faults.tissue_mm = faults.ride_up_mm = 0;
  faults.slip_mm_per_sqrt_min = faults.slip_deg_per_sqrt_min = 0;
  faults.mount_shift_mm = faults.mount_tilt_deg = 0;
  return faults;
}

inline const virt::EyewearWearer& wearer() {
  static const virt::EyewearWearer wearer =
      virt::seat_eyewear(builtin_face::make_builtin(), glasses(), quiet_faults(), Random(5)).value();
  return wearer;
}

/// The jaw from the lower hooks' light, as far as one that is open by three quarters changes it on this
/// wearer, and nothing else.
inline std::unique_ptr<eyewear::MarkerRegressor> jaw_regressor() {
  virt::EyewearSimulator simulator(wearer(), quiet_faults(), Random(1));
  face::BlendshapeWeights open;
  open[face::shape("jawOpen")] = 0.75F;
  const std::vector<double> rest = simulator.reflected({}), wide = simulator.reflected(open);
  const builtin_face::PlacedMarkers placed =
      builtin_face::PlacedMarkers::place(builtin_face::make_builtin(), eyewear::test::mouth_markers())
          .value();
  const Eigen::VectorXd moved_m = placed.at(open) - placed.at({});
  Eigen::MatrixXd gain_m = Eigen::MatrixXd::Zero(moved_m.size(), std::ssize(glasses().sensors));
  double square = 0;
  std::vector<double> change(rest.size());
  for (std::size_t s = 0; s < rest.size(); ++s)
    if (glasses().sensors[s].site == "lower_jaw") {
      change[s] = std::log(wide[s] / rest[s]) / eyewear::kUsualRange;
      square += change[s] * change[s];
    }
  for (std::size_t s = 0; s < rest.size(); ++s)
    gain_m.col(static_cast<Eigen::Index>(s)) = change[s] / square * moved_m;
  return std::make_unique<eyewear::test::LinearRegressor>(std::move(gain_m));
}

inline std::unique_ptr<Session> eyewear_session() {
  Session::Parts parts;
  parts.rig = glasses();
  parts.trackers.push_back(
      eyewear::EyewearTracker::create(glasses(), eyewear::test::marked_mouth(), jaw_regressor()).value());
  parts.protocols.push_back(
      std::make_unique<eyewear::EyewearProtocol>(eyewear::EyewearProtocol::create().value()));
  return Session::create(std::move(parts)).value();
}

/// A wearer who talks for `seconds` after a short prologue.
inline virt::VirtualSession worn_performance(double seconds) {
  virt::Stage stage;
  stage.rig = glasses();
  stage.worn = std::make_shared<virt::WornEyewear>(glasses(), quiet_faults(), wearer());
  stage.motion = performer::with_prologue(virt::test::talking(static_cast<int>(60 * seconds)),
                                          performer::PrologueKind::brief, Random(3));
  stage.devices = Random(11);
  return virt::play(stage).value();
}

}  // namespace mien::session::test
