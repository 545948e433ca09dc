#include "mien/session/prompt_script.h"

#include <fmt/format.h>

#include <utility>

#include "mien/core/excerpt.h"
#include "mien/core/files.h"
#include "mien/core/toml.h"
#include "mien/face/shapes_named.h"

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

}  // namespace

double PromptScript::seconds() const {
  double sum = 0;
  for (const Prompt& prompt : prompts) sum += prompt.seconds;
  return sum;
}

Result<PromptScript> parse_prompts(std::string_view toml, const std::string& where) {
  MIEN_TRY_ASSIGN(const toml::table table, parse_toml(toml, where));
  MIEN_TRY(only_keys(table, {"name", "seconds", "prompt"}, where));
  PromptScript script;
  MIEN_TRY_ASSIGN(script.name, text(table, "name", where));
  MIEN_TRY_ASSIGN(const double seconds, number(table, "seconds", Prompt().seconds, where));
  const toml::node* list = table.get("prompt");
  const toml::array* prompts = list == nullptr ? nullptr : list->as_array();
  if (prompts == nullptr || prompts->empty())
    return fail(ErrorCode::malformed, "it asks for no pose", where,
                "begin each with a line [[prompt]]; prompts/one_minute.toml is an example");
  if (prompts->size() > kMaxPrompts)
    return fail(ErrorCode::out_of_range, fmt::format("it asks for {} poses", prompts->size()), where,
                fmt::format("{} are enough for one recording", kMaxPrompts));
  for (const toml::node& node : *prompts) {
    const toml::table* one = node.as_table();
    if (one == nullptr)
      return fail(ErrorCode::malformed, "a 'prompt' is no table", place(where, node),
                  "begin each with a line [[prompt]]");
    MIEN_TRY(only_keys(*one, {"name", "say", "seconds", "weights"}, where));
    Prompt prompt;
    MIEN_TRY_ASSIGN(prompt.name, text(*one, "name", where));
    MIEN_TRY_ASSIGN(prompt.say, text(*one, "say", where));
    MIEN_TRY_ASSIGN(prompt.seconds, number(*one, "seconds", seconds, where));
    MIEN_TRY_ASSIGN(prompt.target, weights_of(*one, where));
    MIEN_TRY(check_prompt(prompt, place(where, *one)));
    script.prompts.push_back(std::move(prompt));
  }
  return script;
}

Result<PromptScript> read_prompts(const std::filesystem::path& path) {
  MIEN_TRY_ASSIGN(const std::string text, read_text(path, kMaxBytes));
  return parse_prompts(text, path.string());
}

}  // namespace mien::session
