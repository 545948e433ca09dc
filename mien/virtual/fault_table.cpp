#include "mien/virtual/fault_table.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "mien/core/excerpt.h"
#include "mien/core/toml.h"

namespace mien::virt {
namespace {

/// Beyond this no fault means anything in its unit, and times would leave what a packet can say.
constexpr double kMost = 1e6;

Result<double> number(const toml::node& node, std::string_view key, const std::string& where) {
  // value() alone would take true for a number.
  const auto value = node.is_number() ? node.value<double>() : std::nullopt;
  if (!value) return fail(ErrorCode::malformed, fmt::format("{} must be a number", key), where);
  if (!std::isfinite(*value) || *value < 0)
    return fail(ErrorCode::out_of_range, fmt::format("{} must be finite and not negative", key), where);
  if (*value > kMost)
    return fail(ErrorCode::out_of_range, fmt::format("{} must be at most {:.0f}", key, kMost), where);
  return *value;
}

}  // namespace

Result<void> read_fault_table(nlohmann::json& magnitudes, std::string_view text, const std::string& where,
                              std::span<const FaultLimit> limits) {
  MIEN_TRY_ASSIGN(const toml::table table, parse_toml(text, where + ", [faults]"));
  for (const auto& [name, node] : table) {
    const std::string_view key = name.str();
    const auto found = magnitudes.find(key);
    if (found == magnitudes.end())
      return fail(ErrorCode::malformed, fmt::format("there is no fault named {}", excerpt(key)), where);
    if (found->is_number()) {
      MIEN_TRY_ASSIGN(*found, number(node, key, where));
    } else if (found->is_array()) {
      const toml::array* pair = node.as_array();
      if (pair == nullptr || pair->size() != 2)
        return fail(ErrorCode::malformed, fmt::format("{} must be [least, most]", key), where);
      for (std::size_t i = 0; i < 2; ++i) {
        MIEN_TRY_ASSIGN((*found)[i], number((*pair)[i], key, where));
      }
      if ((*found)[1] < (*found)[0])
        return fail(ErrorCode::out_of_range, fmt::format("{}: the most is less than the least", key), where);
    } else {
      if (!node.is_boolean())
        return fail(ErrorCode::malformed, fmt::format("{} must be true or false", key), where);
      *found = *node.value<bool>();
    }
  }
  for (const FaultLimit& limit : limits) {
    const nlohmann::json& held = magnitudes.at(limit.key);
    const double least = (held.is_array() ? held[0] : held).get<double>();
    const double most = (held.is_array() ? held[1] : held).get<double>();
    if (least < limit.least || most > limit.most)
      return fail(ErrorCode::out_of_range,
                  fmt::format("{} must be {:g} to {:g}", limit.key, limit.least, limit.most), where);
  }
  return {};
}

}  // namespace mien::virt
