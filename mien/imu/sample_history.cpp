#include "mien/imu/sample_history.h"

namespace mien::imu {
namespace {

/// Whether packet numbers go on from one to the other, or are the same; they wrap.
bool in_order(std::uint32_t one, std::uint32_t other) {
  return static_cast<std::int32_t>(other - one) >= 0;
}

}  // namespace

std::optional<DeviceTime> SampleHistory::newest() const {
  if (size_ == 0) return std::nullopt;
  return (*this)[size_ - 1].time;
}

std::size_t SampleHistory::first_after(DeviceTime time) const {
  std::size_t place = size_;
  while (place > 0 && (*this)[place - 1].time > time) --place;
  return place;
}

void SampleHistory::drop_oldest() {
  const DeviceTime dropped = sample(0).time;
  first_ = (first_ + 1) % kSize;
  --size_;
  // Of what came after a snapshot all must be there.
  while (snapshot_count_ > 0 && *snapshot(0).newest < dropped) {
    first_snapshot_ = (first_snapshot_ + 1) % kSnapshots;
    --snapshot_count_;
  }
}

SampleHistory::Place SampleHistory::insert(const FusionInput& in) {
  if (size_ == kSize) drop_oldest();
  const std::size_t place = first_after(in.time);
  if (place < size_) {
    if (snapshot_count_ == 0 || *snapshot(0).newest >= in.time) return Place::rejected;
    if (!in_order(in.sequence, sample(place).sequence)) return Place::rejected;
  }
  if (place > 0 && sample(place - 1).time == in.time) return Place::rejected;
  if (place > 0 && place < size_ && !in_order(sample(place - 1).sequence, in.sequence))
    return Place::rejected;
  for (std::size_t i = size_; i > place; --i) sample(i) = sample(i - 1);
  sample(place) = in;
  ++size_;
  return place + 1 == size_ ? Place::newest : Place::late;
}

void SampleHistory::integrated(const Integration& now) {
  if (snapshot_count_ > 0 && ++since_snapshot_ < kEvery) return;
  since_snapshot_ = 0;
  if (snapshot_count_ == kSnapshots) {
    first_snapshot_ = (first_snapshot_ + 1) % kSnapshots;
    --snapshot_count_;
  }
  snapshots_[(first_snapshot_ + snapshot_count_) % kSnapshots] = now;
  ++snapshot_count_;
}

const Integration& SampleHistory::before(DeviceTime time) {
  while (snapshot_count_ > 1 && *snapshot(snapshot_count_ - 1).newest >= time) --snapshot_count_;
  since_snapshot_ = 0;
  return snapshot(snapshot_count_ - 1);
}

void SampleHistory::clear() {
  first_ = size_ = 0;
  first_snapshot_ = snapshot_count_ = since_snapshot_ = 0;
}

}  // namespace mien::imu
