#include "mien/sensor/rig.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

#include "mien/core/excerpt.h"
#include "mien/core/files.h"
#include "mien/core/toml.h"
#include "mien/sensor/picture_view.h"

namespace mien::sensor {
namespace {

constexpr std::size_t kMaxRigBytes = 1U << 20U;
constexpr std::size_t kMaxSensors = 256;
constexpr std::string_view kTellingKind = "weights";  // Of what other programs tell.
constexpr std::size_t kMaxTextBytes = 128;
/// Farther from the head's origin than this is a mistake of units.
constexpr double kMaxPositionM = 10.0;
/// Face sensors of a rig whose skin's motion is told; each frame's work grows with the cube of them.
constexpr std::size_t kMaxSkinSensors = 64;
constexpr std::size_t kMaxLamps = 8;  // Beside one camera.
/// A camera whose line of sight and up differ by less (sine) has no up.
constexpr double kLeastUp = 0.05;

bool printable(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](unsigned char c) { return c >= 0x20 && c < 0x7F; });
}

Result<std::string> text(const toml::table& table, std::string_view key, bool required,
                         const std::string& where) {
  const toml::node* node = table.get(key);
  if (node == nullptr) {
    if (required) return fail(ErrorCode::malformed, fmt::format("'{}' is missing", key), place(where, table));
    return std::string();
  }
  const auto value = node->value_exact<std::string>();
  if (!value) return fail(ErrorCode::malformed, fmt::format("'{}' is not text", key), place(where, *node));
  if ((required && value->empty()) || value->size() > kMaxTextBytes || !printable(*value))
    return fail(ErrorCode::malformed, fmt::format("'{}' is empty, too long or not printable", key),
                place(where, *node));
  return *value;
}

/// A list of so many finite numbers; `key` names it in messages.
Result<Eigen::VectorXd> number_list(const toml::node* node, std::size_t count, std::string_view key,
                                    const std::string& where) {
  const toml::array* array = node == nullptr ? nullptr : node->as_array();
  const auto malformed = [&] {
    return fail(ErrorCode::malformed, fmt::format("'{}' is not a list of {} numbers", key, count),
                node == nullptr ? where : place(where, *node));
  };
  if (array == nullptr || array->size() != count) return malformed();
  Eigen::VectorXd values(static_cast<Eigen::Index>(count));
  for (std::size_t i = 0; i < count; ++i) {
    const auto number = (*array)[i].value<double>();
    if (!number) return malformed();
    if (!std::isfinite(*number))
      return fail(ErrorCode::out_of_range, fmt::format("'{}' holds a number that is not finite", key),
                  place(where, *node));
    values[static_cast<Eigen::Index>(i)] = *number;
  }
  return values;
}

Result<std::optional<Vec3>> vector(const toml::table& table, std::string_view key, const std::string& where) {
  const toml::node* node = table.get(key);
  if (node == nullptr) return std::optional<Vec3>();
  MIEN_TRY_ASSIGN(const Eigen::VectorXd value, number_list(node, 3, key, where));
  return std::optional<Vec3>(Vec3(value));
}

/// A direction; made unit, since files round. What is unit already stays as it is, to the bit.
Result<std::optional<Vec3>> unit_vector(const toml::table& table, std::string_view key,
                                        const std::string& where) {
  MIEN_TRY_ASSIGN(std::optional<Vec3> direction, vector(table, key, where));
  if (direction) {
    const double length = direction->norm();
    if (length < 0.9 || length > 1.1)
      return fail(ErrorCode::out_of_range, fmt::format("'{}' is not a unit vector", key),
                  place(where, table));
    if (std::abs(length - 1) > 1e-12) *direction /= length;
  }
  return direction;
}

