#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "mien/core/rotation.h"
#include "mien/face/output_frame.h"

namespace mien::sink {

/// The first message of a connection (docs/reference/page_protocol.md). Members without a value are left out:
/// the ws sink knows no rig.
struct Hello {
  struct Sensor {
    std::string name;
    std::string kind;
    std::string site;
    std::string side;                ///< "L", "R" or "M".
    std::string role;                ///< "face" or "head".
    std::optional<Vec3> position_m;  ///< On the built-in face's neutral, frame H.
    std::optional<Vec3> aim;         ///< Which way it looks (unit), frame H; left out where it has none.
  };
  struct Rig {
    std::string name;
    std::vector<Sensor> sensors;
  };
  std::string software;  ///< "mien 0.1.0".
  std::optional<Rig> rig;
  std::optional<std::string> face;   ///< "/face.glb".
  std::optional<std::string> model;  ///< Name of the live model.
  std::optional<std::string> mode;   ///< "live" or "replay".
  std::optional<std::vector<std::string>> listening;
};
/// One JSON object, without a line end. Text that is not UTF-8 has its broken parts replaced.
[[nodiscard]] std::string hello_json(const Hello& hello);

/// A frame's message. `truth`, where known, has one weight a shape. Weights, confidence and angles have five
/// significant digits, time nine decimals; a number that is not finite is sent as 0. Replaces `out`, and
/// allocates only while it grows.
void write_frame_json(const face::OutputFrame& frame, std::int64_t frame_index,
                      const face::BlendshapeWeights* truth, std::string& out);

}  // namespace mien::sink
