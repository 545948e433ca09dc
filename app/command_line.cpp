#include "app/command_line.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iterator>
#include <utility>

namespace mien::app {
namespace {

/// To CLI11 a group of options is a command without a name.
bool is_group(const CLI::App& command) {
  return command.get_name().empty();
}

}  // namespace

Option Option::required() const {
  return Option(option_->required());
}

Option Option::needs(Option other) const {
  return Option(option_->needs(other.option_));
}

Option Option::excludes(Option other) const {
  return Option(option_->excludes(other.option_));
}

Option Option::expected(int values) const {
  return Option(option_->expected(values));
}

Option Option::optional_value(const std::string& value) const {
  return Option(option_->expected(0, 1)->option_text("[" + value + "]"));
}

Option Option::repeated() const {
  return Option(option_->allow_extra_args(false));
}

Option Option::delimiter(char between) const {
  return Option(option_->delimiter(between));
}

Option Option::show_default() const {
  return Option(option_->capture_default_str());
}

Option Option::check(std::function<std::string(const std::string&)> wrong, const std::string& values) const {
  return Option(option_->check(std::move(wrong), values));
}

Option Option::one_of(const std::vector<std::string>& words) const {
  return Option(option_->check(CLI::IsMember(words)));
}

Option Option::existing_file() const {
  return Option(option_->check(CLI::ExistingFile));
}

Option Option::existing_folder() const {
  return Option(option_->check(CLI::ExistingDirectory));
}

Option Option::positive() const {
  return Option(option_->check(CLI::PositiveNumber));
}

Option Option::not_negative() const {
  return Option(option_->check(CLI::NonNegativeNumber));
}

Option Option::in_range(int least, int most) const {
  return Option(option_->check(CLI::Range(least, most)));
}

Option Option::in_range(std::size_t least, std::size_t most) const {
  return Option(option_->check(CLI::Range(least, most)));
}

Option Option::in_range(double least, double most) const {
  return Option(option_->check(CLI::Range(least, most)));
}

Option Option::number_between(double least, double most) const {
  return check(
      [least, most](const std::string& text) -> std::string {
        double value = 0;
        if (CLI::detail::lexical_cast(text, value) && value >= least && value <= most) return {};
        return fmt::format("{} is no number from {} to {}", text, least, most);
      },
      fmt::format("{} to {}", least, most));
}

bool Option::given() const {
  return option_->count() > 0;
}

Command Command::add_command(const std::string& name, const std::string& does) const {
  return Command(command_->add_subcommand(name, does));
}

void Command::heading(const std::string& group) const {
  command_->group(group);
}

Command Command::add_group(const std::string& name, const std::string& does) const {
  return Command(command_->add_option_group(name, does));
}

template <OptionValue T>
Option Command::add_option(const std::string& name, T& value, const std::string& does) const {
  return Option(command_->add_option(name, value, does));
}

template Option Command::add_option(const std::string&, std::string&, const std::string&) const;
template Option Command::add_option(const std::string&, std::filesystem::path&, const std::string&) const;
template Option Command::add_option(const std::string&, double&, const std::string&) const;
template Option Command::add_option(const std::string&, float&, const std::string&) const;
template Option Command::add_option(const std::string&, int&, const std::string&) const;
template Option Command::add_option(const std::string&, std::int64_t&, const std::string&) const;
template Option Command::add_option(const std::string&, std::uint64_t&, const std::string&) const;
template Option Command::add_option(const std::string&, std::vector<std::string>&, const std::string&) const;
template Option Command::add_option(const std::string&, std::vector<double>&, const std::string&) const;
template Option Command::add_option(const std::string&, std::vector<std::uint64_t>&,
                                    const std::string&) const;

Option Command::add_flag(const std::string& name, bool& value, const std::string& does) const {
  return Option(command_->add_flag(name, value, does));
}

Option Command::option(const std::string& name) const {
  return Option(command_->get_option(name));
}

void Command::require_commands(std::size_t least, std::size_t most) const {
  command_->require_subcommand(least, most);
}

void Command::footer(const std::string& text) const {
  command_->footer(text);
}

void Command::pass_on() const {
  command_->set_help_flag();
  command_->prefix_command();
}

std::string Command::name() const {
  return command_->get_name();
}

std::string Command::full_name() const {
  std::string full = command_->get_name();
  for (const CLI::App* above = command_->get_parent(); above != nullptr; above = above->get_parent())
    full = above->get_name() + " " + full;
  return full;
}

std::vector<Command> Command::commands() const {
  std::vector<Command> own;
  for (CLI::App* command : command_->get_subcommands(nullptr))
    if (!is_group(*command)) own.emplace_back(command);
  return own;
}

std::vector<std::string> Command::option_names() const {
  std::vector<std::string> names;
  for (const CLI::Option* option : command_->get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  for (CLI::App* group : command_->get_subcommands(nullptr))
    if (is_group(*group)) std::ranges::copy(Command(group).option_names(), std::back_inserter(names));
  return names;
}

bool Command::named() const {
  return command_->parsed();
}

Command Command::deepest_named() const {
  CLI::App* command = command_;
  while (!command->get_subcommands().empty()) command = command->get_subcommands().back();
  return Command(command);
}

std::vector<std::string> Command::remaining() const {
  return command_->remaining();
}

CommandLine::CommandLine(const std::string& name, const std::string& does, const std::string& version)
    : program_(std::make_unique<CLI::App>(does, name)) {
  program_->set_version_flag("--version", version);
}

CommandLine::~CommandLine() = default;

std::expected<bool, ParseError> CommandLine::parse(int argc, char** argv) {
  // Narrower than its commands' help: names of commands are short.
  const auto list = std::make_shared<CLI::Formatter>();
  list->column_width(15);
  program_->formatter(list);
  try {
    program_->parse(argc, argv);
    return true;
  } catch (const CLI::Success& shown) {
    program_->exit(shown);
    return false;
  } catch (const CLI::ParseError& error) {
    // Of this one get_name() gives the command's.
    const bool extras = dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr;
    return std::unexpected(ParseError{extras ? "ExtrasError" : error.get_name(), error.what()});
  }
}

}  // namespace mien::app
