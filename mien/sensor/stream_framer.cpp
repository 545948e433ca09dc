#include "mien/sensor/stream_framer.h"

namespace mien::sensor {
namespace {

constexpr std::byte kZero{0};
constexpr std::byte kNewline{'\n'};
constexpr std::byte kReturn{'\r'};

bool is_printable(std::byte byte) {
  return (byte >= std::byte{0x20} && byte <= std::byte{0x7E}) || byte == std::byte{'\t'} || byte == kReturn;
}

}  // namespace

std::span<const std::byte> StreamFramer::add(std::byte byte) {
  if (byte == kZero) return end(false);
  // Noise that held a zero is no reason to wait for another, where text follows.
  if (byte == kNewline && (after_line_ || too_long_ || (printable_ && size_ > 0))) return end(true);
  printable_ = printable_ && (is_printable(byte) || (byte == kNewline && size_ == 0));
  if (size_ < frame_.size())
    frame_[size_++] = byte;
  else
    too_long_ = true;
  return {};
}

std::span<const std::byte> StreamFramer::end(bool newline) {
  auto frame = std::span<const std::byte>(frame_).first(size_);
  if (newline && !frame.empty() && frame.front() == kNewline) frame = frame.subspan(1);
  if (newline && !frame.empty() && frame.back() == kReturn) frame = frame.first(frame.size() - 1);
  const bool dropped = too_long_;
  if (dropped) ++overlong_;
  size_ = 0;
  too_long_ = false;
  printable_ = true;
  after_line_ = newline;
  return dropped ? std::span<const std::byte>() : frame;
}

void StreamFramer::restart() {
  size_ = 0;
  too_long_ = false;
  printable_ = true;
  after_line_ = false;
}

}  // namespace mien::sensor
