#include "lab/imu/part_rig.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <vector>

#include "mien/core/nearest_word.h"

namespace mien::lab {
namespace {

sensor::SkinMotion marginal(const sensor::SkinMotion& skin, std::span<const std::string> names) {
  sensor::SkinMotion out;
  std::vector<Eigen::Index> rows;
  for (std::size_t s = 0; s < skin.sensors.size(); ++s) {
    if (std::ranges::find(names, skin.sensors[s]) == names.end()) continue;
    out.sensors.push_back(skin.sensors[s]);
    for (Eigen::Index axis = 0; axis < 3; ++axis) rows.push_back(3 * static_cast<Eigen::Index>(s) + axis);
  }
  const Eigen::MatrixXd covariance = skin.factor_deg * skin.factor_deg.transpose();
  out.mean_deg = skin.mean_deg(rows);
  out.factor_deg = Eigen::MatrixXd(covariance(rows, rows)).llt().matrixL();
  return out;
}

}  // namespace

Result<sensor::Rig> rig_with_sensors(const sensor::Rig& rig, std::span<const std::string> names) {
  if (names.empty()) return fail(ErrorCode::bad_usage, "no sensor is left", "rig " + rig.name);
  const std::vector<std::string> all = rig.face_sensor_names();
  for (const std::string& name : names)
    if (std::ranges::find(all, name) == all.end())
      return fail(ErrorCode::not_found,
                  fmt::format("the rig has no face sensor {}{}", name, did_you_mean(name, all)),
                  "rig " + rig.name);
  if (names.size() == all.size()) return rig;
  sensor::Rig part = rig;
  std::erase_if(part.sensors, [&](const sensor::Mount& mount) {
    return mount.role == "face" && std::ranges::find(names, mount.name) == names.end();
  });
  if (!part.find(part.reference)) part.reference = names.front();
  if (rig.skin) {
    part.skin = marginal(*rig.skin, names);
    if (part.skin->sensors.empty()) part.skin.reset();
  }
  return part;
}

}  // namespace mien::lab
