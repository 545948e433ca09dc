#include "app/names_option.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "app/command.h"
#include "app/one_line.h"
#include "mien/core/nearest_word.h"

namespace mien::app {

Option add_names_option(Command command, std::string& names) {
  const auto check = [](const std::string& word) -> std::string {
    static const std::vector<std::string> known = {"ict", "arkit", "unified", "vrm"};
    if (std::ranges::find(known, word) != known.end()) return {};
    const std::string near = did_you_mean(word, known);
    return fmt::format("there are no names '{}'{}", one_line(word, 40),
                       near.empty() ? "; there are ict, arkit, unified and vrm" : near);
  };
  return command
      .add_option("--names", names,
                  "Names of the morph targets in glTF: ict (ours), arkit (Apple's 52), unified (Unified "
                  "Expressions) or vrm (ARKit's, and an avatar by VRM 1.0: bones, expressions, look-at; what "
                  "a .vrm is unless told otherwise)")
      .check(check, "ict, arkit, unified or vrm");
}

Option add_textures_option(Command command, std::string& textures) {
  const auto check = [](const std::string& word) -> std::string {
    static const std::vector<std::string> known = {"none", "1024", "2048"};
    if (std::ranges::find(known, word) != known.end()) return {};
    const std::string near = did_you_mean(word, known);
    return fmt::format("there are no textures '{}'{}", one_line(word, 40),
                       near.empty() ? "; there are none, 1024 and 2048" : near);
  };
  return command
      .add_option(
          "--textures", textures,
          "Pixels a side of the pictures of skin, lips and eyes in glTF, with pores, freckles, moles and "
          "stubble; none: colours at the vertices (default: 2048 for built-in faces, none for others)")
      .check(check, "none, 1024 or 2048");
}

render::GltfNames gltf_names(const std::string& names, const std::filesystem::path& file) {
  if (names == "arkit") return render::GltfNames::arkit;
  if (names == "unified") return render::GltfNames::unified;
  if (names == "vrm" || (names.empty() && file.extension() == ".vrm")) return render::GltfNames::vrm;
  return render::GltfNames::ict;
}

Result<void> check_gltf_output(const std::filesystem::path& file, render::GltfNames names,
                               const std::string& other) {
  if (names == render::GltfNames::vrm) return check_output(file, {".vrm", ".glb"});
  if (file.extension() == ".vrm")
    return fail(ErrorCode::bad_usage, "an avatar has VRM's names", file.string(),
                "leave --names out, or name it .glb");
  return check_output(file, {other, ".glb", ".gltf", ".vrm"});
}

}  // namespace mien::app
