#pragma once

#include <cstdint>
#include <string>

#include "lab/bench/attack.h"
#include "lab/bench/attacked_session.h"
#include "lab/bench/hostile_camera.h"
#include "mien/core/error.h"
#include "mien/core/progress.h"

namespace mien::lab {

/// What sessions of cameras are attacked in.
struct CameraScene {
  std::string rig, model;  ///< Files.
  double seconds = 20;
  std::uint64_t seed = 1;
  Pictures pictures;  ///< What good cameras show.
};
/// `model` empty: the one of the rig. Errors: those of reading the rig; not_found (there is no model).
[[nodiscard]] Result<CameraScene> set_camera_scene(double seconds, const std::string& model,
                                                   std::uint64_t seed);

/// Runs `mien live` as a process of its own on three cameras of a headset, of which the second is hostile;
/// where there is no attack it is as good as the others. Figures are of `seconds` from two seconds after the
/// first picture on; `heard` are the good cameras' pictures that were accepted, the first's and the third's,
/// `sent` the hostile camera's bytes. What the second says is believed where it is a picture, as any
/// camera's is, and not counted. Errors: io (the session asks for no pictures, or did not end); internal (it
/// failed); cancelled.
[[nodiscard]] Result<AttackFigures> run_attacked_cameras(const CameraScene& scene, const Attack* attack,
                                                         const Progress& progress);

}  // namespace mien::lab
