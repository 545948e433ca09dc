#pragma once

#include <cstdint>
#include <string>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/render/image.h"
#include "mien/sensor/rig.h"

namespace mien::lab {

/// A picture of what a virtual headset's cameras see, for people.
struct ContactSheetRequest {
  int wearers = 6;         ///< A row each.
  std::uint64_t seed = 1;  ///< Of the wearers and their headsets.
  int side = 120;          ///< Pixels of a view either way.
  bool failures = false;   ///< A row a failure instead, on wearers in turn, of the face at rest.
  std::string font;        ///< File to write headings with; empty: no headings.
};

/// Views of all cameras, side by side, of a face at rest, with closed eyes, a smile, an open jaw and a
/// tongue. Errors: bad_usage (no wearers, or a side that is no picture's), those of the wearers and of the
/// font.
[[nodiscard]] Result<render::Image> headset_contact_sheet(const ContactSheetRequest& request,
                                                          const sensor::Rig& rig, const Progress& progress);

}  // namespace mien::lab
