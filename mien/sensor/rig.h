#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/rotation.h"
#include "mien/sensor/camera_mount.h"

namespace mien::sensor {

/// One sensor of a rig.
struct Mount {
  std::string name;  ///< Unique in the rig: "zygomaticus_upper_L".
  std::string kind;  ///< Its modality: "imu", "eyewear", "camera".
  std::string site;  ///< Anatomical: "frontalis", "orbicularis", "mastoid", ...
  char side = 'M';   ///< 'L', 'R' (the performer's own) or 'M'.
  /// "face"; "head" for the sensor that carries the head's rotation; "truth" for one of another program's
  /// weights that is recorded beside the others and moves nothing.
  std::string role;
  std::string device;   ///< Binding to a device: "id[/channel]"; empty when bound later.
  int ict_vertex = -1;  ///< Site on the ICT mesh; -1 when not given.
  /// Site on the built-in face's neutral, frame H. Without it acceleration against the head is unknown.
  std::optional<Vec3> position_m;
  std::optional<Vec3> outward;  ///< Outward axis in the sensor's own frame (unit), if the sensor has one.
  /// Which way a sensor that looks at the skin from afar looks (unit), built-in head, frame H.
  std::optional<Vec3> aim;
  /// Follow how what it reads at rest drifts (eyewear::LightDrift); only of a kind whose tracker does so.
  bool recentre = false;
  /// Of a microphone: how the mouth is heard, "network" (empty is the same) or "phones".
  std::string hears_by;
  std::optional<CameraMount> camera;  ///< Of a camera, and of nothing else.

  [[nodiscard]] bool is_truth() const { return role == "truth"; }
};

/// How the skin under face sensors turns, over many people and performances: mean and covariance of the
/// rotation vectors against neutral, frame H, three numbers a sensor. Degrees, as the file has them: radians
/// would not be written back as the same digits.
struct SkinMotion {
  std::vector<std::string> sensors;  ///< Names, each a face sensor of the rig.
  Eigen::VectorXd mean_deg;
  Eigen::MatrixXd factor_deg;  ///< Lower triangular; times its transpose it is the covariance.
};

/// Which sensors sit where: data, never constants in code. `*.toml`, see rigs/default.toml.
struct Rig {
  std::string name;
  std::string reference;       ///< Name of the sensor whose device time carries the frame grid.
  std::vector<Mount> sensors;  ///< Order fixes Sample::sensor.
  std::optional<SkinMotion>
      skin;  ///< Where it was measured: how drift is tracked until the wearer is known (imu::DriftFilter).
  std::string faults_toml;  ///< The file's [faults] table as text, for the simulator; opaque here.

  [[nodiscard]] std::optional<std::uint16_t> find(std::string_view sensor_name) const;
  /// Indices of the sensors with role "face", in order: the sensors that features are made of.
  [[nodiscard]] std::vector<std::uint16_t> face_sensors() const;
  [[nodiscard]] std::vector<std::string> face_sensor_names() const;  ///< Of the same.
  [[nodiscard]] std::optional<std::uint16_t> head_sensor() const;
};

/// Errors: malformed TOML (with line), duplicated names, unknown keys, no sensors, more than 256, bad
/// reference, non-finite numbers. `where` names the source in messages.
[[nodiscard]] Result<Rig> parse_rig(std::string_view toml, const std::string& where);
[[nodiscard]] Result<Rig> read_rig(const std::filesystem::path& path);
/// The `[skin]` table of a rig file, as TOML.
[[nodiscard]] std::string write_skin(const SkinMotion& skin);
/// TOML text that parse_rig takes back to an equal rig.
[[nodiscard]] std::string write_rig(const Rig& rig);

}  // namespace mien::sensor
