#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "app/command_line.h"
#include "mien/core/error.h"
#include "mien/core/excerpt.h"
#include "mien/core/progress.h"

namespace mien::app {

/// The commands of a program. Each command has a file of its own, which adds itself here and does its work
/// in `run`.
class Commands {
 public:
  Commands(const std::string& program, const std::string& does);

  /// The commands that are added from now on stand under this heading in --help.
  void heading(const std::string& group) { group_ = group; }
  /// Whether --help says that a command line names a command, and parsing asks for it.
  void require_one(bool required) { line_.program().require_commands(required ? 1 : 0, 1); }
  /// `does`: at most 64 characters, so that the list of commands has a line of 80 columns for each.
  /// `example` is shown at the end of --help, as one would type it.
  Command add(const std::string& name, const std::string& does, const std::string& example,
              std::function<Result<void>()> run);
  /// Adds the command's parts (`mien face list`) beneath `parent`.
  Command add_under(Command parent, const std::string& name, const std::string& does,
                    const std::string& example, std::function<Result<void>()> run);

  /// Says what is wrong with a command line that was refused, as one line without the program's name.
  using UsageError = std::string (*)(const Command& program, const ParseError& error);
  /// What a main() does: runs what the command line named, prints the error, if any, as one line on stderr,
  /// and gives the exit status.
  [[nodiscard]] int main(int argc, char** argv, UsageError usage_error);

 private:
  [[nodiscard]] Result<void> run() const;

  CommandLine line_;
  std::string group_;
  std::vector<std::pair<Command, std::function<Result<void>()>>> runs_;
};

/// What is wrong with a command line that `program` refused with `error`, as one line without the program's
/// name: which command, what is wrong, what to do ("live: there is no option --recrod; did you mean
/// --record? see mien live --help").
[[nodiscard]] std::string usage_error(const Command& program, const ParseError& error);
/// CLI11's own words, for programs that nobody starts by hand.
[[nodiscard]] std::string plain_usage_error(const Command& program, const ParseError& error);

/// The file that was named or, where none was, one of the program's own: `part` is as find_resource() takes
/// it. Errors: find_resource()'s.
[[nodiscard]] Result<std::filesystem::path> path_or(const std::filesystem::path& named,
                                                    const std::filesystem::path& part);

/// Whether a file of this name may be written: it has one of the endings, and its folder is there. To be
/// asked before long work. Errors: bad_usage, not_found, io (the folder cannot be written to).
[[nodiscard]] Result<void> check_output(const std::filesystem::path& path,
                                        std::initializer_list<std::string_view> endings);

/// What several commands share. --json: stdout is one JSON object.
void add_json_flag(const Command& command, bool& json);
/// --rig, the rig's file.
Option add_rig_option(const Command& command, std::string& rig);

/// The names of a command's own commands.
[[nodiscard]] std::vector<std::string> command_names(const Command& command);

/// Shows progress and time left on stderr when it is a terminal, else a line every few seconds; Ctrl-C
/// (or SIGTERM, or the terminal going away) asks the work to stop. `title` stands before it. A share of the
/// work below the last one begins another stage, whose time is counted anew.
[[nodiscard]] Progress terminal_progress(std::string title);

/// Set when Ctrl-C (or SIGTERM, or the terminal going away) asked to stop; for work that has no end of its
/// own.
[[nodiscard]] const std::atomic<bool>& stop_asked();

/// Draws the terminal's last line on stderr anew, cut to its width; only where stderr is a terminal.
void draw_line(std::string_view line);

/// What a stranger wrote, on one line, without anything that a terminal would obey (excerpt()).
[[nodiscard]] inline std::string one_line(std::string_view text, std::size_t letters = 120) {
  return excerpt(text, letters);
}

/// Minutes and seconds, "1:05"; from an hour on "1:01:05".
[[nodiscard]] std::string clock_text(double seconds);

/// Clears the line on which terminal_progress() or draw_line() stands, for what is printed next.
void clear_progress();

void add_align_command(Commands& commands);
void add_bench_command(Commands& commands);
void add_calibrate_command(Commands& commands);
void add_dataset_command(Commands& commands);
void add_demo_command(Commands& commands);
void add_evaluate_command(Commands& commands);
void add_export_command(Commands& commands);
void add_face_command(Commands& commands);
void add_import_command(Commands& commands);
void add_live_command(Commands& commands);
void add_perform_command(Commands& commands);
void add_personalise_command(Commands& commands);
void add_record_command(Commands& commands);
void add_render_command(Commands& commands);
void add_solve_command(Commands& commands);
void add_study_command(Commands& commands);
void add_take_command(Commands& commands);
void add_train_command(Commands& commands);
/// Beneath `mien face`: its `profiles`.
void add_face_profiles_command(Commands& commands, Command face);
/// Beneath `mien study`: its `skin`, which writes a rig's [skin] table, a tool for rigs and no study.
void add_skin_command(Commands& commands, const Command& study);

}  // namespace mien::app
