#include "mien/core/cobs.h"

#include <algorithm>

namespace mien {
namespace {

constexpr std::size_t kFullRun = 254;
constexpr std::byte kZero{0};

const char* const kWhere = "COBS frame";

}  // namespace

void cobs_encode(std::span<const std::byte> bytes, std::vector<std::byte>& out) {
  while (true) {
    const auto room = bytes.first(std::min(bytes.size(), kFullRun));
    const auto run = static_cast<std::size_t>(std::ranges::find(room, kZero) - room.begin());
    out.push_back(static_cast<std::byte>(run + 1));
    out.insert(out.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(run));
    bytes = bytes.subspan(run);
    // A full run has no zero of its own: where it ends the data, the frame ends too.
    if (bytes.empty()) return;
    if (run < kFullRun) bytes = bytes.subspan(1);
  }
}

Result<std::span<const std::byte>> cobs_decode(std::span<const std::byte> frame, std::span<std::byte> out) {
  if (frame.empty()) return fail(ErrorCode::truncated, "no bytes", kWhere);
  std::size_t size = 0;
  while (true) {
    const auto code = std::to_integer<std::size_t>(frame.front());
    if (code == 0) return fail(ErrorCode::malformed, "a zero inside", kWhere);
    const std::size_t run = code - 1;
    frame = frame.subspan(1);
    if (run > frame.size()) return fail(ErrorCode::truncated, "a run goes past the end", kWhere);
    if (run > out.size() - size) return fail(ErrorCode::out_of_range, "more than there is room for", kWhere);
    const auto bytes = frame.first(run);
    if (std::ranges::find(bytes, kZero) != bytes.end())
      return fail(ErrorCode::malformed, "a zero inside", kWhere);
    std::ranges::copy(bytes, out.begin() + static_cast<std::ptrdiff_t>(size));
    size += run;
    frame = frame.subspan(run);
    if (frame.empty()) return out.first(size);
    if (run == kFullRun) continue;
    if (size == out.size()) return fail(ErrorCode::out_of_range, "more than there is room for", kWhere);
    out[size++] = kZero;
  }
}

}  // namespace mien
