#include "mien/sensor/rig_views.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "mien/core/excerpt.h"
#include "mien/core/files.h"
#include "mien/core/toml.h"
#include "mien/sensor/rig.h"

namespace mien::sensor {
namespace {

/// A part of the text that another one is put in place of.
struct Edit {
  std::size_t begin = 0;
  std::size_t end = 0;
  std::string text;
};

/// Where each line of a text begins, and where the text ends.
std::vector<std::size_t> line_begins(std::string_view text) {
  std::vector<std::size_t> begins{0};
  for (std::size_t i = 0; i < text.size(); ++i)
    if (text[i] == '\n') begins.push_back(i + 1);
  begins.push_back(text.size());
  return begins;
}

/// Of a place of parse_toml(), whose lines are plain ASCII but for comments, which stand behind all else.
std::size_t offset_of(const toml::source_position& place, const std::vector<std::size_t>& begins) {
  const std::size_t line = std::clamp<std::size_t>(place.line, 1, begins.size()) - 1;
  return std::min(begins[line] + std::max<std::size_t>(place.column, 1) - 1, begins.back());
}

const toml::table* find_camera(const toml::table& root, std::string_view sensor) {
  const toml::array* const sensors = root["sensor"].as_array();
  if (sensors == nullptr) return nullptr;
  for (const toml::node& node : *sensors) {
    const toml::table* const mount = node.as_table();
    if (mount != nullptr && (*mount)["name"].value_or(std::string_view()) == sensor)
      return (*mount)["camera"].as_table();
  }
  return nullptr;
}

Result<void> add_edits(std::string_view text, const std::vector<std::size_t>& begins,
                       const toml::table& camera, const PictureView& view, const std::string& where,
                       std::vector<Edit>& edits) {
  // New keys stand below the heading, where they are this table's whatever follows.
  const std::size_t heading = offset_of(camera.source().begin, begins);
  const std::size_t below = std::min(text.find('\n', heading), text.size());
  if (text.substr(heading, 1) != "[" || below == text.size())
    return fail(ErrorCode::unsupported, "a camera without a heading of its own", place(where, camera),
                "write it as [sensor.camera], its keys below");
  const std::pair<std::string_view, std::string> values[] = {
      {"crop", fmt::format("[{}]", fmt::join(view.crop, ", "))},
      {"turn_deg", fmt::format("{}", view.turn_deg)},
      {"mirror", view.mirror ? "true" : "false"}};
  const PictureView unsaid;
  std::string added;
  for (const auto& [key, value] : values) {
    if (const toml::node* const node = camera.get(key); node != nullptr) {
      const toml::source_region& there = node->source();
      edits.push_back({offset_of(there.begin, begins), offset_of(there.end, begins), value});
    } else if ((key == "crop" && view.crop != unsaid.crop) ||
               (key == "turn_deg" && view.turn_deg != unsaid.turn_deg) || (key == "mirror" && view.mirror)) {
      added += fmt::format("{} = {}\n", key, value);
    }
  }
  edits.push_back({below + 1, below + 1, std::move(added)});
  return {};
}

}  // namespace

Result<std::string> with_views(std::string_view toml_text, std::span<const SensorView> views,
                               const std::string& where) {
  MIEN_TRY_ASSIGN(Rig wanted, parse_rig(toml_text, where));
  MIEN_TRY_ASSIGN(const toml::table root, parse_toml(toml_text, where));
  const std::vector<std::size_t> begins = line_begins(toml_text);
  std::vector<Edit> edits;
  for (const SensorView& one : views) {
    const auto number = wanted.find(one.sensor);
    const toml::table* const camera = find_camera(root, one.sensor);
    if (!number || camera == nullptr || !wanted.sensors[*number].camera)
      return fail(ErrorCode::not_found,
                  fmt::format("the file has no camera \"{}\" any more", excerpt(one.sensor)), where,
                  "start the session anew with the rig as it is now");
    CameraMount& mount = *wanted.sensors[*number].camera;
    if (view_of(mount) == one.view) continue;
    set_view(mount, one.view);
    MIEN_TRY(add_edits(toml_text, begins, *camera, one.view, where, edits));
  }
  std::string out(toml_text);
  // From the end, so that places before it stay what they are.
  std::ranges::sort(edits, std::ranges::greater(), &Edit::begin);
  for (const Edit& edit : edits) out.replace(edit.begin, edit.end - edit.begin, edit.text);
  const auto back = parse_rig(out, where);
  if (!back || write_rig(*back) != write_rig(wanted))
    return fail(ErrorCode::internal, "the views do not fit into the file as it is written", where,
                "write crop, turn_deg and mirror into it by hand");
  return out;
}

Result<void> write_views(const std::filesystem::path& rig, std::span<const SensorView> views) {
  MIEN_TRY_ASSIGN(const std::string before, read_text(rig));
  MIEN_TRY_ASSIGN(const std::string after, with_views(before, views, rig.string()));
  if (after == before) return {};
  return write_file(rig, after);
}

}  // namespace mien::sensor
