#include "mien/builtin_face/person.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "mien/builtin_face/held.h"
#include "mien/core/nearest_word.h"
#include "mien/core/toml.h"

namespace mien::builtin_face {

extern const std::string_view kPerformersToml;  // performers.toml.

namespace {

constexpr std::string_view kFamily = "builtin";

std::unexpected<Error> unknown(std::string_view kind, std::string_view word,
                               std::span<const std::string> known) {
  const std::string near = did_you_mean(word, known);
  return fail(ErrorCode::bad_usage, fmt::format("there is no {} '{}'{}", kind, word.substr(0, 40), near), {},
              near.empty() ? fmt::format("there are {}", fmt::join(known, ", ")) : "");
}

template <class Number>
bool read_whole(std::string_view text, Number& value) {
  const auto [stop, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
  return problem == std::errc() && stop == text.data() + text.size();
}

/// kHairStyleCount where no cut has that name.
std::size_t cut_named(std::string_view name) {
  return static_cast<std::size_t>(std::ranges::find(kHairStyleNames, name) - kHairStyleNames.begin());
}

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

Result<BuiltinParameters> who(std::string_view name) {
  std::uint64_t seed = 0;
  if (read_whole(name, seed)) {
    Random random(seed);
    return random_identity(random);
  }
  // "-1", "1.5", too many digits: no name is like that.
  if (const std::size_t at = name.find_first_not_of("+-."); at < name.size() && is_digit(name[at]))
    return fail(
        ErrorCode::bad_usage, fmt::format("'{}' is no seed of a person", name.substr(0, 40)), {},
        fmt::format("a seed is a whole number from 0 to {}", std::numeric_limits<std::uint64_t>::max()));
  std::vector<std::string> known;
  for (const NamedPerformer& performer : named_performers()) {
    if (performer.name == name) return performer.parameters;
    known.emplace_back(performer.name);
  }
  return unknown("performer", name, known);
}

/// One "name=value".
Result<void> set_value(BuiltinParameters& parameters, std::string_view entry) {
  const std::size_t equals = std::min(entry.find('='), entry.size());
  const std::string_view name = entry.substr(0, equals),
                         text = entry.substr(std::min(equals + 1, entry.size()));
  if (name == "hair") {
    if (const std::size_t cut = cut_named(text); cut < kHairStyleCount) {
      parameters.hair = static_cast<HairStyle>(cut);
      return {};
    }
    return unknown("cut of hair", text,
                   std::vector<std::string>(kHairStyleNames.begin(), kHairStyleNames.end()));
  }
  std::vector<std::string> known = {"hair"};
  for (const ParameterRange& range : parameter_ranges()) {
    known.emplace_back(range.name);
    if (range.name != name) continue;
    double value = 0;
    if (!read_whole(text, value) || !std::isfinite(value))
      return fail(ErrorCode::bad_usage, fmt::format("'{}' has no number", entry.substr(0, 40)), {},
                  fmt::format("write it like {}={:g}", name, range.most));
    parameters.*range.value = value;
    return {};
  }
  return unknown("value", name, known);
}

Result<Person> read_person(std::string_view what) {
  Person person{.parameters = {.hair = HairStyle::crop}, .said = {}};
  if (what == kFamily) return person;
  what.remove_prefix(std::min(what.size(), kFamily.size() + 1));
  bool first = true;
  std::vector<std::string_view> given;
  while (first || !what.empty()) {
    const std::size_t comma = std::min(what.find(','), what.size());
    const std::string_view entry = what.substr(0, comma);
    what.remove_prefix(std::min(what.size(), comma + 1));
    if (first && entry.find('=') == std::string_view::npos) {
      MIEN_TRY_ASSIGN(person.parameters, who(entry));
    } else {
      MIEN_TRY(set_value(person.parameters, entry));
      const std::string_view name = entry.substr(0, entry.find('='));
      if (std::ranges::find(given, name) != given.end())
        return fail(ErrorCode::bad_usage, fmt::format("{} is given twice", name), {}, "give it once");
      given.push_back(name);
    }
    first = false;
  }
  person.parameters = held(person.parameters, &person.said);
  return person;
}

NamedPerformer read_performer(std::string_view name, const toml::table& table) {
  NamedPerformer performer{.name = std::string(name), .description = {}, .parameters = {}};
  BuiltinParameters& parameters = performer.parameters;
  for (const auto& [key, value] : table) {
    const auto range = std::ranges::find(parameter_ranges(), key.str(), &ParameterRange::name);
    if (range != parameter_ranges().end())
      parameters.*range->value = value.value<double>().value();
    else if (key == "asymmetry_seed")
      parameters.asymmetry_seed = value.value<std::uint64_t>().value();
    else if (key == "hair")
      parameters.hair = static_cast<HairStyle>(cut_named(value.value<std::string_view>().value()));
    else
      performer.description = value.value<std::string>().value();
  }
  return performer;
}

}  // namespace

std::span<const NamedPerformer> named_performers() {
  // Of a file that the tests hold to be sound; a table of TOML has its keys by the alphabet.
  static const std::vector<NamedPerformer> all = [] {
    const toml::table file = parse_toml(kPerformersToml, "performers.toml").value();
    std::vector<NamedPerformer> performers;
    for (const auto& [name, table] : file) performers.push_back(read_performer(name, *table.as_table()));
    return performers;
  }();
  return all;
}

bool names_person(std::string_view what) {
  if (!what.starts_with(kFamily)) return false;
  const std::string_view rest = what.substr(kFamily.size());
  return rest.empty() || rest.starts_with(':') || rest.starts_with(',');
}

Result<Person> find_person(std::string_view what) {
  Result<Person> person = read_person(what);
  if (!person) person.error().where = std::string(what);
  return person;
}

}  // namespace mien::builtin_face
