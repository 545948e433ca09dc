#include "mien/session/prompt_script.h"

#include <fmt/format.h>

#include <set>
#include <utility>

#include "mien/core/excerpt.h"
#include "mien/core/files.h"
#include "mien/core/toml.h"
#include "mien/face/target_names.h"

namespace mien::session {
namespace {

constexpr std::size_t kMaxBytes = std::size_t{4} << 20U;

Result<std::string> text(const toml::table& table, std::string_view key, const std::string& where) {
  const toml::node* node = table.get(key);
  if (node == nullptr) return std::string();
  const auto value = node->value_exact<std::string>();
  if (!value)
    return fail(ErrorCode::malformed, fmt::format("'{}' is not text", key), place(where, *node),
                "write it in quotes");
  return *value;
}

Result<double> number(const toml::table& table, std::string_view key, double otherwise,
                      const std::string& where) {
  const toml::node* node = table.get(key);
  if (node == nullptr) return otherwise;
  const auto value = node->value<double>();
  if (!value || !node->is_number())
    return fail(ErrorCode::malformed, fmt::format("'{}' is not a number", key), place(where, *node));
  return *value;
}

/// One shape, or both sides of a pair.
Result<std::vector<std::size_t>> shapes_of(std::string_view name, const std::string& where) {
  std::vector<std::size_t> shapes = face::shapes_named(name);
  if (!shapes.empty()) return shapes;
  return fail(ErrorCode::malformed, fmt::format("there is no shape '{}'", excerpt(name)), where,
              "docs/guide/recording.md names them: jawOpen, mouthSmile_L, or mouthSmile for both sides");
}

Result<face::BlendshapeWeights> weights_of(const toml::table& table, const std::string& where) {
  face::BlendshapeWeights weights;
  const toml::node* node = table.get("weights");
  if (node == nullptr) return weights;
  const toml::table* named = node->as_table();
  if (named == nullptr)
    return fail(ErrorCode::malformed, "'weights' is no table", place(where, *node),
                "write it as { jawOpen = 0.5 }");
  for (const auto& [key, value] : *named) {
    const auto weight = value.value<double>();
    if (!weight || !value.is_number())
      return fail(ErrorCode::malformed, fmt::format("weight '{}' is not a number", excerpt(key.str())),
                  place(where, value));
    if (!(*weight >= 0 && *weight <= 1))
      return fail(ErrorCode::out_of_range, fmt::format("weight '{}' is {:g}", excerpt(key.str()), *weight),
                  place(where, value), "weights go from 0 to 1");
    MIEN_TRY_ASSIGN(const std::vector<std::size_t> shapes, shapes_of(key.str(), place(where, value)));
    for (const std::size_t shape : shapes) weights[shape] = static_cast<float>(*weight);
  }
  return weights;
}

/// `language`, `seconds`: of a prompt that gives none.
Result<Prompt> prompt_of(const toml::table& table, const std::string& language, double seconds,
                         const std::string& where) {
  MIEN_TRY(only_keys(
      table, {"name", "say", "seconds", "weights", "text", "block", "emotion", "language", "own_pace"},
      where));
  Prompt prompt;
  MIEN_TRY_ASSIGN(prompt.name, text(table, "name", where));
  MIEN_TRY_ASSIGN(prompt.say, text(table, "say", where));
  MIEN_TRY_ASSIGN(prompt.seconds, number(table, "seconds", seconds, where));
  MIEN_TRY_ASSIGN(prompt.target, weights_of(table, where));
  MIEN_TRY_ASSIGN(prompt.text, text(table, "text", where));
  MIEN_TRY_ASSIGN(prompt.block, text(table, "block", where));
  MIEN_TRY_ASSIGN(prompt.emotion, text(table, "emotion", where));
  MIEN_TRY_ASSIGN(prompt.language, text(table, "language", where));
  if (prompt.language.empty() && !prompt.text.empty()) prompt.language = language;
  if (const toml::node* node = table.get("own_pace")) {
    const auto value = node->value_exact<bool>();
    if (!value)
      return fail(ErrorCode::malformed, "'own_pace' is neither true nor false", place(where, *node));
    prompt.own_pace = *value;
  }
  MIEN_TRY(check_prompt(prompt, place(where, table)));
  return prompt;
}

}  // namespace

double PromptScript::seconds() const {
  double sum = 0;
  for (const Prompt& prompt : prompts) sum += prompt.seconds;
  return sum;
}

Result<PromptScript> parse_prompts(std::string_view toml, const std::string& where) {
  MIEN_TRY_ASSIGN(const toml::table table, parse_toml(toml, where));
  MIEN_TRY(only_keys(table, {"name", "language", "seconds", "prompt"}, where));
  PromptScript script;
  MIEN_TRY_ASSIGN(script.name, text(table, "name", where));
  MIEN_TRY_ASSIGN(script.language, text(table, "language", where));
  MIEN_TRY_ASSIGN(const double seconds, number(table, "seconds", Prompt().seconds, where));
  const toml::node* list = table.get("prompt");
  const toml::array* prompts = list == nullptr ? nullptr : list->as_array();
  if (prompts == nullptr || prompts->empty())
    return fail(ErrorCode::malformed, "it asks for no pose", where,
                "begin each with a line [[prompt]]; prompts/one_minute.toml is an example");
  if (prompts->size() > kMaxPrompts)
    return fail(ErrorCode::out_of_range, fmt::format("it asks for {} poses", prompts->size()), where,
                fmt::format("{} are enough for one recording", kMaxPrompts));
  std::set<std::string> lines;
  for (const toml::node& node : *prompts) {
    const toml::table* one = node.as_table();
    if (one == nullptr)
      return fail(ErrorCode::malformed, "a 'prompt' is no table", place(where, node),
                  "begin each with a line [[prompt]]");
    MIEN_TRY_ASSIGN(Prompt prompt, prompt_of(*one, script.language, seconds, where));
    if (!prompt.block.empty() && !lines.insert(prompt.name).second)
      return fail(ErrorCode::malformed, fmt::format("'{}' is there twice", prompt.name), place(where, *one),
                  "give every line of a block a name of its own: a dataset knows it by that");
    script.prompts.push_back(std::move(prompt));
  }
  return script;
}

Result<PromptScript> read_prompts(const std::filesystem::path& path) {
  MIEN_TRY_ASSIGN(const std::string text, read_text(path, kMaxBytes));
  return parse_prompts(text, path.string());
}

}  // namespace mien::session