/// Puts the number that the table has under `key`, if it has one, into `value`; `least` and `most` are
/// allowed.
Result<void> number(const toml::table& table, std::string_view key, double least, double most, double& value,
                    const std::string& where) {
  const toml::node* node = table.get(key);
  if (node == nullptr) return {};
  const auto read = node->value<double>();
  if (!read) return fail(ErrorCode::malformed, fmt::format("'{}' is not a number", key), place(where, *node));
  if (!(*read >= least && *read <= most))  // Not so where it is no number.
    return fail(ErrorCode::out_of_range, fmt::format("'{}' is not within {:g} and {:g}", key, least, most),
                place(where, *node));
  value = *read;
  return {};
}

/// A place near the head, metres.
Result<std::optional<Vec3>> near_place(const toml::table& table, std::string_view key,
                                       const std::string& where) {
  MIEN_TRY_ASSIGN(const std::optional<Vec3> position_m, vector(table, key, where));
  if (position_m && position_m->norm() > kMaxPositionM)
    return fail(ErrorCode::out_of_range, fmt::format("'{}' is metres away from the head", key),
                place(where, table), "give it in metres");
  return position_m;
}

Result<Lamp> read_lamp(const toml::table& table, const std::string& where) {
  MIEN_TRY(only_keys(table, {"position_m", "aim", "power_mw", "half_angle_deg"}, where));
  Lamp lamp;
  MIEN_TRY_ASSIGN(const std::optional<Vec3> position_m, near_place(table, "position_m", where));
  MIEN_TRY_ASSIGN(const std::optional<Vec3> aim, unit_vector(table, "aim", where));
  if (!position_m || !aim)
    return fail(ErrorCode::malformed, "a lamp without 'position_m' or 'aim'", place(where, table));
  lamp.position_m = *position_m;
  lamp.aim = *aim;
  MIEN_TRY(number(table, "power_mw", 0, 10'000, lamp.power_mw, where));
  MIEN_TRY(number(table, "half_angle_deg", 1, 89, lamp.half_angle_deg, where));
  return lamp;
}

Result<void> read_pixels(const toml::table& table, CameraMount& camera, const std::string& where) {
  if (const toml::node* node = table.get("size")) {
    MIEN_TRY_ASSIGN(const Eigen::VectorXd size, number_list(node, 2, "size", where));
    for (std::size_t i = 0; i < 2; ++i) {
      const double side = size[static_cast<Eigen::Index>(i)];
      const double most = i == 0 ? 1280 : 960;
      if (side < 16 || side > most || side != std::floor(side))
        return fail(ErrorCode::out_of_range, "'size' is not 16 x 16 to 1280 x 960 whole pixels",
                    place(where, *node));
      camera.size[i] = static_cast<int>(side);
    }
  }
  if (const toml::node* node = table.get("crop")) {
    MIEN_TRY_ASSIGN(const Eigen::VectorXd crop, number_list(node, 4, "crop", where));
    for (Eigen::Index i = 0; i < 4; ++i) camera.crop[static_cast<std::size_t>(i)] = crop[i];
    MIEN_TRY(check_crop(camera.crop, place(where, *node)));
  }
  if (const toml::node* node = table.get("turn_deg")) {
    const std::int64_t turn_deg = node->value_exact<std::int64_t>().value_or(-1);
    MIEN_TRY(check_turn(turn_deg, place(where, *node)));
    camera.turn_deg = static_cast<int>(turn_deg);
  }
  if (const toml::node* node = table.get("mirror")) {
    const auto mirror = node->value_exact<bool>();
    if (!mirror) return fail(ErrorCode::malformed, "'mirror' is neither true nor false", place(where, *node));
    camera.mirror = *mirror;
  }
  return {};
}

/// The table 'camera' of a sensor that stands at `position_m`.
Result<CameraMount> read_camera(const toml::node& node, const std::optional<Vec3>& position_m,
                                const std::string& where) {
  const toml::table* table = node.as_table();
  const std::string here = place(where, node);
  if (table == nullptr) return fail(ErrorCode::malformed, "'camera' is not a table", here);
  MIEN_TRY(only_keys(*table,
                     {"look_at_m", "up", "field_of_view_deg", "radial_k1", "size", "rate_hz", "exposure_ms",
                      "crop", "turn_deg", "mirror", "lamps"},
                     where));
  CameraMount camera;
  MIEN_TRY_ASSIGN(const std::optional<Vec3> look_at_m, near_place(*table, "look_at_m", where));
  MIEN_TRY_ASSIGN(const std::optional<Vec3> up, unit_vector(*table, "up", where));
  if (!look_at_m || !up || !position_m)
    return fail(ErrorCode::malformed, "a camera without 'position_m', 'camera.look_at_m' or 'camera.up'",
                here);
  camera.look_at_m = *look_at_m;
  camera.up = *up;
  const Vec3 sight_m = camera.look_at_m - *position_m;
  if (sight_m.norm() < 1e-3 || sight_m.normalized().cross(camera.up).norm() < kLeastUp)
    return fail(ErrorCode::out_of_range, "a camera that looks along its 'up', or at itself", here);
  MIEN_TRY(number(*table, "field_of_view_deg", 5, 170, camera.field_of_view_deg, where));
  MIEN_TRY(number(*table, "radial_k1", -0.5, 0.5, camera.radial_k1, where));
  MIEN_TRY(number(*table, "rate_hz", 1, 130, camera.rate_hz, where));
  MIEN_TRY(number(*table, "exposure_ms", 0.01, 1000 / camera.rate_hz, camera.exposure_ms, where));
  MIEN_TRY(read_pixels(*table, camera, where));
  if (const toml::node* lamps = table->get("lamps")) {
    const toml::array* list = lamps->as_array();
    if (list == nullptr || list->size() > kMaxLamps)
      return fail(ErrorCode::malformed, fmt::format("'lamps' is not a list of up to {} tables", kMaxLamps),
                  place(where, *lamps));
    for (const toml::node& lamp : *list) {
      if (!lamp.is_table()) return fail(ErrorCode::malformed, "a lamp is not a table", place(where, lamp));
      MIEN_TRY_ASSIGN(camera.lamps.emplace_back(), read_lamp(*lamp.as_table(), where));
    }
  }
  return camera;
}

Result<Mount> read_mount(const toml::table& table, const std::string& where) {
  MIEN_TRY(only_keys(table,
                     {"name", "kind", "site", "side", "role", "device", "ict_vertex", "position_m", "outward",
                      "aim", "recentre", "hears_by", "camera"},
                     where));
  Mount mount;
  MIEN_TRY_ASSIGN(mount.name, text(table, "name", true, where));
  MIEN_TRY_ASSIGN(mount.kind, text(table, "kind", true, where));
  if (mount.kind == "photo") mount.kind = "eyewear";  // As rigs and takes before 0.1.0 call it.
  MIEN_TRY_ASSIGN(mount.site, text(table, "site", false, where));
  MIEN_TRY_ASSIGN(mount.role, text(table, "role", true, where));
  MIEN_TRY_ASSIGN(mount.device, text(table, "device", false, where));
  if (mount.role != "face" && mount.role != "head" && !mount.is_truth())
    return fail(ErrorCode::malformed, fmt::format("role '{}' is unknown", excerpt(mount.role)),
                place(where, table), "use \"face\", \"head\" or \"truth\"");
  if (mount.is_truth() && mount.kind != kTellingKind)
    return fail(ErrorCode::malformed,
                fmt::format("a sensor of the kind '{}' is no truth", excerpt(mount.kind)),
                place(where, table), "use the role \"truth\" of the kind \"weights\" alone");
  MIEN_TRY_ASSIGN(const std::string side, text(table, "side", false, where));
  if (!side.empty()) {
    if (side != "L" && side != "R" && side != "M")
      return fail(ErrorCode::malformed, fmt::format("side '{}' is unknown", excerpt(side)),
                  place(where, table), "use \"L\", \"R\" or \"M\"");
    mount.side = side[0];
  }
  if (const toml::node* node = table.get("ict_vertex")) {
    const auto vertex = node->value_exact<std::int64_t>();
    if (!vertex || *vertex < 0 || *vertex > 1'000'000)
      return fail(ErrorCode::out_of_range, "'ict_vertex' is not a vertex number", place(where, *node));
    mount.ict_vertex = static_cast<int>(*vertex);
  }
  MIEN_TRY_ASSIGN(mount.position_m, near_place(table, "position_m", where));
  MIEN_TRY_ASSIGN(mount.outward, unit_vector(table, "outward", where));
  MIEN_TRY_ASSIGN(mount.aim, unit_vector(table, "aim", where));
  if (const toml::node* node = table.get("recentre")) {
    const auto recentre = node->value_exact<bool>();
    if (!recentre)
      return fail(ErrorCode::malformed, "'recentre' is neither true nor false", place(where, *node));
    if (*recentre && mount.kind != "eyewear")
      return fail(ErrorCode::malformed,
                  fmt::format("'recentre' of a sensor of kind '{}'", excerpt(mount.kind)),
                  place(where, *node), "only the light of kind \"eyewear\" is re-centred");
    mount.recentre = *recentre;
  }
  MIEN_TRY_ASSIGN(mount.hears_by, text(table, "hears_by", false, where));
  if (!mount.hears_by.empty() && mount.kind != "speech")
    return fail(ErrorCode::malformed, fmt::format("'hears_by' of a sensor of kind '{}'", excerpt(mount.kind)),
                place(where, table), "only a microphone, of kind \"speech\", hears");
  if (!mount.hears_by.empty() && mount.hears_by != "network" && mount.hears_by != "phones")
    return fail(ErrorCode::malformed, fmt::format("'hears_by' is '{}'", excerpt(mount.hears_by)),
                place(where, table), "use \"network\" or \"phones\"");
  const toml::node* camera = table.get("camera");
  if ((camera != nullptr) != (mount.kind == "camera"))
    return fail(ErrorCode::malformed,
                camera != nullptr ? fmt::format("'camera' of a sensor of kind '{}'", excerpt(mount.kind))
                                  : fmt::format("the camera '{}' has no table 'camera'", excerpt(mount.name)),
                place(where, table), "give a sensor of kind \"camera\", and no other, a table 'camera'");
  if (camera != nullptr) {
    if (mount.site != "eye" && mount.site != "mouth")
      return fail(ErrorCode::malformed,
                  fmt::format("the camera '{}' has the site '{}'", excerpt(mount.name), excerpt(mount.site)),
                  place(where, table), "use \"eye\" or \"mouth\"");
    MIEN_TRY_ASSIGN(mount.camera, read_camera(*camera, mount.position_m, where));
  }
  return mount;
}

Result<SkinMotion> read_skin(const toml::node& node, const Rig& rig, const std::string& where) {
  const toml::table* table = node.as_table();
  const std::string here = place(where, node);
  if (table == nullptr) return fail(ErrorCode::malformed, "'skin' is not a table", here);
  MIEN_TRY(only_keys(*table, {"sensors", "mean_deg", "factor_deg"}, where));
  const toml::array* names = table->get_as<toml::array>("sensors");
  const toml::array* rows = table->get_as<toml::array>("factor_deg");
  if (names == nullptr || names->empty() || names->size() > kMaxSkinSensors)
    return fail(ErrorCode::malformed,
                fmt::format("'sensors' is not a list of 1 to {} names", kMaxSkinSensors), here);
  SkinMotion skin;
  const std::vector<std::string> face = rig.face_sensor_names();
  if (face.size() > kMaxSkinSensors)
    return fail(ErrorCode::out_of_range,
                fmt::format("a 'skin' for a rig of more than {} face sensors", kMaxSkinSensors), here);
  for (const toml::node& name : *names) {
    const std::string sensor = name.value_or(std::string());
    if (std::ranges::find(face, sensor) == face.end())
      return fail(ErrorCode::malformed, "skin.sensors names what is no face sensor", place(where, name),
                  "name sensors of this rig with role \"face\"");
    if (std::ranges::find(skin.sensors, sensor) != skin.sensors.end())
      return fail(ErrorCode::malformed, fmt::format("skin.sensors names '{}' twice", excerpt(sensor)),
                  place(where, name), "name it once");
    skin.sensors.push_back(sensor);
  }
  const std::size_t size = 3 * skin.sensors.size();
  MIEN_TRY_ASSIGN(skin.mean_deg, number_list(table->get("mean_deg"), size, "mean_deg", where));
  if (rows == nullptr || rows->size() != size)
    return fail(ErrorCode::malformed, fmt::format("'factor_deg' is not a list of {} rows", size), here);
  skin.factor_deg.setZero(skin.mean_deg.size(), skin.mean_deg.size());
  for (std::size_t r = 0; r < size; ++r) {
    MIEN_TRY_ASSIGN(const Eigen::VectorXd row, number_list(&(*rows)[r], r + 1, "factor_deg", where));
    skin.factor_deg.row(static_cast<Eigen::Index>(r)).head(row.size()) = row.transpose();
  }
  if (skin.mean_deg.cwiseAbs().maxCoeff() > 180 || skin.factor_deg.cwiseAbs().maxCoeff() > 180)
    return fail(ErrorCode::out_of_range, "'skin' turns by more than half a circle", here,
                "give it in degrees");
  return skin;
}

/// Numbers finite, texts and keys printable, not too deep.
bool plain_data(const toml::node& node, int depth) {
  if (depth > 16) return false;
  if (const auto* text_node = node.as_string()) return printable(text_node->get());
  if (const auto* number = node.as_floating_point()) return std::isfinite(number->get());
  if (const auto* array = node.as_array())
    return std::all_of(array->begin(), array->end(),
                       [depth](const toml::node& n) { return plain_data(n, depth + 1); });
  if (const auto* table = node.as_table())
    return std::all_of(table->begin(), table->end(), [depth](const auto& entry) {
      return printable(entry.first.str()) && plain_data(entry.second, depth + 1);
    });
  return true;
}

/// One value on one line, tables in braces. (The library's own formatter computes with an indent of -1 for
/// arrays, which the sanitizers refuse.)
void write_value(std::ostringstream& out, const toml::node& node) {
  if (const toml::array* array = node.as_array()) {
    out << '[';
    for (std::size_t i = 0; i < array->size(); ++i) {
      if (i > 0) out << ", ";
      write_value(out, (*array)[i]);
    }
    out << ']';
  } else if (const toml::table* table = node.as_table()) {
    out << '{';
    bool first = true;
    for (const auto& [key, value] : *table) {
      out << (first ? " " : ", ") << toml::value<std::string>(key.str()) << " = ";
      write_value(out, value);
      first = false;
    }
    out << " }";
  } else {
    node.visit([&out](const auto& value) {
      if constexpr (toml::is_value<decltype(value)>) out << value;
    });
  }
}

/// The entries of a table, one a line.
void write_entries(std::ostringstream& out, const toml::table& table) {
  for (const auto& [key, value] : table) {
    const std::string name(key.str());
    const bool bare = !name.empty() && std::all_of(name.begin(), name.end(), [](unsigned char c) {
      return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
             c == '-';
    });
    if (bare)
      out << name;
    else
      out << toml::value<std::string>(name);
    out << " = ";
    write_value(out, value);
    out << '\n';
  }
}

template <class T>
void line(std::ostringstream& out, std::string_view key, const T& value) {
  toml::table one;
  one.insert(key, value);
  write_entries(out, one);
}

toml::array numbers(const Vec3& v) {
  return toml::array{v.x(), v.y(), v.z()};
}

toml::table camera_table(const CameraMount& camera) {
  toml::table table{
      {"look_at_m", numbers(camera.look_at_m)},
      {"up", numbers(camera.up)},
      {"field_of_view_deg", camera.field_of_view_deg},
      {"radial_k1", camera.radial_k1},
      {"size", toml::array{camera.size[0], camera.size[1]}},
      {"rate_hz", camera.rate_hz},
      {"exposure_ms", camera.exposure_ms},
      {"crop", toml::array{camera.crop[0], camera.crop[1], camera.crop[2], camera.crop[3]}},
      {"turn_deg", camera.turn_deg},
      {"mirror", camera.mirror},
  };
  toml::array lamps;
  for (const Lamp& lamp : camera.lamps)
    lamps.push_back(toml::table{{"position_m", numbers(lamp.position_m)},
                                {"aim", numbers(lamp.aim)},
                                {"power_mw", lamp.power_mw},
                                {"half_angle_deg", lamp.half_angle_deg}});
  table.insert("lamps", std::move(lamps));
  return table;
}

}  // namespace

std::optional<std::uint16_t> Rig::find(std::string_view sensor_name) const {
  for (std::size_t i = 0; i < sensors.size(); ++i)
    if (sensors[i].name == sensor_name) return static_cast<std::uint16_t>(i);
  return std::nullopt;
}

std::vector<std::uint16_t> Rig::face_sensors() const {
  std::vector<std::uint16_t> indices;
  for (std::size_t i = 0; i < sensors.size(); ++i)
    if (sensors[i].role == "face") indices.push_back(static_cast<std::uint16_t>(i));
  return indices;
}

std::vector<std::string> Rig::face_sensor_names() const {
  std::vector<std::string> names;
  for (const std::uint16_t s : face_sensors()) names.push_back(sensors[s].name);
  return names;
}

std::optional<std::uint16_t> Rig::head_sensor() const {
  for (std::size_t i = 0; i < sensors.size(); ++i)
    if (sensors[i].role == "head") return static_cast<std::uint16_t>(i);
  return std::nullopt;
}

Result<Rig> parse_rig(std::string_view toml_text, const std::string& where) {
  if (toml_text.size() > kMaxRigBytes)
    return fail(ErrorCode::out_of_range, "a rig of more than 1 MiB", where);
  MIEN_TRY_ASSIGN(const toml::table root, parse_toml(toml_text, where));
  MIEN_TRY(only_keys(root, {"name", "reference", "sensor", "skin", "faults"}, where));

  Rig rig;
  MIEN_TRY_ASSIGN(rig.name, text(root, "name", true, where));
  MIEN_TRY_ASSIGN(rig.reference, text(root, "reference", true, where));

  const toml::node* list = root.get("sensor");
  if (list == nullptr || !list->is_array_of_tables() || list->as_array()->empty())
    return fail(ErrorCode::malformed, "the rig has no sensors", where, "add at least one [[sensor]]");
  const toml::array& sensors = *list->as_array();
  if (sensors.size() > kMaxSensors)
    return fail(ErrorCode::out_of_range, fmt::format("{} sensors, more than {}", sensors.size(), kMaxSensors),
                where);
  std::set<std::string, std::less<>> names;
  for (const toml::node& node : sensors) {
    MIEN_TRY_ASSIGN(Mount mount, read_mount(*node.as_table(), where));
    if (!names.insert(mount.name).second)
      return fail(ErrorCode::malformed, fmt::format("two sensors are called '{}'", excerpt(mount.name)),
                  place(where, node), "give each its own name");
    if (mount.role == "head" && rig.head_sensor())
      return fail(ErrorCode::malformed, "two sensors have the role \"head\"", place(where, node), "keep one");
    rig.sensors.push_back(std::move(mount));
  }
  if (!rig.find(rig.reference))
    return fail(ErrorCode::malformed,
                fmt::format("the reference '{}' is not one of the sensors", excerpt(rig.reference)), where,
                "name a sensor of this rig");
  if (rig.sensors[*rig.find(rig.reference)].is_truth())
    return fail(ErrorCode::malformed, "the reference is a truth, which frames do not wait for", where,
                "name a sensor of the role \"face\" or \"head\"");

  if (const toml::node* skin = root.get("skin")) {
    MIEN_TRY_ASSIGN(rig.skin, read_skin(*skin, rig, where));
  }
  if (const toml::node* faults = root.get("faults")) {
    if (!faults->is_table())
      return fail(ErrorCode::malformed, "'faults' is not a table", place(where, *faults));
    if (!plain_data(*faults, 0))
      return fail(ErrorCode::out_of_range,
                  "'faults' holds a number that is not finite, or text that is not printable",
                  place(where, *faults));
    std::ostringstream out;
    write_entries(out, *faults->as_table());
    rig.faults_toml = out.str();
  }
  return rig;
}

Result<Rig> read_rig(const std::filesystem::path& path) {
  MIEN_TRY_ASSIGN(const std::string content, mien::read_text(path, kMaxRigBytes));
  return parse_rig(content, path.string());
}

std::string write_skin(const SkinMotion& skin) {
  // Shortest digits that read back to equal numbers; adding nought takes the sign of a negative nought.
  toml::array names;
  for (const std::string& name : skin.sensors) names.push_back(name);
  std::ostringstream head;
  line(head, "sensors", names);
  std::string out = fmt::format("[skin]\n{}mean_deg = [\n", head.str());
  for (Eigen::Index i = 0; i + 2 < skin.mean_deg.size(); i += 3)
    out += fmt::format("  {}, {}, {},\n", skin.mean_deg[i] + 0.0, skin.mean_deg[i + 1] + 0.0,
                       skin.mean_deg[i + 2] + 0.0);
  out += "]\nfactor_deg = [\n";
  for (Eigen::Index r = 0; r < skin.factor_deg.rows(); ++r) {
    const Eigen::VectorXd row = skin.factor_deg.row(r).head(r + 1).array() + 0.0;
    out += fmt::format("  [{}],\n", fmt::join(row.begin(), row.end(), ", "));
  }
  return out + "]\n";
}

std::string write_rig(const Rig& rig) {
  std::ostringstream out;
  line(out, "name", rig.name);
  line(out, "reference", rig.reference);
  for (const Mount& mount : rig.sensors) {
    out << "\n[[sensor]]\n";
    line(out, "name", mount.name);
    line(out, "kind", mount.kind);
    if (!mount.site.empty()) line(out, "site", mount.site);
    line(out, "side", std::string(1, mount.side));
    line(out, "role", mount.role);
    if (!mount.device.empty()) line(out, "device", mount.device);
    if (mount.ict_vertex >= 0) line(out, "ict_vertex", static_cast<std::int64_t>(mount.ict_vertex));
    if (mount.position_m) line(out, "position_m", numbers(*mount.position_m));
    if (mount.outward) line(out, "outward", numbers(*mount.outward));
    if (mount.aim) line(out, "aim", numbers(*mount.aim));
    if (mount.recentre) line(out, "recentre", true);
    if (!mount.hears_by.empty()) line(out, "hears_by", mount.hears_by);
    if (mount.camera) line(out, "camera", camera_table(*mount.camera));
  }
  if (rig.skin) out << '\n' << write_skin(*rig.skin);
  if (!rig.faults_toml.empty()) {
    // Its own tables stand in braces, so that the text needs no other heading.
    out << "\n[faults]\n" << rig.faults_toml;
  }
  return out.str();
}

}  // namespace mien::sensor
