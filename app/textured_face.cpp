#include "app/textured_face.h"

#include <string_view>

#include "app/chosen_face.h"
#include "mien/builtin_face/builtin_face.h"

namespace mien::app {

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
