#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "mien/eyewear/marker_network.h"

/// Whatever passes as a model of smart eyewear can be written again and run.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace mien::eyewear;
  const auto file = parse_marker_network(std::span(reinterpret_cast<const std::byte*>(data), size), "input");
  if (!file) return 0;
  if (!format_marker_network(*file)) std::abort();
  const auto regressor = NetworkRegressor::create(*file, file->sensors);
  if (!regressor) std::abort();
  Eigen::VectorXd displacement_m;
  const LightFrame light{.values = std::vector<float>(file->sensors.size(), 0.5F),
                         .present = std::vector<std::uint8_t>(file->sensors.size(), 1)};
  (*regressor)->step(light, displacement_m);
  if (displacement_m.size() != static_cast<Eigen::Index>(3 * file->markers.size())) std::abort();
  return 0;
}
