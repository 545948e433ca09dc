#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mien/core/bytes.h"
#include "mien/face/livelink_csv.h"

// Packets of Live Link Face, written here by the layout of docs/reference/phones.md alone.
namespace mien::phone::test {

struct LiveLinkFields {
  std::uint8_t version = 6;
  std::string device_id = "00000000-0000-0000-0000-000000000001";
  std::string subject = "face";
  std::int32_t frame = 100;
  float sub_frame = 0;
  std::pair<std::int32_t, std::int32_t> rate = {60, 1};
  std::optional<std::array<float, face::kLiveLinkValueCount>> values;  // None: the face is lost.
  bool counts_none = false;  // Without values a count of 0 is sent, else nothing.
};

inline std::vector<std::byte> live_link_bytes(const LiveLinkFields& fields) {
  ByteWriter writer;
  writer.big(fields.version);
  for (const std::string& text : {fields.device_id, fields.subject}) {
    writer.big(static_cast<std::int32_t>(text.size()));
    writer.append(text);
  }
  writer.big(fields.frame);
  writer.big(fields.sub_frame);
  writer.big(fields.rate.first);
  writer.big(fields.rate.second);
  if (fields.values) {
    writer.big(static_cast<std::uint8_t>(fields.values->size()));
    for (const float value : *fields.values) writer.big(value);
  } else if (fields.counts_none) {
    writer.big(std::uint8_t{0});
  }
  return writer.release();
}

}  // namespace mien::phone::test
