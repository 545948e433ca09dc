#include "app/command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <exception>
#include <memory>
#include <optional>
#include <system_error>

#include "mien/core/files.h"

namespace mien::app {
namespace {

std::atomic<bool> interrupted = false;
std::atomic<bool> line_is_open = false;  // Progress stands on the terminal's last line.

void catch_signals() {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, [](int) { interrupted = true; });
}

/// One line, whatever a file or a stranger had to say in it.
void complain(const std::string& program, const std::string& what) {
  fmt::print(stderr, "{}: {}\n", program, without_controls(what));
}

}  // namespace

std::string clock_text(double seconds) {
  const int s = static_cast<int>(seconds + 0.5);
  return s < 3600 ? fmt::format("{}:{:02}", s / 60, s % 60)
                  : fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

Commands::Commands(const std::string& program, const std::string& does)
    : line_(program, does, program + " " MIEN_VERSION) {}

Command Commands::add(const std::string& name, const std::string& does, const std::string& example,
                      std::function<Result<void>()> run) {
  const Command command = add_under(line_.program(), name, does, example, std::move(run));
  if (!group_.empty()) command.heading(group_);
  return command;
}

Command Commands::add_under(Command parent, const std::string& name, const std::string& does,
                            const std::string& example, std::function<Result<void>()> run) {
  const Command command = parent.add_command(name, does);
  command.footer("\nExample:\n  " + example);
  runs_.emplace_back(command, std::move(run));
  return command;
}

void add_json_flag(const Command& command, bool& json) {
  command.add_flag("--json", json, "Print one JSON object");
}

Option add_rig_option(const Command& command, std::string& rig) {
  return command.add_option("--rig", rig, "Rig file (default: rigs/default.toml)");
}

std::vector<std::string> command_names(const Command& command) {
  std::vector<std::string> names;
  for (const Command& part : command.commands()) names.push_back(part.name());
  return names;
}

Result<void> Commands::run() const {
  // The deepest command that was named does the work.
  std::optional<Command> named;
  for (auto it = runs_.rbegin(); it != runs_.rend(); ++it) {
    if (!it->first.named()) continue;
    if (it->second) return it->second();
    if (!named) named = it->first;
  }
  if (!named) return fail(ErrorCode::bad_usage, "no command was given", {}, "see mien --help");
  return fail(
      ErrorCode::bad_usage, "it needs one of its commands", named->name(),
      fmt::format("they are {}; see mien {} --help", fmt::join(command_names(*named), ", "), named->name()));
}

int Commands::main(int argc, char** argv, UsageError usage_error) {
  const std::string name = line_.program().name();
  const auto parsed = line_.parse(argc, argv);
  if (!parsed) {
    complain(name, usage_error(line_.program(), parsed.error()));
    return 2;
  }
  if (!*parsed) return 0;
  try {
    if (const auto done = run(); !done) {
      clear_progress();
      complain(name, done.error().message());
      return is_bad_input(done.error().code) ? 2 : 1;
    }
  } catch (const std::exception& error) {
    complain(name, fmt::format("{}; this is a defect, please report it", error.what()));
    return 1;
  }
  return 0;
}

std::string plain_usage_error(const Command& program, const ParseError& error) {
  return fmt::format("{}; see {} --help", error.what, program.deepest_named().full_name());
}

Result<std::filesystem::path> path_or(const std::filesystem::path& named, const std::filesystem::path& part) {
  if (!named.empty()) return named;
  return find_resource(part);
}

Result<void> check_output(const std::filesystem::path& path,
                          std::initializer_list<std::string_view> endings) {
  if (std::ranges::find(endings, path.extension().string()) == endings.end())
    return fail(ErrorCode::bad_usage, fmt::format("its name does not end with {}", fmt::join(endings, ", ")),
                path.string(), "name it so, lest something else be replaced");
  std::error_code code;
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  if (!std::filesystem::is_directory(folder, code))
    return fail(ErrorCode::not_found, "there is no such folder", folder.string(), "make it first");
  if (::access(folder.c_str(), W_OK) != 0)
    return fail(ErrorCode::io, std::generic_category().message(errno), folder.string(),
                "choose a folder that can be written to");
  return {};
}

const std::atomic<bool>& stop_asked() {
  catch_signals();
  return interrupted;
}

void draw_line(std::string_view line) {
  winsize size{};
  if (::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1)
    line = line.substr(0, size.ws_col - 1U);  // A line that wraps cannot be drawn again.
  line_is_open = true;
  fmt::print(stderr, "\r\x1b[K{}", line);
  std::fflush(stderr);
}

void clear_progress() {
  if (line_is_open.exchange(false)) fmt::print(stderr, "\r\x1b[K");
}

Progress terminal_progress(std::string title) {
  catch_signals();
  struct Shown {
    std::string title;
    std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
    std::chrono::steady_clock::time_point last = start;  // Work that fails at once says only why.
    double begun = 0, fraction = 0;  // Of this stage, at its first report; at the last one.
  };
  auto shown = std::make_shared<Shown>();
  shown->title = std::move(title);
  const bool terminal = ::isatty(STDERR_FILENO) == 1;
  return [shown, terminal](double fraction, std::string_view what) {
    const auto now = std::chrono::steady_clock::now();
    if (fraction < shown->fraction || shown->fraction >= 1) {  // Another stage begins.
      shown->start = now;
      shown->begun = fraction;
    }
    shown->fraction = fraction;
    const double since_s = std::chrono::duration<double>(now - shown->last).count();
    const bool end = fraction >= 1.0;
    if (end || since_s > (terminal ? 0.2 : 10.0)) {
      shown->last = now;
      const double spent_s = std::chrono::duration<double>(now - shown->start).count();
      const double done = fraction - shown->begun;
      const std::string left = end           ? "took " + clock_text(spent_s)
                               : done > 0.01 ? clock_text(spent_s * (1 - fraction) / done) + " left"
                                             : "";
      if (terminal) line_is_open = !end;
      if (terminal)
        fmt::print(stderr, "\r\x1b[K{}: {:3.0f} %  {}  {}{}", shown->title, 100 * fraction, what, left,
                   end ? "\n" : "");
      else
        fmt::print(stderr, "{}: {:.0f} %  {}  {}\n", shown->title, 100 * fraction, what, left);
      std::fflush(stderr);
    }
    return !interrupted.load();
  };
}

}  // namespace mien::app
