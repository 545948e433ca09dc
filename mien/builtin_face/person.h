#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mien/builtin_face/builtin_face.h"
#include "mien/core/error.h"

namespace mien::builtin_face {

/// A performer of documents and demonstrations: always the same person under this name.
struct NamedPerformer {
  std::string name;         ///< Lower case.
  std::string description;  ///< A line for people.
  BuiltinParameters parameters;
};

/// All of them (performers.toml), by the alphabet.
[[nodiscard]] std::span<const NamedPerformer> named_performers();

/// Who is meant, and a line for each value that was beyond what people have (builtin_face/held.h).
struct Person {
  BuiltinParameters parameters;
  std::vector<std::string> said;
};

/// Whether `what` names somebody of the built-in family: "builtin", or that, a colon or comma, and more.
[[nodiscard]] bool names_person(std::string_view what);

/// Whom "builtin" (the default face, cropped), "builtin:7" (the person whom that seed draws) or "builtin:ada"
/// (a named performer) mean; values of BuiltinParameters may follow and replace theirs:
/// "builtin:ada,age_years=70,nose_width=2,hair=bob". Errors: bad_usage (no such performer, value or cut; a
/// number that is no seed; a value that is no finite number, or is given twice).
[[nodiscard]] Result<Person> find_person(std::string_view what);

}  // namespace mien::builtin_face
