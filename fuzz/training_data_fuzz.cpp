#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "mien/synthetic/imu/dataset_file.h"

/// Whatever is read can be written, and is read the same: in the same bytes.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace mien::synthetic;
  const std::span bytes(reinterpret_cast<const std::byte*>(data), size);
  const auto read = parse_training_data(bytes, "input");
  if (!read) return 0;
  const auto written = format_training_data(*read);
  const auto again = parse_training_data(written, "output");
  if (!again || format_training_data(*again) != written) std::abort();
  return 0;
}
