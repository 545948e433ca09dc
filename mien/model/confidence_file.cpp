#include "mien/model/confidence_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "mien/core/excerpt.h"

namespace mien::model {
namespace {

constexpr const char* kConfidence = "confidence";
constexpr const char* kCoverageEdges = "confidence.coverage_edges";
constexpr const char* kValueEdges = "confidence.value_edges";
constexpr const char* kExplained = "confidence.explained";
constexpr const char* kWithin = "confidence.within";

}  // namespace

void add_confidence(const ConfidenceTable& table, std::size_t shapes, TensorFile& to) {
  to.metadata[kConfidence] = nlohmann::json{
      {"tolerance", 0.1},
      {"measured_from", table.measured_from},
      {"people", table.people},
      {"seed", table.seed}}.dump();
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
  } catch (const nlohmann::json::exception& error) {
    return fail(ErrorCode::malformed,
                fmt::format("the model's description is wrong: {}", excerpt(error.what(), kComplaintLetters)),
                where);
  }
  const auto take = [&](const char* name, std::vector<float>& into) {
    const auto tensor = std::ranges::find(from.tensors, name, &Tensor::name);
    if (tensor == from.tensors.end()) return;
    into = std::move(tensor->values);
    from.tensors.erase(tensor);
  };
  take(kCoverageEdges, table.coverage_edges);
  take(kValueEdges, table.value_edges);
  take(kExplained, table.explained);
  take(kWithin, table.within);
  return table;
}

}  // namespace mien::model
