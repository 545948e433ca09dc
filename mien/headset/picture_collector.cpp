#include "mien/headset/picture_collector.h"

namespace mien::headset {

void PictureCollector::begin(std::span<const std::byte> first, std::optional<std::size_t> length) {
  end();
  open_ = true;
  size_ = 0;
  length_ = length;
  walker_.begin();
  for (const std::byte byte : first) add(byte);
}

void PictureCollector::end() {
  if (!open_) return;
  open_ = false;
  ++(size_ > bytes_->size() ? counts_.overlong : counts_.broken);
}

bool PictureCollector::add(std::byte byte) {
  if (size_ < bytes_->size()) (*bytes_)[size_] = byte;
  ++size_;
  const JpegWalker::State state = walker_.add(byte);
  if (state == JpegWalker::State::inside && size_ != length_) return false;
  if (state != JpegWalker::State::whole || size_ > bytes_->size() || (length_ && size_ != *length_)) {
    end();
    return false;
  }
  open_ = false;
  ++counts_.whole;
  return true;
}

std::optional<std::uint64_t> PictureCollector::next(std::span<const std::byte>& bytes) {
  if (open_) {
    const std::size_t run = add_run(bytes);
    bytes = bytes.subspan(run);
    if (run > 0) newest_ = 0;  // No FF is in it.
  }
  if (bytes.empty()) return std::nullopt;
  newest_ = newest_ << 8U | std::to_integer<std::uint64_t>(bytes.front());
  bytes = bytes.subspan(1);
  return newest_;
}

void PictureCollector::restart() {
  end();
  newest_ = 0;
}

std::size_t PictureCollector::add_run(std::span<const std::byte> next) {
  std::size_t count = walker_.coded_run(next);
  if (length_) count = size_ < *length_ ? std::min(count, *length_ - size_ - 1) : 0;
  if (size_ < bytes_->size())
    std::ranges::copy(next.first(std::min(count, bytes_->size() - size_)), bytes_->begin() + size_);
  size_ += count;
  return count;
}

}  // namespace mien::headset
