#include "mien/synthetic/recipe_table.h"

#include <fmt/ranges.h>

#include "mien/core/excerpt.h"

namespace mien::synthetic {

void RecipeTable::flag(const char* key, bool& value) {
  const toml::node* const node = find(key);
  if (node == nullptr) return;
  if (!node->is_boolean()) return wrong(key, "must be true or false");
  value = *node->value<bool>();
}

void RecipeTable::texts(const char* key, std::vector<std::string>& values) {
  const toml::node* const node = find(key);
  if (node == nullptr) return;
  std::vector<std::string> read;
  if (const toml::array* const list = node->as_array())
    for (const toml::node& item : *list)
      if (const auto given = item.value<std::string>()) read.push_back(*given);
  if (read.empty() || read.size() != node->as_array()->size()) return wrong(key, "must be a list of texts");
  values = std::move(read);
}

std::optional<std::string> RecipeTable::choice(const char* key, const std::set<std::string>& choices) {
  const toml::node* const node = find(key);
  if (node == nullptr) return std::nullopt;
  auto given = node->value<std::string>();
  if (!given || !choices.contains(*given))
    wrong(key, fmt::format("is \"{}\", which is none of {}", excerpt(given.value_or("no text")),
                           fmt::join(choices, ", ")));
  return given;
}

toml::table RecipeTable::inner(const char* key) {
  const toml::node* const node = find(key);
  if (node == nullptr) return {};
  if (node->is_table()) return *node->as_table();
  wrong(key, "is no table");
  return {};
}

Result<void> RecipeTable::finish() {
  for (const auto& [key, node] : table_)
    if (!problem_ && !known_.contains(std::string(key.str())))
      problem_ = Error{ErrorCode::bad_usage,
                       fmt::format("{}{} is not a key of recipes", name_, excerpt(key.str())), where_,
                       fmt::format("known here are {}; see docs/guide/training.md", fmt::join(known_, ", "))};
  if (problem_) return std::unexpected(*problem_);
  return {};
}

const toml::node* RecipeTable::find(const char* key) {
  known_.insert(key);
  return table_.get(key);
}

void RecipeTable::wrong(const char* key, const std::string& what) {
  if (!problem_)
    problem_ = Error{ErrorCode::out_of_range, fmt::format("{}{} {}", name_, key, what), where_, ""};
}

}  // namespace mien::synthetic
