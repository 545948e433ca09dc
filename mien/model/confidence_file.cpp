#include "mien/model/confidence_file.h"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "mien/face/shape_region.h"
#include "mien/model/network_parts.h"

namespace mien::model {
namespace {

constexpr const char* kConfidence = "confidence";
constexpr const char* kCoverageEdges = "confidence.coverage_edges";
constexpr const char* kValueEdges = "confidence.value_edges";
constexpr const char* kExplained = "confidence.explained";
constexpr const char* kWithin = "confidence.within";

/// By the regions' names, so that another set of them is not taken for this one.
nlohmann::json to_json(const RegionMaps& maps) {
  nlohmann::json out = nlohmann::json::object();
  for (std::size_t r = 0; r < maps.size(); ++r)
    out[std::string(face::kShapeRegionNames[r])] = {maps[r].offset, maps[r].slope};
  return out;
}

/// Beyond a map's range it is no number, which check() refuses: not every double is a float.
float parameter_of(const nlohmann::json& json) {
  const auto value = json.get<double>();
  return std::abs(value) <= LogisticMap::kLargest ? static_cast<float>(value)
                                                  : std::numeric_limits<float>::quiet_NaN();
}

/// Throws nlohmann's exceptions. None: they are not the five regions' two numbers each.
std::optional<RegionMaps> parse_regions(const nlohmann::json& json) {
  if (!json.is_object() || json.size() != face::kShapeRegionCount) return std::nullopt;
  RegionMaps maps;
  for (std::size_t r = 0; r < maps.size(); ++r) {
    const nlohmann::json& map = json.at(std::string(face::kShapeRegionNames[r]));
    if (!map.is_array() || map.size() != 2) return std::nullopt;
    maps[r] = {parameter_of(map[0]), parameter_of(map[1])};
  }
  return maps;
}

}  // namespace

void add_confidence(const ConfidenceTable& table, std::size_t shapes, TensorFile& to) {
  nlohmann::json json = {{"tolerance", 0.1},
                         {"measured_from", table.measured_from},
                         {"people", table.people},
                         {"seed", table.seed}};
  if (table.regions) json["regions"] = to_json(*table.regions);
  to.metadata[kConfidence] = json.dump();
  const auto add = [&](const char* name, std::vector<std::size_t> shape, const std::vector<float>& values) {
    to.tensors.push_back({.name = name, .shape = std::move(shape), .values = values});
  };
  add(kCoverageEdges, {table.coverage_edges.size()}, table.coverage_edges);
  add(kValueEdges, {table.value_edges.size()}, table.value_edges);
  add(kExplained, {shapes, table.coverage_bins()}, table.explained);
  add(kWithin, {shapes, table.coverage_bins(), table.value_bins()}, table.within);
}

Result<std::optional<ConfidenceTable>> take_confidence(TensorFile& from, const std::string& where) {
  const auto found = from.metadata.find(kConfidence);
  if (found == from.metadata.end()) return std::nullopt;
  ConfidenceTable table;
  try {
    const nlohmann::json json = nlohmann::json::parse(found->second);
    table.measured_from = json.at("measured_from").get<float>();
    table.people = json.at("people").get<std::size_t>();
    table.seed = json.at("seed").get<std::uint64_t>();
    if (const auto regions = json.find("regions"); regions != json.end()) {
      table.regions = parse_regions(*regions);
      if (!table.regions)
        return fail(ErrorCode::malformed, "the confidence of regions is not two numbers of each", where);
    }
  } catch (const nlohmann::json::exception& error) {
    return wrong_description(error, where);
  }
  const auto take = [&](const char* name, std::vector<float>& into) {
    if (auto values = take_tensor(name, from)) into = *std::move(values);
  };
  take(kCoverageEdges, table.coverage_edges);
  take(kValueEdges, table.value_edges);
  take(kExplained, table.explained);
  take(kWithin, table.within);
  return table;
}

}  // namespace mien::model
