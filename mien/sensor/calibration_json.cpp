#include "mien/sensor/calibration_json.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

namespace mien::sensor {

using nlohmann::json;

bool read_number(const json& object, const char* key, double& out) {
  const auto it = object.find(key);
  if (it == object.end() || !it->is_number()) return false;
  out = it->get<double>();
  return std::isfinite(out);
}

bool read_flag(const json& object, const char* key, bool& out) {
  const auto it = object.find(key);
  if (it == object.end() || !it->is_boolean()) return false;
  out = it->get<bool>();
  return true;
}

bool read_string(const json& object, const char* key, std::string& out) {
  const auto it = object.find(key);
  if (it == object.end() || !it->is_string()) return false;
  out = it->get<std::string>();
  return true;
}

json scores_json(const std::vector<Score>& scores) {
  json list = json::array();
  for (const Score& s : scores)
    list.push_back(
        {{"name", s.name}, {"value", s.value}, {"unit", s.unit}, {"pass", s.pass}, {"sentence", s.sentence}});
  return list;
}

Result<std::vector<Score>> read_scores(const json& list, const std::string& where) {
  std::vector<Score> scores;
  for (const json& item : list) {
    Score s;
    if (!item.is_object() || !read_string(item, "name", s.name) || !read_number(item, "value", s.value) ||
        !read_string(item, "unit", s.unit) || !read_flag(item, "pass", s.pass) ||
        !read_string(item, "sentence", s.sentence))
      return fail(ErrorCode::malformed, fmt::format("score {} is not a score", scores.size()), where);
    scores.push_back(std::move(s));
  }
  return scores;
}

}  // namespace mien::sensor
