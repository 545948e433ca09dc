#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "mien/sensor/payload_stream.h"

namespace mien::live {

/// How a camera's connection is.
struct CameraStatus {
  std::string address;      ///< "http://192.168.1.7:81/stream", "serial:/dev/ttyACM0".
  std::string sensor;       ///< Whose pictures they are, as the rig names it.
  bool open = false;        ///< Pictures come.
  std::string problem;      ///< Why they do not; empty while they do, and before anything is known.
  std::uint64_t lost = 0;   ///< Times that they had come and ended.
  std::uint64_t bytes = 0;  ///< Read.
  sensor::StreamCounts pictures;
  std::vector<sensor::Refusal> refusals;  ///< Of pictures.refused, the most frequent reason first.
  std::uint64_t too_fast = 0;   ///< Whole pictures that were not handed on: more than a camera's rate.
  std::uint64_t held_back = 0;  ///< Times that it was read later, since it sent more bytes than a camera.
};

}  // namespace mien::live
