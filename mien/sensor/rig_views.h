#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "mien/core/error.h"
#include "mien/sensor/picture_view.h"

namespace mien::sensor {

/// How a camera of a rig is to see.
struct SensorView {
  std::string sensor;  ///< Its name in the rig.
  PictureView view;    ///< As check_crop and check_turn take it.
};

/// The text of a rig file with these views in it; what else it has stays as it is, comments and all. Errors:
/// parse_rig's; not_found (no camera of that name); unsupported (a camera that is written otherwise than
/// under a heading of its own, [sensor.camera]); internal (what came out would not be read back as that rig).
[[nodiscard]] Result<std::string> with_views(std::string_view toml, std::span<const SensorView> views,
                                             const std::string& where);

/// The same in a file, which is replaced at once or left as it is (write_file). Errors: read_text's,
/// with_views', write_file's.
[[nodiscard]] Result<void> write_views(const std::filesystem::path& rig, std::span<const SensorView> views);

}  // namespace mien::sensor
