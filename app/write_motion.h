#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "mien/core/error.h"
#include "mien/face/motion.h"
#include "mien/face/output_frame.h"
#include "mien/render/gltf_export.h"

namespace mien::app {

/// Output frames as a motion, from the first frame's time.
[[nodiscard]] face::Motion motion_of(std::span<const face::OutputFrame> frames);

/// Whether write_motion() can write there (check_output): to be asked before long work.
[[nodiscard]] Result<void> check_motion_output(const std::filesystem::path& path);

/// Writes a motion in the format of the file's ending: .csv (Live Link Face), .glb, .gltf or .vrm (on the
/// face that `face` names, known to receivers by `names`, with `textures` as textured_face has them). Errors:
/// bad_usage for another ending, and the writers'.
[[nodiscard]] Result<void> write_motion(const face::Motion& motion, const std::string& face,
                                        const std::filesystem::path& path,
                                        render::GltfNames names = render::GltfNames::ict,
                                        const std::string& textures = {});

}  // namespace mien::app
