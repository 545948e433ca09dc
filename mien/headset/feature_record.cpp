#include "mien/headset/feature_record.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "mien/sensor/payload.h"

namespace mien::headset {
namespace {

constexpr std::string_view kFeatureMagic = "MNFR";
constexpr std::uint8_t kFeatureVersion = 1;
constexpr std::uint16_t kNoSensor = 0xFFFF;
constexpr std::uint16_t kMostSensors = 256;  // Of a rig.
const char* const kFeatureRecord = "a picture's features";

bool is_share(float value) {
  return value >= 0 && value <= 1;
}

bool is_sound(const PictureStatistics& statistics) {
  return is_share(statistics.mean) && is_share(statistics.saturated) && is_share(statistics.black) &&
         statistics.sharpness >= 0 && std::isfinite(statistics.sharpness) && is_share(statistics.p2) &&
         is_share(statistics.p98);
}

/// What is said of the numbers that stand before the features.
bool is_sound(const FeatureRecord& record) {
  return is_sound(record.statistics) && record.jpeg_bytes >= 1 && record.jpeg_bytes <= sensor::kMaxPayload &&
         (!record.sensor || *record.sensor < kMostSensors);
}

/// Numbers in a row, little-endian.
class RecordWriter {
 public:
  explicit RecordWriter(std::span<std::byte> out) : out_(out) {}
  template <class T>
  void put(T value) {
    auto raw = std::bit_cast<std::array<std::byte, sizeof(T)>>(value);
    if constexpr (std::endian::native != std::endian::little) std::ranges::reverse(raw);
    std::ranges::copy(raw, out_.begin());
    out_ = out_.subspan(raw.size());
  }

 private:
  std::span<std::byte> out_;
};

}  // namespace

bool is_feature_record(std::span<const std::byte> bytes) {
  return as_text(bytes).starts_with(kFeatureMagic);
}

Result<FeatureRecord> parse_feature_record(std::span<const std::byte> bytes) {
  if (bytes.size() < kFeatureHeaderBytes)
    return fail(ErrorCode::truncated, fmt::format("{} bytes are no header", bytes.size()), kFeatureRecord);
  if (!is_feature_record(bytes)) return fail(ErrorCode::malformed, "it begins otherwise", kFeatureRecord);
  ByteReader reader(bytes.subspan(kFeatureMagic.size()));
  if (const auto version = reader.little<std::uint8_t>(); version != kFeatureVersion)
    return fail(ErrorCode::unsupported, fmt::format("version {}, not {}", version, kFeatureVersion),
                kFeatureRecord, "update the program");
  const auto reserved = reader.little<std::uint8_t>();
  const auto sensor = reader.little<std::uint16_t>();
  const auto count = reader.little<std::uint32_t>();
  FeatureRecord record;
  record.jpeg_bytes = reader.little<std::uint32_t>();
  PictureStatistics& statistics = record.statistics;
  for (float* value : {&statistics.mean, &statistics.saturated, &statistics.black, &statistics.sharpness,
                       &statistics.p2, &statistics.p98})
    *value = reader.little<float>();
  statistics.hash = reader.little<std::uint64_t>();
  if (sensor != kNoSensor) record.sensor = sensor;
  if (reserved != 0) return fail(ErrorCode::malformed, "a reserved bit is set", kFeatureRecord);
  if (count > kMostFeatures || bytes.size() != feature_record_bytes(count))
    return fail(ErrorCode::malformed, fmt::format("{} bytes for {} features", bytes.size(), count),
                kFeatureRecord);
  if (record.sensor.has_value() != (count > 0))
    return fail(ErrorCode::malformed, "features of no camera, or a camera without", kFeatureRecord);
  if (!is_sound(record)) return fail(ErrorCode::out_of_range, "a number that no picture has", kFeatureRecord);
  record.features = bytes.subspan(kFeatureHeaderBytes);
  for (std::size_t i = 0; i < count; ++i)
    if (!(std::abs(record.feature(i)) <= kMostFeature))
      return fail(ErrorCode::out_of_range, "a feature that no network finds", kFeatureRecord);
  return record;
}

std::optional<std::size_t> write_feature_record(const FeatureRecord& record, std::span<const float> features,
                                                std::span<std::byte> out) {
  const std::size_t bytes = feature_record_bytes(features.size());
  if (features.size() > kMostFeatures || out.size() < bytes || !is_sound(record) ||
      record.sensor.has_value() == features.empty() ||
      !std::ranges::all_of(features, [](float value) { return std::abs(value) <= kMostFeature; }))
    return std::nullopt;
  std::ranges::copy(std::as_bytes(std::span(kFeatureMagic)), out.begin());
  RecordWriter writer(out.subspan(kFeatureMagic.size()));
  writer.put(kFeatureVersion);
  writer.put(std::uint8_t{0});
  writer.put(record.sensor.value_or(kNoSensor));
  writer.put(static_cast<std::uint32_t>(features.size()));
  writer.put(record.jpeg_bytes);
  const PictureStatistics& statistics = record.statistics;
  for (const float value : {statistics.mean, statistics.saturated, statistics.black, statistics.sharpness,
                            statistics.p2, statistics.p98})
    writer.put(value);
  writer.put(statistics.hash);
  for (const float value : features) writer.put(value);
  return bytes;
}

}  // namespace mien::headset
