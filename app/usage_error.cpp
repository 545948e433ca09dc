#include "app/usage_error.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <numeric>
#include <string_view>
#include <utility>
#include <vector>

#include "app/command.h"
#include "app/one_line.h"

namespace mien::app {
namespace {

/// Letters that must be added, taken away, changed, or swapped with their neighbour to make one word the
/// other.
std::size_t distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  std::iota(last.begin(), last.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1), last[j] + 1, row[j - 1] + 1});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        row[j] = std::min(row[j], before[j - 2] + 1);
    }
    std::swap(before, last);
    std::swap(last, row);
  }
  return last.back();
}

/// The known word that is nearest; empty where none is near.
std::string nearest(std::string_view word, const std::vector<std::string>& known) {
  std::string best;
  std::size_t least = std::max<std::size_t>(1, word.size() / 3) + 1;
  for (const std::string& candidate : known) {
    const std::size_t far = distance(word, candidate);
    if (far >= least) continue;
    least = far;
    best = candidate;
  }
  return best;
}

/// What stands there that nothing takes: an option, a part of the command, or a word too many.
std::string unknown_word(const Command& command, const std::string& word) {
  const std::string shown = one_line(word, 60);
  const bool option = word.size() > 1 && word.starts_with('-');
  const std::string plain = word.substr(0, word.find('='));
  std::string near = nearest(plain, option ? command.option_names() : command_names(command));
  if (!near.empty()) near = fmt::format("; did you mean {}?", near);
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
