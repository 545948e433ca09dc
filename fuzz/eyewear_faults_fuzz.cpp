#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "mien/core/random.h"
#include "mien/virtual/eyewear/eyewear_faults.h"
#include "mien/virtual/eyewear/photo_sensor.h"

/// A part with any faults that are accepted reads what is a share of full scale.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace mien;
  const auto faults =
      virt::parse_eyewear_faults(std::string_view(reinterpret_cast<const char*>(data), size), "input");
  if (!faults) return 0;
  virt::PhotoSensor part(*faults, Random(1));
  for (int i = 0; i < 20; ++i) {
    const double read = part.read(0.1 * i, 0.01 * i);
    if (!(read >= 0 && read <= 1)) std::abort();
    part.wait(0.01);
  }
  return 0;
}
