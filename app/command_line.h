#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <expected>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

// Commands and options as they are typed, with --help. CLI11 is included by command_line.cpp alone: it costs
// a file eleven seconds.
namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace mien::app {

/// An option of a command, or a word told by its place. A handle: copies are the same option, valid as long
/// as its CommandLine. Each function returns the option, for chaining.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}

  Option required() const;
  /// It means nothing without the other.
  Option needs(Option other) const;
  /// The two cannot be given together.
  Option excludes(Option other) const;
  /// How many values it takes each time that it is given.
  Option expected(int values) const;
  /// Its value may be left out, which is as if an empty one were given; --help calls it `value`.
  Option optional_value(const std::string& value) const;
  /// One value each time that it is given, however often that is.
  Option repeated() const;
  /// A value holds several, with this between them.
  Option delimiter(char between) const;
  /// --help shows what its variable holds now.
  Option show_default() const;

  // What its values must be; --help says so.
  /// `wrong` says what is wrong with a value, or nothing; `values` describes the right ones.
  Option check(std::function<std::string(const std::string&)> wrong, const std::string& values = {}) const;
  Option one_of(const std::vector<std::string>& words) const;
  Option existing_file() const;
  Option existing_folder() const;
  Option positive() const;
  Option not_negative() const;
  Option in_range(int least, int most) const;
  Option in_range(std::size_t least, std::size_t most) const;
  Option in_range(double least, double most) const;  ///< "nan" is in every range.
  Option number_between(double least, double most) const;

  /// Whether it stands in the command line that was parsed.
  [[nodiscard]] bool given() const;

 private:
  CLI::Option* option_;
};

template <typename T, typename... Types>
concept OneOf = (std::same_as<T, Types> || ...);

/// What an option's value is read into.
template <typename T>
concept OptionValue =
    OneOf<T, std::string, std::filesystem::path, double, float, int, std::int64_t, std::uint64_t,
          std::vector<std::string>, std::vector<double>, std::vector<std::uint64_t>>;

/// A command, or the program as a whole. A handle: copies are the same command, valid as long as its
/// CommandLine.
class Command {
 public:
  explicit Command(CLI::App* command) : command_(command) {}

  [[nodiscard]] Command add_command(const std::string& name, const std::string& does) const;
  /// Stands under this heading in the list of its program's commands.
  void heading(const std::string& group) const;
  /// Its options under a heading of their own.
  [[nodiscard]] Command add_group(const std::string& name, const std::string& does) const;
  /// `name`: "--name", or "name" for a word told by its place. `value` is written by CommandLine::parse(),
  /// and must live until then.
  template <OptionValue T>
  Option add_option(const std::string& name, T& value, const std::string& does) const;
  Option add_flag(const std::string& name, bool& value, const std::string& does) const;
  /// The option of this name, which there must be.
  [[nodiscard]] Option option(const std::string& name) const;
  /// How many of its own commands may be named at once.
  void require_commands(std::size_t least, std::size_t most) const;
  /// Stands at the end of --help.
  void footer(const std::string& text) const;
  /// Everything behind its name, --help as well, is another program's: see remaining().
  void pass_on() const;

  [[nodiscard]] std::string name() const;
  [[nodiscard]] std::string full_name() const;                  ///< As it is typed: "mien take info".
  [[nodiscard]] std::vector<Command> commands() const;          ///< Its own.
  [[nodiscard]] std::vector<std::string> option_names() const;  ///< "--name"; those of its groups too.

  // Of the command line that was parsed.
  [[nodiscard]] bool named() const;
  [[nodiscard]] Command deepest_named() const;               ///< Itself or one beneath it.
  [[nodiscard]] std::vector<std::string> remaining() const;  ///< What nothing took.

 private:
  CLI::App* command_;
};

/// Why a command line was refused, in CLI11's words.
struct ParseError {
  std::string kind;  ///< "RequiredError", ...
  std::string what;
};

/// The command line of a program: owns its commands and options.
class CommandLine {
 public:
  /// `version` is what --version prints.
  CommandLine(const std::string& name, const std::string& does, const std::string& version);
  ~CommandLine();
  CommandLine(const CommandLine&) = delete;
  CommandLine& operator=(const CommandLine&) = delete;

  [[nodiscard]] Command program() const { return Command(program_.get()); }

  /// Reads the arguments into the options' variables. False: help or the version was asked for, and is
  /// printed.
  [[nodiscard]] std::expected<bool, ParseError> parse(int argc, char** argv);

 private:
  std::unique_ptr<CLI::App> program_;
};

}  // namespace mien::app
