#pragma once

#include <CLI/CLI.hpp>
#include <atomic>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/progress.h"

namespace mien::app {

/// The commands of the program. Each command has a file of its own, which adds itself here and does its work
/// in `run`; main() prints the error, if any, as one line on stderr and turns it into the exit status.
class Commands {
 public:
  explicit Commands(CLI::App& program) : program_(program) {}

  /// `example` is shown at the end of --help, as one would type it.
  CLI::App* add(const std::string& name, const std::string& does, const std::string& example,
                std::function<Result<void>()> run);
  /// Adds the command's parts (`mien face list`) beneath `parent`.
  CLI::App* add_under(CLI::App* parent, const std::string& name, const std::string& does,
                      const std::string& example, std::function<Result<void>()> run);

  /// Runs what the command line named.
  [[nodiscard]] Result<void> run() const;

 private:
  CLI::App& program_;
  std::vector<std::pair<CLI::App*, std::function<Result<void>()>>> runs_;
};

/// Checks that an option is a number from `least` to `most`. (CLI::Range takes "nan" for one.)
[[nodiscard]] CLI::Validator number_between(double least, double most);

/// Whether a file of this name may be written: it has one of the endings, and its folder is there. To be
/// asked before long work. Errors: bad_usage, not_found, io (the folder cannot be written to).
[[nodiscard]] Result<void> check_output(const std::filesystem::path& path,
                                        std::initializer_list<std::string_view> endings);

/// The names of a command's own commands.
[[nodiscard]] std::vector<std::string> command_names(const CLI::App& command);

/// Shows progress and time left on stderr when it is a terminal, else a line every few seconds; Ctrl-C
/// (or SIGTERM, or the terminal going away) asks the work to stop. `title` stands before it.
[[nodiscard]] Progress terminal_progress(std::string title);

/// Set when Ctrl-C (or SIGTERM, or the terminal going away) asked to stop; for work that has no end of its
/// own.
[[nodiscard]] const std::atomic<bool>& stop_asked();

/// Draws the terminal's last line on stderr anew, cut to its width; only where stderr is a terminal.
void draw_line(std::string_view line);

/// "1:05", and from an hour on "1:01:05".
[[nodiscard]] std::string clock_text(double seconds);

/// Clears the line on which terminal_progress() or draw_line() stands, for what is printed next.
void clear_progress();

void add_bench_command(Commands& commands);
void add_calibrate_command(Commands& commands);
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

}  // namespace mien::app
