#include "mien/sink/vrchat_avatar.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "mien/core/ascii.h"
#include "mien/core/excerpt.h"

namespace mien::sink {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kMaxAddress = 512;
constexpr int kMaxDepth = 64;

/// A member that is text, or null.
const std::string* text(const Json& object, const char* name) {
  const auto found = object.find(name);
  return found == object.end() ? nullptr : found->get_ptr<const std::string*>();
}

/// The parser recurses into nothing, but destroying what it made would.
bool too_deep(std::string_view json) {
  int depth = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < json.size(); ++i) {
    if (quoted) {
      if (json[i] == '\\')
        ++i;
      else if (json[i] == '"')
        quoted = false;
    } else if (json[i] == '"') {
      quoted = true;
    } else if (json[i] == '[' || json[i] == '{') {
      if (++depth > kMaxDepth) return true;
    } else if (json[i] == ']' || json[i] == '}') {
      --depth;
    }
  }
  return false;
}

Result<VrchatAvatar::Parameter> parse_input(const Json& input, const std::string& where) {
  const std::string* const address = input.is_object() ? text(input, "address") : nullptr;
  const std::string* const type = input.is_object() ? text(input, "type") : nullptr;
  if (address == nullptr || type == nullptr)
    return fail(ErrorCode::malformed, "a parameter's input has no address or no type", where);
  if (address->size() > kMaxAddress)
    return fail(ErrorCode::out_of_range, fmt::format("an address is longer than {} bytes", kMaxAddress),
                where);
  if (!address->starts_with('/') || has_control(*address))
    return fail(ErrorCode::malformed, "an address is not one of OSC's", where);
  VrchatAvatar::Parameter parameter{*address, {}};
  if (*type == "Float")
    parameter.type = VrchatAvatar::Type::real;
  else if (*type == "Int")
    parameter.type = VrchatAvatar::Type::whole;
  else if (*type == "Bool")
    parameter.type = VrchatAvatar::Type::truth;
  else
    return fail(ErrorCode::unsupported,
                fmt::format("the type '{}' is none of Float, Int, Bool", excerpt(*type)), where);
  return parameter;
}

}  // namespace

Result<VrchatAvatar> parse_vrchat_avatar(std::string_view json, std::string_view where) {
  const std::string place(where);
  if (json.starts_with("\xEF\xBB\xBF")) json.remove_prefix(3);
  if (too_deep(json))
    return fail(ErrorCode::out_of_range, fmt::format("nested deeper than {}", kMaxDepth), place);
  const Json root = Json::parse(json, nullptr, false);
  const char* const fix = "it should be VRChat's OSC configuration of one avatar";
  if (!root.is_object()) return fail(ErrorCode::malformed, "no JSON object", place, fix);
  const auto list = root.find("parameters");
  if (list == root.end() || !list->is_array())
    return fail(ErrorCode::malformed, "there is no list of parameters", place, fix);
  if (list->size() > kMaxAvatarParameters)
    return fail(ErrorCode::out_of_range, fmt::format("more than {} parameters", kMaxAvatarParameters), place);
  VrchatAvatar avatar;
  if (const std::string* id = text(root, "id")) avatar.id = *id;
  if (const std::string* name = text(root, "name")) avatar.name = *name;
  for (std::size_t i = 0; i < list->size(); ++i) {
    const Json& one = (*list)[i];
    if (!one.is_object()) return fail(ErrorCode::malformed, "a parameter is no object", place, fix);
    const auto input = one.find("input");
    if (input == one.end()) continue;
    MIEN_TRY_ASSIGN(auto parameter, parse_input(*input, fmt::format("{}, parameter {}", place, i + 1)));
    avatar.parameters.push_back(std::move(parameter));
  }
  return avatar;
}

}  // namespace mien::sink
