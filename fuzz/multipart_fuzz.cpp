#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

#include "mien/headset/multipart.h"
#include "mien/sensor/payload.h"

namespace {

using mien::headset::MultipartReader;

struct Found {
  std::vector<std::byte> jpeg;
  std::optional<mien::DeviceTime> time;
  bool operator==(const Found&) const = default;
};

std::vector<Found> found(std::span<const std::byte> bytes, std::size_t piece) {
  static MultipartReader reader;  // Of 256 KiB; a restart leaves nothing of the run before.
  reader.restart();
  const auto before = reader.counts();
  std::vector<Found> all;
  while (!bytes.empty()) {
    auto some = bytes.first(std::min(piece, bytes.size()));
    bytes = bytes.subspan(some.size());
    while (const auto picture = reader.read(some))
      all.push_back({{picture->jpeg.begin(), picture->jpeg.end()}, picture->time});
  }
  if (reader.counts().whole - before.whole != all.size()) std::abort();
  return all;
}

}  // namespace

// A picture is part of the stream, has its beginning and its end, and is the same however the stream is cut.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  const std::vector<Found> all = found(bytes, size);
  auto from = bytes.begin();
  for (const Found& one : all) {
    if (one.jpeg.size() < 4 || one.jpeg.size() > mien::sensor::kMaxPayload) std::abort();
    if (one.jpeg[1] != std::byte{0xD8} || one.jpeg.back() != std::byte{0xD9}) std::abort();
    const auto place = std::search(from, bytes.end(), one.jpeg.begin(), one.jpeg.end());
    if (place == bytes.end()) std::abort();
    from = place + static_cast<std::ptrdiff_t>(one.jpeg.size());
    if (one.time && (one.time->time_since_epoch().count() < 0 ||
                     one.time->time_since_epoch() > std::chrono::hours(27778)))
      std::abort();
  }
  if (size > 0 && found(bytes, 1 + data[0] % 7) != all) std::abort();
  return 0;
}
