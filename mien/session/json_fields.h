#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

// Fields of JSON that may say anything: commands, and events of takes.
namespace mien::session {

/// A text of an object; empty where it has none, or is no object.
[[nodiscard]] inline std::string text_field(const nlohmann::json& object, std::string_view key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}
/// Whether an object says `true` there.
[[nodiscard]] inline bool flag_field(const nlohmann::json& object, std::string_view key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_boolean() && found->get<bool>();
}
/// As text. Names of files and sources need not be UTF-8: what is none is replaced.
[[nodiscard]] inline std::string dumped(const nlohmann::json& json) {
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace mien::session
