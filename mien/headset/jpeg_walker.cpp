#include "mien/headset/jpeg_walker.h"

#include <cstring>

#include "mien/headset/jpeg_marker.h"

namespace mien::headset {

JpegWalker::State JpegWalker::end_of_segment() {
  at_ = scan_ ? At::coded : At::mark;
  scanned_ = scanned_ || scan_;
  return State::inside;
}

JpegWalker::State JpegWalker::add(std::byte byte) {
  const auto go = [this](At next) {
    at_ = next;
    return State::inside;
  };
  switch (at_) {
    case At::first:
      return byte == jpeg::kMark ? go(At::second) : State::broken;
    case At::second:
      return byte == jpeg::kStartOfPicture ? go(At::mark) : State::broken;
    case At::mark:
      return byte == jpeg::kMark ? go(At::code) : State::broken;
    case At::coded:
      return byte == jpeg::kMark ? go(At::coded_mark) : State::inside;
    case At::coded_mark:
      if (byte == jpeg::kStuffed || jpeg::is_restart(byte)) return go(At::coded);
      [[fallthrough]];
    case At::code:
      if (byte == jpeg::kMark) return State::inside;  // Any number of them may stand before a code.
      // Before a scan's data it ends a picture that has none.
      if (byte == jpeg::kEndOfPicture) return scanned_ ? State::whole : State::broken;
      if (!jpeg::has_length(byte)) return State::broken;
      scan_ = byte == jpeg::kStartOfScan;
      return go(At::length_high);
    case At::length_high:
      left_ = std::to_integer<std::uint32_t>(byte) << 8U;
      return go(At::length_low);
    case At::length_low:
      left_ |= std::to_integer<std::uint32_t>(byte);
      if (left_ < 2) return State::broken;  // It counts itself.
      left_ -= 2;
      return left_ == 0 ? end_of_segment() : go(At::segment);
    case At::segment:
      --left_;
      return left_ == 0 ? end_of_segment() : State::inside;
  }
  return State::broken;
}

std::size_t JpegWalker::coded_run(std::span<const std::byte> next) const {
  if (at_ != At::coded || next.empty()) return 0;
  const void* const mark = std::memchr(next.data(), std::to_integer<int>(jpeg::kMark), next.size());
  return mark == nullptr ? next.size()
                         : static_cast<std::size_t>(static_cast<const std::byte*>(mark) - next.data());
}

}  // namespace mien::headset
