#pragma once

#include "mien/builtin_face/markers.h"
#include "mien/eyewear/marker_network.h"
#include "mien/sensor/rig.h"
#include "tests/model/random_network.h"
#include "tests/project_path.h"

// What studies of glasses share: the rig, its markers, and a network.
namespace mien::lab::test {

inline const sensor::Rig& eyewear_rig() {
  static const sensor::Rig rig = sensor::read_rig(project_path("rigs/eyewear.toml")).value();
  return rig;
}

inline const builtin_face::MarkerSet& all_markers() {
  static const builtin_face::MarkerSet set =
      builtin_face::read_markers(project_path("rigs/markers.toml")).value();
  return set;
}

/// A network that has learnt nothing: what it answers is small and wrong.
inline eyewear::MarkerNetworkFile untrained() {
  eyewear::MarkerNetworkFile file;
  for (const sensor::Mount& mount : eyewear_rig().sensors) file.sensors.push_back(mount.name);
  for (const builtin_face::Marker& marker : all_markers().markers) file.markers.push_back(marker.name);
  file.architecture = model::named_architecture("causal", 2 * file.sensors.size()).value();
  file.architecture.layers = 1;
  file.architecture.d_model = 32;
  file.architecture.outputs = 3 * file.markers.size();
  file.scale_m = 0.001;
  file.network = model::random_network(file.architecture, 1);
  return file;
}

}  // namespace mien::lab::test
