#include "mien/shaping/centre.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "mien/core/excerpt.h"

namespace mien::shaping {

using nlohmann::json;

std::string write_centre(const Centre& centre) {
  json rest = json::object();
  for (std::size_t i = 0; i < face::kShapeCount; ++i)
    if (centre.rest[i] != 0) rest[std::string(face::kShapeNames[i])] = centre.rest[i];
  json out = {{"rest", std::move(rest)}, {"yaw_rad", centre.yaw_rad}};
  if (const Vec3& p = centre.position_m; !p.isZero(0)) out["position_m"] = {p.x(), p.y(), p.z()};
  return out.dump();
}

Result<Centre> parse_centre(std::string_view text, const std::string& where) {
  const auto bad = [&where](ErrorCode code, std::string what) { return fail(code, std::move(what), where); };
  const json root = json::parse(text, nullptr, false);
  if (!root.is_object()) return bad(ErrorCode::malformed, "not a JSON object");
  Centre centre;
  for (const auto& [key, value] : root.items()) {
    if (key == "yaw_rad") {
      if (!value.is_number()) return bad(ErrorCode::malformed, "'yaw_rad' is not a number");
      centre.yaw_rad = value.get<double>();
      if (!(std::abs(centre.yaw_rad) <= std::numbers::pi))
        return bad(ErrorCode::out_of_range, "'yaw_rad' is not within half a turn");
    } else if (key == "position_m") {
      if (!value.is_array() || value.size() != 3)
        return bad(ErrorCode::malformed, "'position_m' is not three numbers");
      for (std::size_t a = 0; a < 3; ++a) {
        if (!value[a].is_number()) return bad(ErrorCode::malformed, "'position_m' is not three numbers");
        double& x = centre.position_m[static_cast<Eigen::Index>(a)];
        x = value[a].get<double>();
        if (!(std::abs(x) <= Centre::kPositionAtMost_m))
          return bad(ErrorCode::out_of_range,
                     fmt::format("'position_m' is not within {} m", Centre::kPositionAtMost_m));
      }
    } else if (key == "rest") {
      if (!value.is_object()) return bad(ErrorCode::malformed, "'rest' is no table of shapes");
      for (const auto& [name, rest] : value.items()) {
        const std::size_t i = face::shape_index(name);
        if (i == face::kShapeCount)
          return bad(ErrorCode::malformed, fmt::format("no shape is called '{}'", excerpt(name)));
        if (!rest.is_number())
          return bad(ErrorCode::malformed, fmt::format("the rest of {} is not a number", name));
        centre.rest[i] = rest.get<float>();
        if (!(centre.rest[i] >= 0 && centre.rest[i] <= Centre::kRestAtMost))
          return bad(ErrorCode::out_of_range,
                     fmt::format("the rest of {} is not within 0 to {}", name, Centre::kRestAtMost));
      }
    } else {
      return bad(ErrorCode::malformed, fmt::format("a centre has no '{}'", excerpt(key)));
    }
  }
  return centre;
}

}  // namespace mien::shaping
