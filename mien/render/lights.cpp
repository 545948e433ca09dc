#include "mien/render/lights.h"

#include <algorithm>
#include <vector>

#include "mien/core/toml.h"

namespace mien::render {

extern const std::string_view kLightsToml;  // lights.toml.

namespace {

using TomlNode = toml::node_view<const toml::node>;

Vec3f read_numbers(const TomlNode& list) {
  return Vec3(list[0].value_or(0.0), list[1].value_or(0.0), list[2].value_or(0.0)).cast<float>();
}

Look::Light read_lamp(const TomlNode& table) {
  if (!table) return {};
  return {read_numbers(table["towards"]).normalized(), read_numbers(table["radiance"]),
          static_cast<float>(table["radius_rad"].value_or(0.0))};
}

NamedLight read_light(const toml::table& table) {
  const auto colour = [&table](std::size_t end) {
    const Vec3f bytes = read_numbers(table["background"][end]);
    return Rgb{static_cast<std::uint8_t>(bytes[0]), static_cast<std::uint8_t>(bytes[1]),
               static_cast<std::uint8_t>(bytes[2])};
  };
  return {.name = table["name"].value_or(std::string()),
          .description = table["description"].value_or(std::string()),
          .look = {.key = read_lamp(table["key"]),
                   .fill = read_lamp(table["fill"]),
                   .rim = read_lamp(table["rim"]),
                   .sky = read_numbers(table["sky"]),
                   .ground = read_numbers(table["ground"]),
                   .background_top = colour(0),
                   .background_bottom = colour(1),
                   .infrared = table["infrared"].value_or(false)}};
}

}  // namespace

std::span<const NamedLight> named_lights() {
  // Of a file that the tests hold to be sound.
  static const std::vector<NamedLight> all = [] {
    const toml::table file = parse_toml(kLightsToml, "lights.toml").value();
    std::vector<NamedLight> lights;
    for (const toml::node& table : *file["light"].as_array()) lights.push_back(read_light(*table.as_table()));
    return lights;
  }();
  return all;
}

const NamedLight* find_light(std::string_view name) {
  const auto all = named_lights();
  const auto found = std::ranges::find(all, name, &NamedLight::name);
  return found == all.end() ? nullptr : &*found;
}

}  // namespace mien::render
