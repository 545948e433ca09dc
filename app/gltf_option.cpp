#include "app/gltf_option.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "app/chosen_face.h"
#include "app/command.h"
#include "mien/builtin_face/builtin_face.h"
#include "mien/core/nearest_word.h"

namespace mien::app {
namespace {

/// A check of a word against those that are known; `what` are they, as in "there are no names 'x'".
auto one_of(std::string what, std::vector<std::string> known) {
  return [what = std::move(what), known = std::move(known)](const std::string& word) -> std::string {
    if (std::ranges::find(known, word) != known.end()) return {};
    const std::string near = did_you_mean(word, known);
    const std::string all =
        fmt::format("; there are {} and {}", fmt::join(known.begin(), known.end() - 1, ", "), known.back());
    return fmt::format("there are no {} '{}'{}", what, one_line(word, 40), near.empty() ? all : near);
  };
}

}  // namespace

Option add_names_option(Command command, std::string& names) {
  return command
      .add_option("--names", names,
                  "Names of the morph targets in glTF: ict (ours), arkit (Apple's 52), unified (Unified "
                  "Expressions) or vrm (ARKit's, and an avatar by VRM 1.0: bones, expressions, look-at; what "
                  "a .vrm is unless told otherwise)")
      .check(one_of("names", {"ict", "arkit", "unified", "vrm"}), "ict, arkit, unified or vrm");
}

Option add_textures_option(Command command, std::string& textures) {
  return command
      .add_option(
          "--textures", textures,
          "Pixels a side of the pictures of skin, lips and eyes in glTF, with pores, freckles, moles and "
          "stubble; none: colours at the vertices (default: 2048 for built-in faces, none for others)")
      .check(one_of("textures", {"none", "1024", "2048"}), "none, 1024 or 2048");
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

Result<TexturedFace> textured_face(const std::string& what, const std::string& option,
                                   const Progress& progress) {
  TexturedFace made;
  MIEN_TRY_ASSIGN(made.face, chosen_face(what, progress));
  // A receiver shows the name: a performer's, or who else was asked for.
  constexpr std::string_view kFamily = "builtin:";
  if (what.starts_with(kFamily)) made.face.name = what.substr(kFamily.size());
  const bool builtin = made.face.origin == face::Origin::builtin;
  if (option == "none" || (option.empty() && !builtin)) return made;
  if (!builtin)
    return fail(ErrorCode::bad_usage, "textures are made of built-in faces only", "--textures " + option,
                "choose --face builtin, or --textures none");
  made.textures.side_px = option == "1024" ? 1024 : 2048;
  builtin_face::lay_out_textures(made.face);
  MIEN_TRY_ASSIGN(made.textures.marks, skin_marks_of(what, made.face));
  return made;
}

}  // namespace mien::app
