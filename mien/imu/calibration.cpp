#include "mien/imu/calibration.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

namespace mien::imu {
namespace {

using nlohmann::json;

json numbers(const Vec3& v) {
  return json::array({v.x(), v.y(), v.z()});
}
json numbers(const Quat& q) {
  return json::array({q.w(), q.x(), q.y(), q.z()});
}

bool read_number(const json& object, const char* key, double& out) {
  const auto it = object.find(key);
  if (it == object.end() || !it->is_number()) return false;
  out = it->get<double>();
  return std::isfinite(out);
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

bool read_flag(const json& object, const char* key, bool& out) {
  const auto it = object.find(key);
  if (it == object.end() || !it->is_boolean()) return false;
  out = it->get<bool>();
  return true;
}

bool read_text(const json& object, const char* key, std::string& out) {
  const auto it = object.find(key);
  if (it == object.end() || !it->is_string()) return false;
  out = it->get<std::string>();
  return true;
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
  json scores = json::array();
  for (const sensor::Score& s : calibration.scores)
    scores.push_back(
        {{"name", s.name}, {"value", s.value}, {"unit", s.unit}, {"pass", s.pass}, {"sentence", s.sentence}});
  const json root = {{"complete", calibration.complete},
                     {"q_head_ear", numbers(calibration.q_head_ear)},
                     {"neutral_heading_rad", calibration.neutral_heading_rad},
                     {"sensors", std::move(sensors)},
                     {"scores", std::move(scores)}};
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
  for (const json& item : *scores) {
    sensor::Score s;
    if (!item.is_object() || !read_text(item, "name", s.name) || !read_number(item, "value", s.value) ||
        !read_text(item, "unit", s.unit) || !read_flag(item, "pass", s.pass) ||
        !read_text(item, "sentence", s.sentence))
      return bad(fmt::format("score {} is not a score", c.scores.size()));
    c.scores.push_back(std::move(s));
  }
  return c;
}

}  // namespace mien::imu
