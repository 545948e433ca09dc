#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "mien/core/time.h"
#include "mien/imu/fusion.h"

namespace mien::imu {

/// One sample as a fusion takes it.
struct FusionInput {
  DeviceTime time;             ///< The sensor's own clock.
  std::uint32_t sequence = 0;  ///< Of its packet; wraps.
  bool fused = false;          ///< Of SampleKind::imu_fused, else imu_raw: the meaning of `values`.
  bool has_mag = false;
  bool time_estimated = false;
  std::array<float, 9> values{};
};

/// What integrating one sensor's samples, in the order of their times, has come to. A value type: a copy is a
/// snapshot.
struct Integration {
  Integration() = default;
  explicit Integration(const FusionSettings& settings) : fusion(settings) {}

  Fusion fusion;
  std::optional<DeviceTime> newest;  ///< Of the samples integrated.
  DeviceTime steady_since;           ///< Of the restart, or of the end of the last long gap.
  Duration step{};                   ///< Between the last two samples without a loss.
  std::uint64_t lost = 0;            ///< Samples that never came, by gaps in device time.
};

/// The newest samples of one sensor in the order of their times, and snapshots of their integration: a sample
/// that was overtaken is put in its place, and what came after it is integrated anew from the snapshot before
/// it. Reaches back by 56 samples at least (a quarter of a second at 240 Hz). No allocation.
class SampleHistory {
 public:
  static constexpr std::size_t kSize = 64;

  enum class Place : std::uint8_t {
    newest,    ///< After all others.
    late,      ///< Before some; integrate anew from before() it.
    rejected,  ///< Not kept: a duplicate, older than what can be integrated anew, or of a packet whose number
               ///< does not stand where its time does: another board's.
  };
  Place insert(const FusionInput& sample);
  /// The sample at the `i`th place from the oldest, i < size().
  [[nodiscard]] const FusionInput& operator[](std::size_t i) const { return samples_[(first_ + i) % kSize]; }
  [[nodiscard]] std::size_t size() const { return size_; }
  /// The place of the first sample later than `time`; size() where none is.
  [[nodiscard]] std::size_t first_after(DeviceTime time) const;
  /// Time of the newest sample; none before the first.
  [[nodiscard]] std::optional<DeviceTime> newest() const;

  /// The next sample was integrated, with this outcome: takes a snapshot every eighth time.
  void integrated(const Integration& now);
  /// The newest snapshot older than `time`; those after it are void. There is one for every `time` that
  /// insert() called late.
  const Integration& before(DeviceTime time);

  void clear();

 private:
  static constexpr std::size_t kEvery = 8;
  static constexpr std::size_t kSnapshots = kSize / kEvery + 1;
  [[nodiscard]] FusionInput& sample(std::size_t i) { return samples_[(first_ + i) % kSize]; }
  [[nodiscard]] const Integration& snapshot(std::size_t i) const {
    return snapshots_[(first_snapshot_ + i) % kSnapshots];
  }
  void drop_oldest();

  std::array<FusionInput, kSize> samples_{};
  std::size_t first_ = 0;
  std::size_t size_ = 0;
  std::array<Integration, kSnapshots> snapshots_{};
  std::size_t first_snapshot_ = 0;
  std::size_t snapshot_count_ = 0;
  std::size_t since_snapshot_ = 0;  // Samples integrated since the newest one.
};

}  // namespace mien::imu
