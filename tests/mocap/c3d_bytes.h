#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/bytes.h"

namespace mien::mocap {

/// A C3D file of one's choice, as the tests of its reader want it.
struct C3dFile {
  bool floats = true;
  std::uint8_t processor = 84;
  std::vector<std::string> labels = {"tip", "chin_L"};
  std::string units = "mm";
  float rate_hz = 100;
  std::uint16_t analogue = 3;     ///< Values a frame, passed over.
  std::int32_t frames_said = -1;  ///< -1: the truth.
  /// Frame by frame: x, y, z and residual of each point.
  std::vector<float> values;

  [[nodiscard]] std::vector<std::byte> bytes() const {
    ByteWriter parameters;
    const auto name = [&](std::string_view text, std::int8_t id) {
      parameters.little(static_cast<std::int8_t>(text.size()));
      parameters.little(id);
      parameters.append(text);
    };
    parameters.little(std::uint8_t{1});
    parameters.little(std::uint8_t{0x50});
    parameters.little(std::uint8_t{1});
    parameters.little(processor);
    // The group stands behind some of its parameters: both orders are allowed.
    const auto number = [&](std::string_view text, auto value, std::int8_t type) {
      name(text, 1);
      parameters.little(static_cast<std::uint16_t>(2 + 2 + sizeof(value) + 1));
      parameters.little(type);
      parameters.little(std::uint8_t{0});
      parameters.little(value);
      parameters.little(std::uint8_t{0});
    };
    const std::size_t frame = 4 * labels.size();
    const std::size_t frames = values.size() / frame;
    number("USED", static_cast<std::uint16_t>(labels.size()), 2);
    number("SCALE", floats ? -0.5F : 0.5F, 4);
    name("POINT", -1);
    parameters.little(std::uint16_t{2 + 1});
    parameters.little(std::uint8_t{0});
    number("RATE", rate_hz, 4);
    number("DATA_START", std::uint16_t{3}, 2);
    number("FRAMES",
           static_cast<std::uint16_t>(frames_said < 0 ? static_cast<std::int32_t>(frames) : frames_said), 2);
    constexpr std::size_t kWidth = 8;
    name("LABELS", 1);
    parameters.little(static_cast<std::uint16_t>(2 + 2 + 2 + kWidth * labels.size() + 1));
    parameters.little(std::int8_t{-1});
    parameters.little(std::uint8_t{2});
    parameters.little(static_cast<std::uint8_t>(kWidth));
    parameters.little(static_cast<std::uint8_t>(labels.size()));
    for (const std::string& label : labels)
      parameters.append((label + std::string(kWidth, ' ')).substr(0, kWidth));
    parameters.little(std::uint8_t{0});
    name("UNITS", 1);
    parameters.little(std::uint16_t{0});  // The last.
    parameters.little(std::int8_t{-1});
    parameters.little(std::uint8_t{1});
    parameters.little(static_cast<std::uint8_t>(units.size()));
    parameters.append(units);
    parameters.little(std::uint8_t{0});

    ByteWriter file;
    file.little(std::uint8_t{2});
    file.little(std::uint8_t{0x50});
    file.little(static_cast<std::uint16_t>(labels.size()));
    file.little(analogue);
    const auto pad = [](ByteWriter& writer) {
      while (writer.bytes().size() % 512 != 0) writer.little(std::uint8_t{0});
    };
    pad(file);
    pad(parameters);
    file.append(parameters.bytes());
    for (std::size_t f = 0; f < frames; ++f) {
      for (std::size_t i = 0; i < frame; ++i)
        if (floats)
          file.little(values[f * frame + i]);
        else
          file.little(static_cast<std::int16_t>(values[f * frame + i]));
      for (std::uint16_t a = 0; a < analogue; ++a)
        if (floats)
          file.little(7.0F);
        else
          file.little(std::int16_t{7});
    }
    pad(file);
    return file.release();
  }
};

}  // namespace mien::mocap
