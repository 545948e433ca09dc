#pragma once

#include <fmt/format.h>

#include <concepts>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/toml.h"

namespace mien::synthetic {

/// One table of a training's recipe: takes the known keys out of it, remembers the first thing wrong, and
/// complains about the keys that are left. What is not told keeps its value. To be included from sources
/// alone, as core/toml.h.
class RecipeTable {
 public:
  /// Keeps references. `name`: what goes before keys in messages, "data."; `where`: the file.
  RecipeTable(const toml::table& table, std::string name, const std::string& where)
      : table_(table), name_(std::move(name)), where_(where) {}

  /// How limits of a value are told: of whole numbers as such.
  template <class Value>
  using Limit = std::type_identity_t<std::conditional_t<std::floating_point<Value>, double, std::int64_t>>;

  template <class Value>
  void number(const char* key, Value& value, Limit<Value> low, Limit<Value> high) {
    const toml::node* const node = find(key);
    if (node == nullptr) return;
    const auto given = within<Value>(*node, low, high);
    if (!given) return wrong(key, fmt::format("must be {} from {} to {}", kind<Value>(), low, high));
    value = static_cast<Value>(*given);
  }
  /// A list of at least one.
  template <class Value>
  void numbers(const char* key, std::vector<Value>& values, Limit<Value> low, Limit<Value> high) {
    const toml::node* const node = find(key);
    if (node == nullptr) return;
    std::vector<Value> read;
    if (const toml::array* const list = node->as_array())
      for (const toml::node& item : *list)
        if (const auto given = within<Value>(item, low, high)) read.push_back(static_cast<Value>(*given));
    if (read.empty() || read.size() != node->as_array()->size())
      return wrong(key, fmt::format("must be a list, each {} from {} to {}", kind<Value>(), low, high));
    values = std::move(read);
  }
  void flag(const char* key, bool& value);
  /// A list of at least one.
  void texts(const char* key, std::vector<std::string>& values);
  [[nodiscard]] std::optional<std::string> choice(const char* key, const std::set<std::string>& choices);
  /// A table inside, or an empty one.
  [[nodiscard]] toml::table inner(const char* key);

  /// Errors: out_of_range (the first value that is not what it should be), bad_usage (a key that is not
  /// known).
  [[nodiscard]] Result<void> finish();

 private:
  template <class Value>
  static std::optional<Limit<Value>> within(const toml::node& node, Limit<Value> low, Limit<Value> high) {
    std::optional<Limit<Value>> given;
    // The library converts 1e300 to a whole number before it asks whether that can be.
    if constexpr (std::floating_point<Value>) {
      if (node.is_number()) given = node.value<double>();
    } else {
      given = node.value_exact<std::int64_t>();
    }
    return given && *given >= low && *given <= high ? given : std::nullopt;
  }
  template <class Value>
  static const char* kind() {
    return std::floating_point<Value> ? "a number" : "a whole number";
  }
  /// nullptr: it is not told.
  const toml::node* find(const char* key);
  void wrong(const char* key, const std::string& what);

  const toml::table& table_;
  std::string name_;
  const std::string& where_;
  std::set<std::string> known_;
  std::optional<Error> problem_;
};

}  // namespace mien::synthetic
