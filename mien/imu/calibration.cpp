#include "mien/imu/calibration.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "mien/model/correction_json.h"
#include "mien/model/skin_map.h"
#include "mien/sensor/calibration_json.h"

namespace mien::imu {
namespace {

using nlohmann::json;
using sensor::read_flag;
using sensor::read_number;

constexpr std::size_t kMostSlopes = std::size_t{256} * 3 * 64;
constexpr double kLargestSlope = 100;

json numbers(const Vec3& v) {
  return json::array({v.x(), v.y(), v.z()});
}
json numbers(const Quat& q) {
  return json::array({q.w(), q.x(), q.y(), q.z()});
}

template <std::size_t N>
bool read_numbers(const json& object, const char* key, std::array<double, N>& out) {
  const auto it = object.find(key);
  if (it == object.end() || !it->is_array() || it->size() != N) return false;
  for (std::size_t i = 0; i < N; ++i) {
    if (!(*it)[i].is_number()) return false;
    out[i] = (*it)[i].template get<double>();
    if (!std::isfinite(out[i])) return false;
  }
  return true;
}

bool read_rotation(const json& object, const char* key, Quat& out) {
  std::array<double, 4> v{};
  if (!read_numbers(object, key, v)) return false;
  out = Quat(v[0], v[1], v[2], v[3]);
  return std::abs(out.norm() - 1.0) < 1e-6;
}

}  // namespace

std::string write_calibration(const Calibration& calibration) {
  json sensors = json::array();
  for (const SensorCalibration& s : calibration.sensors)
    sensors.push_back({{"valid", s.valid},
                       {"neutral", numbers(s.neutral)},
                       {"heading_rad", s.heading_rad},
                       {"heading_sigma_rad", s.heading_sigma_rad},
                       {"neutral_accel_m_s2", numbers(s.neutral_accel_m_s2)}});
  json root = {{"complete", calibration.complete},
               {"q_head_ear", numbers(calibration.q_head_ear)},
               {"neutral_heading_rad", calibration.neutral_heading_rad},
               {"sensors", std::move(sensors)},
               {"scores", sensor::scores_json(calibration.scores)}};
  if (!calibration.wearer.empty()) {
    json& slopes = root["wearer"] = json::array();
    for (const float slope : calibration.wearer) slopes.push_back(model::in_millionths(slope));
  }
  if (calibration.correction)
    root["correction"] = json::parse(model::write_correction(*calibration.correction));
  return root.dump();
}

Result<Calibration> parse_calibration(std::string_view text, const std::string& where) {
  const json root = json::parse(text, nullptr, false);
  const auto bad = [&where](const std::string& what) { return fail(ErrorCode::malformed, what, where); };
  if (!root.is_object()) return bad("not a JSON object");
  Calibration c;
  if (!read_flag(root, "complete", c.complete)) return bad("'complete' is not true or false");
  if (!read_rotation(root, "q_head_ear", c.q_head_ear)) return bad("'q_head_ear' is no unit quaternion");
  if (!read_number(root, "neutral_heading_rad", c.neutral_heading_rad))
    return bad("'neutral_heading_rad' is not a finite number");
  const auto sensors = root.find("sensors");
  const auto scores = root.find("scores");
  if (sensors == root.end() || !sensors->is_array() || sensors->size() > 256)
    return bad("'sensors' is no list of sensors");
  if (scores == root.end() || !scores->is_array() || scores->size() > 1024)
    return bad("'scores' is no list of scores");
  for (const json& item : *sensors) {
    SensorCalibration s;
    std::array<double, 3> accel{};
    if (!item.is_object() || !read_flag(item, "valid", s.valid) ||
        !read_rotation(item, "neutral", s.neutral) || !read_number(item, "heading_rad", s.heading_rad) ||
        !read_number(item, "heading_sigma_rad", s.heading_sigma_rad) || s.heading_sigma_rad < 0 ||
        !read_numbers(item, "neutral_accel_m_s2", accel))
      return bad(fmt::format("sensor {} is not a sensor's calibration", c.sensors.size()));
    s.neutral_accel_m_s2 = Vec3(accel[0], accel[1], accel[2]);
    c.sensors.push_back(s);
  }
  if (const auto wearer = root.find("wearer"); wearer != root.end()) {
    if (!wearer->is_array() || wearer->size() > kMostSlopes) return bad("'wearer' is no list of slopes");
    for (const json& slope : *wearer) {
      if (!slope.is_number() || !(std::abs(slope.get<double>()) < kLargestSlope))
        return bad(fmt::format("slope {} of the wearer is no such number", c.wearer.size()));
      c.wearer.push_back(slope.get<float>());
    }
  }
  if (const auto correction = root.find("correction"); correction != root.end()) {
    MIEN_TRY_ASSIGN(c.correction, model::parse_correction(correction->dump(), where));
  }
  MIEN_TRY_ASSIGN(c.scores, sensor::read_scores(*scores, where));
  return c;
}

}  // namespace mien::imu
