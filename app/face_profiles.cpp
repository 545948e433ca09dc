#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "app/command.h"
#include "app/json_output.h"
#include "mien/face/profile_map.h"

namespace mien::app {
namespace {

using face::ProfileMap;

struct ProfilesArguments {
  std::string name;
  bool json = false;
};

/// Inner shapes that the profile tells.
std::size_t told_count(const ProfileMap& map) {
  return face::kInnerCount - map.lacks.size();
}

/// How much of an inner shape is read back from one of the profile's: 0 where the way back does not read it.
float factor_back(const ProfileMap& map, std::size_t inner, std::size_t shape) {
  for (const face::ProfileTerm& term : map.inward[inner])
    if (term.column == shape) return term.factor;
  return 0;
}

std::string_view reason_of(const ProfileMap& map, std::size_t shape) {
  for (const face::Unmatched& without : map.without)
    if (without.shape == shape) return without.reason;
  return {};
}

Json describe_profile(const ProfileMap& map) {
  Json json;
  json["name"] = map.name;
  json["title"] = map.title;
  json["source"] = map.source;
  json["shapes"] = map.shapes.size();
  json["matched"] = map.shapes.size() - map.without.size();
  json["inner_told"] = told_count(map);
  json["merged"] = map.merged_count();
  json["divided"] = map.divided_count();
  json["groups"] = Json::array();
  for (const face::ShapeGroup& group : map.groups)
    json["groups"].push_back({{"name", group.name}, {"shapes", group.count}});
  json["without_counterpart"] = Json::array();
  for (const face::Unmatched& without : map.without)
    json["without_counterpart"].push_back({{"shape", map.shapes[without.shape]}, {"reason", without.reason}});
  json["inner_lacking"] = Json::array();
  for (const face::Unmatched& lack : map.lacks)
    json["inner_lacking"].push_back({{"shape", face::inner_name(lack.shape)}, {"reason", lack.reason}});
  return json;
}

/// A row a shape: what it is of ours, and what ours are of it.
Json describe_shapes(const ProfileMap& map) {
  Json rows = Json::array();
  for (std::size_t i = 0; i < map.shapes.size(); ++i) {
    Json row = {{"shape", map.shapes[i]}};
    if (!map.groups.empty()) row["group"] = map.group_of(i);
    row["inner"] = Json::array();
    for (const face::ProfileTerm& term : map.outward[i])
      row["inner"].push_back({{"shape", face::inner_name(term.column)},
                              {"factor", term.factor},
                              {"factor_back", factor_back(map, term.column, i)}});
    if (const std::string_view reason = reason_of(map, i); !reason.empty()) row["reason"] = reason;
    rows.push_back(std::move(row));
  }
  return rows;
}

/// Names of one reason in one line.
template <class NameOf>
void print_unmatched(std::span<const face::Unmatched> list, NameOf name_of) {
  for (std::size_t i = 0; i < list.size();) {
    std::vector<std::string_view> names;
    const std::string_view reason = list[i].reason;
    for (; i < list.size() && list[i].reason == reason; ++i) names.push_back(name_of(list[i].shape));
    fmt::print("    {}: {}\n", fmt::join(names, ", "), reason);
  }
}

void print_profile(const ProfileMap& map) {
  fmt::print("{}: {}\n", map.name, map.title);
  fmt::print("  source: {}\n", map.source);
  fmt::print("  {} of its {} shapes have a counterpart, and tell {} of {} inner ones\n",
             map.shapes.size() - map.without.size(), map.shapes.size(), told_count(map), face::kInnerCount);
  if (map.merged_count() > 0)
    fmt::print("  {} of its shapes are the mean of several inner ones\n", map.merged_count());
  if (map.divided_count() > 0) fmt::print("  {} inner shapes become several of its\n", map.divided_count());
  if (!map.groups.empty()) {
    std::vector<std::string> groups;
    for (const face::ShapeGroup& group : map.groups)
      groups.push_back(fmt::format("{} {}", group.count, group.name));
    fmt::print("  groups: {}\n", fmt::join(groups, ", "));
  }
  if (!map.without.empty()) {
    fmt::print("  without a counterpart inside:\n");
    print_unmatched(map.without, [&](std::size_t i) { return map.shapes[i]; });
  }
  if (!map.lacks.empty()) {
    fmt::print("  inner shapes that it cannot tell:\n");
    print_unmatched(map.lacks, face::inner_name);
  }
}

void print_shapes(const ProfileMap& map) {
  fmt::print("\n{:<26} {:<10} {:<18} {:>6} {:>6}\n", "shape", map.groups.empty() ? "" : "group", "inner",
             "of it", "back");
  for (std::size_t i = 0; i < map.shapes.size(); ++i) {
    std::string_view shape = map.shapes[i];
    std::string_view group = map.group_of(i);
    if (map.outward[i].empty()) fmt::print("{:<26} {:<10} none\n", shape, group);
    for (const face::ProfileTerm& term : map.outward[i]) {
      fmt::print("{:<26} {:<10} {:<18} {:>6.3g} {:>6.3g}\n", shape, group, face::inner_name(term.column),
                 term.factor, factor_back(map, term.column, i));
      shape = group = {};
    }
  }
}

Result<void> show_profiles(const ProfilesArguments& arguments) {
  if (!arguments.name.empty()) {
    MIEN_TRY_ASSIGN(const ProfileMap* const map, face::find_profile_map(arguments.name));
    if (arguments.json) {
      Json json = describe_profile(*map);
      json["table"] = describe_shapes(*map);
      print_json(json);
    } else {
      print_profile(*map);
      print_shapes(*map);
    }
    return {};
  }
  Json json;
  json["profiles"] = Json::array();
  for (const ProfileMap& map : face::profile_maps()) {
    if (arguments.json) {
      json["profiles"].push_back(describe_profile(map));
    } else {
      if (&map != face::profile_maps().data()) fmt::print("\n");
      print_profile(map);
    }
  }
  if (arguments.json) print_json(json);
  return {};
}

}  // namespace

void add_face_profiles_command(Commands& commands, Command face) {
  const auto arguments = std::make_shared<ProfilesArguments>();
  const Command profiles = commands.add_under(
      face, "profiles",
      "Lists the shape sets of other programs: what each has of our 53 shapes and the "
      "tongue, and what has no counterpart, with the reason",
      "mien face profiles openxr_fb_70", [arguments] { return show_profiles(*arguments); });
  profiles.add_option("name", arguments->name, "One of them, with its table shape by shape; all unless told");
  add_json_flag(profiles, arguments->json);
}

}  // namespace mien::app
