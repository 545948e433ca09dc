#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "mien/sink/vrchat.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto avatar =
      mien::sink::parse_vrchat_avatar(std::string_view(reinterpret_cast<const char*>(data), size), "input");
  if (!avatar) return 0;
  auto encoder = mien::sink::VrchatEncoder::make({}, *avatar);
  if (!encoder) return 0;
  // Whatever an avatar declares can be written, in packets that are small enough and that end on a word.
  mien::sink::ArkitFrame frame;
  frame.weights.values.fill(0.7F);
  frame.eyes_tracked = frame.face_tracked = true;
  mien::sink::Datagrams out;
  encoder->encode(frame, 0, out);
  for (std::size_t i = 0; i < out.size(); ++i)
    if (out[i].size() > 1400 || out[i].size() % 4 != 0 || out[i].empty()) std::abort();
  out.clear();
  encoder->encode(frame, 1, out);
  if (out.size() != 0) std::abort();  // Nothing has changed.
  return 0;
}
