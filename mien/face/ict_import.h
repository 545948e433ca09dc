#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/face/face.h"

namespace mien::face {

/// One direction in which ICT-FaceKit's heads differ from each other; coefficients are drawn from N(0, 1).
struct IctIdentity {
  std::string name;            ///< "identity000" to "identity099".
  std::vector<Vec3f> delta_m;  ///< Beside Face::neutral_m.
};

/// An ICT-FaceKit Light folder.
struct IctModel {
  Face face;  ///< The generic neutral and its 53 expressions; named "ict".
  std::vector<IctIdentity> identities;
};

struct IctOptions {
  bool identities = false;  ///< Read them too: 32 MB and, uncached, two thirds of the time.
  bool cache = true;  ///< Keep what was read as one binary file, and use it while the folder is unchanged.
  std::filesystem::path cache_folder;  ///< Empty: $XDG_CACHE_HOME/mien, else ~/.cache/mien.
};

/// Reads a folder with generic_neutral_mesh.obj and the 53 expression meshes (centimetres, quads) into a Face
/// (metres, triangles), with ICT-FaceKit Light's own parts, regions, eyeballs and landmarks. The landmarks,
/// and the region "rigid", are vertex_indices.json's where it is there. A cache that is missing, stale,
/// damaged or of another version is rebuilt, and where it cannot be written the import goes on without.
/// Errors: not_found (a mesh), malformed, out_of_range, mismatch (another topology), cancelled.
/// Threads: one a core at most; `progress` is called from the calling thread only.
/// Source: ICT-FaceKit (MIT), README and FaceXModel.
[[nodiscard]] Result<IctModel> import_ict_model(const std::filesystem::path& folder,
                                                const IctOptions& options,
                                                const Progress& progress = no_progress);
/// The same without identities, cached.
[[nodiscard]] Result<Face> import_ict(const std::filesystem::path& folder,
                                      const Progress& progress = no_progress);

/// Another person: the neutral moved by sum c_i identity_i (missing coefficients are 0), eyes with it.
/// Expressions stay as they are.
[[nodiscard]] Face with_identity(const IctModel& model, std::span<const float> coefficients);

}  // namespace mien::face
