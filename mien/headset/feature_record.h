#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "mien/core/bytes.h"
#include "mien/core/error.h"
#include "mien/headset/picture_statistics.h"

namespace mien::headset {

inline constexpr std::size_t kMostFeatures = 4096;  ///< Of one picture.
/// Largest size of a feature: beyond what any network finds, and far from where sums are no numbers.
inline constexpr float kMostFeature = 1e6F;

/// What is kept of a picture where the picture itself is not: how it was taken, and what a network found in
/// it. A payload of a take; layout, byte by byte, with a test vector: docs/reference/take.md. Refers to the
/// bytes that it was parsed from.
struct FeatureRecord {
  PictureStatistics statistics;
  std::uint32_t jpeg_bytes = 0;  ///< Length of the picture, 1 to sensor::kMaxPayload.
  /// The sensor of the rig for whose place the features were found; none: the picture's camera was bound to
  /// no sensor, and there are no features.
  std::optional<std::uint16_t> sensor;
  std::span<const std::byte>
      features;  ///< fp32, little-endian, to kMostFeature; at most kMostFeatures of them.

  [[nodiscard]] std::size_t count() const { return features.size() / sizeof(float); }
  /// Feature number `i`, below count().
  [[nodiscard]] float feature(std::size_t i) const {
    return ByteReader(features.subspan(i * sizeof(float))).little<float>();
  }
};

inline constexpr std::size_t kFeatureHeaderBytes = 48;

/// Whether the bytes begin like a record, and so unlike a JPEG; checks no more.
[[nodiscard]] bool is_feature_record(std::span<const std::byte> bytes);

/// Errors: truncated; malformed (magic, length, reserved bytes, features without a sensor or the other way
/// round); unsupported (version); out_of_range (numbers that are not finite or beyond what they can be). No
/// allocation but in errors. Thread-safe.
[[nodiscard]] Result<FeatureRecord> parse_feature_record(std::span<const std::byte> bytes);

/// Writes a record to the front of `out` and returns its length: feature_record_bytes(features.size()).
/// `features` are taken instead of the record's own. None where parse_feature_record would not take it, or
/// `out` is too short. No allocation. Thread-safe.
[[nodiscard]] std::optional<std::size_t> write_feature_record(const FeatureRecord& record,
                                                              std::span<const float> features,
                                                              std::span<std::byte> out);

[[nodiscard]] constexpr std::size_t feature_record_bytes(std::size_t features) {
  return kFeatureHeaderBytes + features * sizeof(float);
}

}  // namespace mien::headset
