#include "mien/speech/visemes.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "mien/core/excerpt.h"
#include "mien/core/toml.h"
#include "mien/face/shape_region.h"

namespace mien::speech {

extern const std::string_view kVisemesToml;  // rigs/visemes.toml.

namespace {

/// How a class of sounds comes and goes.
struct Manner {
  double onset_s = 0, release_s = 0;
  float jaw = 0, lips = 0;
};
using Manners = std::map<std::string, Manner, std::less<>>;

Result<double> number(const toml::table& table, std::string_view key, double low, double high,
                      const std::string& where) {
  const toml::node* node = table.get(key);
  const auto value = node == nullptr ? std::nullopt : node->value<double>();
  if (!value)
    return fail(ErrorCode::malformed, fmt::format("'{}' is missing, or no number", key), place(where, table));
  if (!(*value >= low && *value <= high))
    return fail(ErrorCode::out_of_range, fmt::format("'{}' is {}", key, *value), place(where, *node),
                fmt::format("give {} to {}", low, high));
  return *value;
}

Result<Manners> read_classes(const toml::table& root, const std::string& where) {
  const toml::table* classes = root["class"].as_table();
  if (classes == nullptr) return fail(ErrorCode::malformed, "there are no classes of sounds", where);
  Manners out;
  constexpr double kLeast_ms = 5, kMost_ms = 500;
  for (const auto& [name, node] : *classes) {
    const toml::table* table = node.as_table();
    if (table == nullptr) return fail(ErrorCode::malformed, "a class is no table", place(where, node));
    MIEN_TRY(only_keys(*table, {"onset_ms", "release_ms", "jaw", "lips"}, where));
    MIEN_TRY_ASSIGN(const double onset_ms, number(*table, "onset_ms", kLeast_ms, kMost_ms, where));
    MIEN_TRY_ASSIGN(const double release_ms, number(*table, "release_ms", kLeast_ms, kMost_ms, where));
    MIEN_TRY_ASSIGN(const double jaw, number(*table, "jaw", 0, 1, where));
    MIEN_TRY_ASSIGN(const double lips, number(*table, "lips", 0, 1, where));
    out[std::string(name.str())] = {1e-3 * onset_ms, 1e-3 * release_ms, static_cast<float>(jaw),
                                    static_cast<float>(lips)};
  }
  return out;
}

/// The shapes that a name means: itself, or both sides.
std::vector<std::size_t> shapes_named(std::string_view name) {
  std::vector<std::size_t> out;
  for (const std::string& whole : {std::string(name), std::string(name) + "_L", std::string(name) + "_R"})
    if (const std::size_t shape = face::shape_index(whole); shape < face::kShapeCount) out.push_back(shape);
  return out;
}

/// Mouth and jaw, but for what follows from a closure.
bool tells(std::size_t shape) {
  const face::ShapeRegion region = face::kShapeRegions[shape];
  return (region == face::ShapeRegion::mouth || region == face::ShapeRegion::jaw) &&
         shape != face::shape("mouthClose");
}

Result<void> read_weights(const toml::table& table, const std::string& where, Viseme& out) {
  const toml::table* weights = table["weights"].as_table();
  if (weights == nullptr) return fail(ErrorCode::malformed, "a viseme has no weights", place(where, table));
  std::array<bool, face::kShapeCount> given{};
  for (const auto& [key, node] : *weights) {
    const std::string name(key.str());
    const std::vector<std::size_t> shapes = shapes_named(name);
    if (shapes.empty())
      return fail(ErrorCode::malformed, fmt::format("no shape is called '{}'", excerpt(name)),
                  place(where, node));
    MIEN_TRY_ASSIGN(const double weight, number(*weights, name, 0, 1, where));
    for (const std::size_t shape : shapes) {
      if (!tells(shape))
        return fail(ErrorCode::malformed, fmt::format("sound does not tell of '{}'", excerpt(name)),
                    place(where, node), "name shapes of mouth and jaw; `closes` makes mouthClose");
      if (std::exchange(given[shape], true))
        return fail(ErrorCode::malformed, fmt::format("'{}' is told twice", face::kShapeNames[shape]),
                    place(where, node));
      out.weights[shape] = static_cast<float>(weight);
    }
  }
  return {};
}

Result<std::size_t> viseme_named(std::string_view name, const std::string& where) {
  const auto found = std::ranges::find(kVisemeNames, name);
  if (found == kVisemeNames.end() || found == kVisemeNames.begin())
    return fail(ErrorCode::malformed, fmt::format("no viseme is called '{}'", excerpt(name)), where,
                "names are those of OpenXR, as PP");
  return static_cast<std::size_t>(found - kVisemeNames.begin());
}

/// The names in a list of texts.
Result<std::vector<std::string>> names_in(const toml::table& table, std::string_view key,
                                          const std::string& where) {
  const toml::array* array = table[key].as_array();
  if (array == nullptr)
    return fail(ErrorCode::malformed, fmt::format("'{}' is no list", key), place(where, table));
  std::vector<std::string> out;
  for (const toml::node& node : *array) {
    const auto name = node.value_exact<std::string>();
    if (!name || name->empty())
      return fail(ErrorCode::malformed, fmt::format("'{}' holds what is no name", key), place(where, node));
    out.push_back(*name);
  }
  return out;
}

}  // namespace

VisemeParts Visemes::find(const std::vector<Named>& sounds, std::string_view name) {
  const auto found = std::ranges::lower_bound(sounds, name, {}, &Named::name);
  return found != sounds.end() && found->name == name ? VisemeParts(found->parts) : VisemeParts();
}

VisemeParts Visemes::of_arpabet(std::string_view symbol) const {
  return find(arpabet_, symbol);
}

VisemeParts Visemes::of_ipa(std::string_view letter) const {
  return find(ipa_, letter);
}

const Visemes& Visemes::standard() {
  // A table that does not parse stops the program's tests, and so never gets here.
  static const Visemes visemes = parse(kVisemesToml, "rigs/visemes.toml").value();
  return visemes;
}

Result<Visemes> Visemes::parse(std::string_view text, const std::string& where) {
  MIEN_TRY_ASSIGN(const toml::table root, parse_toml(text, where));
  MIEN_TRY(only_keys(root, {"class", "viseme", "diphthong"}, where));
  MIEN_TRY_ASSIGN(const Manners manners, read_classes(root, where));
  Visemes out;
  std::array<bool, kVisemeCount> told{};
  const toml::array* list = root["viseme"].as_array();
  if (list == nullptr || !list->is_homogeneous(toml::node_type::table))
    return fail(ErrorCode::malformed, "there are no visemes", where, "add [[viseme]]");
  for (const toml::node& node : *list) {
    const toml::table& table = *node.as_table();
    const std::string here = place(where, node);
    MIEN_TRY(only_keys(table, {"name", "class", "closes", "arpabet", "ipa", "weights", "tongue"}, where));
    MIEN_TRY_ASSIGN(const std::size_t number_of,
                    viseme_named(table["name"].value_or(std::string_view()), here));
    if (std::exchange(told[number_of], true))
      return fail(ErrorCode::malformed, fmt::format("{} is told twice", kVisemeNames[number_of]), here);
    Viseme& viseme = out.visemes_[number_of];
    const auto manner = manners.find(table["class"].value_or(std::string_view()));
    if (manner == manners.end()) return fail(ErrorCode::malformed, "'class' names no class of sounds", here);
    viseme.onset_s = manner->second.onset_s;
    viseme.release_s = manner->second.release_s;
    viseme.jaw = manner->second.jaw;
    viseme.lips = manner->second.lips;
    if (const toml::node* closes = table.get("closes")) {
      const auto value = closes->value_exact<bool>();
      if (!value)
        return fail(ErrorCode::malformed, "'closes' is neither true nor false", place(where, *closes));
      viseme.closes = *value;
    }
    if (table.contains("tongue")) {
      MIEN_TRY_ASSIGN(const double tongue, number(table, "tongue", 0, 1, where));
      viseme.tongue = static_cast<float>(tongue);
    }
    MIEN_TRY(read_weights(table, where, viseme));
    const VisemePart whole{static_cast<std::uint8_t>(number_of), 1};
    MIEN_TRY_ASSIGN(const std::vector<std::string> symbols, names_in(table, "arpabet", where));
    for (const std::string& name : symbols) out.arpabet_.push_back({name, {whole}});
    MIEN_TRY_ASSIGN(const std::vector<std::string> letters, names_in(table, "ipa", where));
    for (const std::string& name : letters) out.ipa_.push_back({name, {whole}});
  }
  for (std::size_t v = 1; v < kVisemeCount; ++v)
    if (!told[v]) return fail(ErrorCode::malformed, fmt::format("{} is not told", kVisemeNames[v]), where);
  if (root.contains("diphthong") && !root["diphthong"].is_table())
    return fail(ErrorCode::malformed, "'diphthong' is no table", where);
  if (const toml::table* diphthongs = root["diphthong"].as_table()) {
    constexpr double kFirst = 0.6;  // Rhubarb's rule: docs/method/speech.md.
    for (const auto& [symbol, node] : *diphthongs) {
      MIEN_TRY_ASSIGN(const std::vector<std::string> names, names_in(*diphthongs, symbol.str(), where));
      if (names.size() != 2)
        return fail(ErrorCode::malformed, "a diphthong is of two visemes", place(where, node));
      MIEN_TRY_ASSIGN(const std::size_t first, viseme_named(names[0], place(where, node)));
      MIEN_TRY_ASSIGN(const std::size_t second, viseme_named(names[1], place(where, node)));
      out.arpabet_.push_back(
          {std::string(symbol.str()),
           {{static_cast<std::uint8_t>(first), kFirst}, {static_cast<std::uint8_t>(second), 1 - kFirst}}});
    }
  }
  for (auto* sounds : {&out.arpabet_, &out.ipa_}) {
    std::ranges::sort(*sounds, {}, &Named::name);
    const auto twice = std::ranges::adjacent_find(*sounds, {}, &Named::name);
    if (twice != sounds->end())
      return fail(ErrorCode::malformed, fmt::format("'{}' belongs to two visemes", excerpt(twice->name)),
                  where);
  }
  return out;
}

}  // namespace mien::speech
