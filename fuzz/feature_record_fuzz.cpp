#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

#include "mien/headset/feature_record.h"

// What was accepted goes back to the same bytes.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  const auto record = mien::headset::parse_feature_record(bytes);
  if (!record) return 0;
  std::vector<float> features;
  for (std::size_t i = 0; i < record->count(); ++i) features.push_back(record->feature(i));
  std::vector<std::byte> again(size);
  const auto written = mien::headset::write_feature_record(*record, features, again);
  if (written != size || !std::ranges::equal(again, bytes)) std::abort();
  return 0;
}
