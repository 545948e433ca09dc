#include "mien/shaping/resting_face.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "mien/core/excerpt.h"

namespace mien::shaping {
namespace {

using nlohmann::json;

Result<void> read_values(const json& table, std::string_view key, const std::string& where,
                         std::array<float, face::kShapeCount>& out) {
  if (!table.is_object())
    return fail(ErrorCode::malformed, fmt::format("'{}' is no table of shapes", key), where);
  for (const auto& [name, value] : table.items()) {
    const std::size_t i = face::shape_index(name);
    if (i == face::kShapeCount)
      return fail(ErrorCode::malformed, fmt::format("no shape is called '{}'", excerpt(name)), where);
    if (!value.is_number())
      return fail(ErrorCode::malformed, fmt::format("the {} of {} is not a number", key, name), where);
    out[i] = value.get<float>();
  }
  return {};
}

}  // namespace

float RestingFace::applied(std::size_t shape, float weight) const {
  if (!changes(shape)) return weight;
  return std::clamp((weight - rest[shape]) / (full[shape] - rest[shape]), 0.0F, 1.0F);
}

RestingFace RestingFace::within_range() const {
  RestingFace out;
  for (std::size_t i = 0; i < face::kShapeCount; ++i) {
    if (kRestingRules[i] == RestingRule::none) continue;
    if (std::isfinite(rest[i])) out.rest[i] = std::clamp(rest[i], 0.0F, kRestAtMost);
    if (kRestingRules[i] == RestingRule::lids && std::isfinite(full[i]))
      out.full[i] = std::clamp(full[i], out.rest[i] + kLeastRange, 1.0F);
  }
  return out;
}

std::string write_resting_face(const RestingFace& face) {
  json rest = json::object();
  json full = json::object();
  for (std::size_t i = 0; i < face::kShapeCount; ++i) {
    const std::string name(face::kShapeNames[i]);
    if (face.rest[i] != 0) rest[name] = face.rest[i];
    if (face.full[i] != 1) full[name] = face.full[i];
  }
  return json{{"rest", std::move(rest)}, {"full", std::move(full)}}.dump();
}

Result<RestingFace> parse_resting_face(std::string_view text, const std::string& where) {
  const json root = json::parse(text, nullptr, false);
  if (!root.is_object()) return fail(ErrorCode::malformed, "not a JSON object", where);
  RestingFace face;
  for (const auto& [key, value] : root.items()) {
    if (key == "rest") {
      MIEN_TRY(read_values(value, key, where, face.rest));
    } else if (key == "full") {
      MIEN_TRY(read_values(value, key, where, face.full));
    } else {
      return fail(ErrorCode::malformed, fmt::format("a resting face has no '{}'", excerpt(key)), where);
    }
  }
  const RestingFace bounded = face.within_range();
  for (std::size_t i = 0; i < face::kShapeCount; ++i) {
    if (kRestingRules[i] == RestingRule::none && face.changes(i))
      return fail(ErrorCode::malformed, fmt::format("{} has no rest of its own", face::kShapeNames[i]),
                  where);
    if (face.rest[i] != bounded.rest[i] || face.full[i] != bounded.full[i])
      return fail(
          ErrorCode::out_of_range,
          fmt::format("{} rests at {} and is full at {}", face::kShapeNames[i], face.rest[i], face.full[i]),
          where,
          fmt::format("rest is 0 to {}, full is {} above it to 1, and 1 but for lids",
                      RestingFace::kRestAtMost, RestingFace::kLeastRange));
  }
  return face;
}

}  // namespace mien::shaping
