#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string_view>
#include <vector>

#include "app/command.h"
#include "mien/core/nearest_word.h"

namespace mien::app {
namespace {

/// What stands there that nothing takes: an option, a part of the command, or a word too many.
std::string unknown_word(const Command& command, const std::string& word) {
  const std::string shown = one_line(word, 60);
  const bool option = word.size() > 1 && word.starts_with('-');
  const std::string plain = word.substr(0, word.find('='));
  const std::string near = did_you_mean(plain, option ? command.option_names() : command_names(command));
  if (option) return fmt::format("there is no option {}{}", shown, near);
  const std::vector<std::string> parts = command_names(command);
  if (parts.empty()) return fmt::format("'{}' is a word too many", shown);
  if (!near.empty()) return fmt::format("there is no command '{}'{}", shown, near);
  return fmt::format("there is no command '{}'; the commands are {}", shown, fmt::join(parts, ", "));
}

/// `text` with what stands around `middle` put into `form`; as it is where `middle` is not in it.
std::string around(const std::string& text, std::string_view middle, std::string_view form) {
  const std::size_t at = text.find(middle);
  if (at == std::string::npos) return text;
  return fmt::format(fmt::runtime(form), text.substr(0, at), text.substr(at + middle.size()));
}

/// CLI11's words for what is wrong with options that exist, in ours.
std::string wrong_option(const ParseError& error) {
  const std::string what = one_line(error.what, 400);
  const std::string& kind = error.kind;
  if (kind == "RequiredError") return around(what, " is required", "{} is missing{}");
  if (kind == "ExcludesError") return around(what, " excludes ", "{} and {} cannot be given together");
  if (kind == "RequiresError") return around(what, " requires ", "{} means nothing without {}");
  if (kind == "ArgumentMismatch" && what.ends_with(" missing"))
    return what.substr(0, what.find(':')) + " has no value";
  if (kind == "ConversionError") {
    const std::string named = around(what, "Could not convert: ", "{}{}");
    return around(named, " = ", "{}: '{}' is not what it takes");
  }
  if (what.ends_with('}')) return around(what.substr(0, what.size() - 1), " not in {", "{} is none of {}");
  return what;
}

}  // namespace

std::string usage_error(const Command& program, const ParseError& error) {
  const Command command = program.deepest_named();
  const std::string full = command.full_name();
  const std::vector<std::string> left = command.remaining();
  const bool unknown = error.kind == "ExtrasError" && !left.empty();
  const std::string what = unknown ? unknown_word(command, left.front()) : wrong_option(error);
  const std::size_t within = program.name().size() + 1;
  const std::string where = full.size() > within ? full.substr(within) + ": " : "";
  return fmt::format("{}{}{} see {} --help", where, what, what.ends_with('?') ? "" : ";", full);
}

}  // namespace mien::app
