#include "app/chosen_face.h"

#include <cstdio>

#include "app/command.h"
#include "mien/builtin_face/correctives.h"
#include "mien/builtin_face/load_face.h"
#include "mien/builtin_face/person.h"
#include "mien/builtin_face/skin_marks.h"

namespace mien::app {

using builtin_face::Person;

Result<face::Face> chosen_face(const std::string& what, const Progress& progress) {
  if (builtin_face::names_person(what)) {
    MIEN_TRY_ASSIGN(const Person person, builtin_face::find_person(what));
    for (const std::string& line : person.said) fmt::print(stderr, "{}: {}\n", one_line(what), line);
    return builtin_face::make_builtin(person.parameters);
  }
  return builtin_face::load_face(what, progress);
}

Result<face::Face> chosen_infrared_face(const std::string& what) {
  if (!builtin_face::names_person(what))
    return fail(ErrorCode::unsupported, "only the built-in faces have colours in infrared", what,
                "choose another --light, or --face builtin");
  MIEN_TRY_ASSIGN(face::Face face, chosen_face(what));
  MIEN_TRY_ASSIGN(const Person person, builtin_face::find_person(what));
  builtin_face::paint_infrared(face, person.parameters);
  return face;
}

Result<std::vector<face::Corrective>> correctives_of(const std::string& what, const face::Face& face) {
  if (!builtin_face::names_person(what)) return std::vector<face::Corrective>{};
  MIEN_TRY_ASSIGN(const Person person, builtin_face::find_person(what));
  return builtin_face::make_correctives(face, person.parameters);
}

Result<face::SkinFolds> skin_folds_of(const std::string& what) {
  if (!builtin_face::names_person(what)) return face::SkinFolds{};
  MIEN_TRY_ASSIGN(const Person person, builtin_face::find_person(what));
  return builtin_face::skin_folds(person.parameters);
}

Progress face_progress(const std::string& what) {
  return builtin_face::names_person(what) ? Progress(no_progress) : terminal_progress("reading the face");
}

Result<face::SkinMarks> skin_marks_of(const std::string& what, const face::Face& face) {
  if (!builtin_face::names_person(what)) return face::SkinMarks{};
  MIEN_TRY_ASSIGN(const Person person, builtin_face::find_person(what));
  return builtin_face::skin_marks(person.parameters, face);
}

}  // namespace mien::app
