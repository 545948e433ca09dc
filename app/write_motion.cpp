#include "app/write_motion.h"

#include "app/gltf_option.h"
#include "mien/core/files.h"
#include "mien/face/livelink_csv.h"

namespace mien::app {

face::Motion motion_of(std::span<const face::OutputFrame> frames) {
  face::Motion motion;
  motion.name = "capture";
  motion.frames.reserve(frames.size());
  for (const face::OutputFrame& frame : frames) {
    face::MotionFrame out;
    out.time_s = to_seconds(frame.time - frames.front().time);
    out.weights = frame.weights;
    out.head = frame.head;
    motion.frames.push_back(out);
    motion.has_head = motion.has_head || frame.head_confidence > 0;
  }
  return motion;
}

Result<void> check_motion_output(const std::filesystem::path& path) {
  return check_gltf_output(path, render::GltfNames::ict, ".csv");
}

Result<void> write_motion(const face::Motion& motion, const std::string& face,
                          const std::filesystem::path& path, render::GltfNames names,
                          const std::string& textures) {
  MIEN_TRY(check_gltf_output(path, names, ".csv"));
  if (path.extension() == ".csv") return write_file(path, face::format_livelink_csv(motion));
  MIEN_TRY_ASSIGN(const TexturedFace model, textured_face(face, textures));
  return render::write_gltf(path, model.face, &motion, names, model.textures);
}

}  // namespace mien::app
