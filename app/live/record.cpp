#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "app/command.h"
#include "app/live/live_command.h"
#include "app/live/live_session.h"
#include "app/live/prompt_source.h"

namespace mien::app {
namespace {

using Prompts = session::Report::Prompts;

struct RecordOptions {
  LiveRequest request;
  std::string prompts;
  bool json = false;
};

/// Shows how far a recording is: one line that is drawn anew, or a line a pose where nobody looks at a
/// terminal.
class RecordingLine {
 public:
  void show(const live::Status& status) {
    const Prompts& prompts = status.report.prompts;
    if (terminal_) {
      draw_line(text(status));
    } else if (prompts.state == "running" && prompts.number != shown_) {
      shown_ = prompts.number;
      fmt::print(stderr, "{}/{} {}, {:g} s\n", prompts.number, prompts.of, prompts.prompt.name,
                 std::round(10 * prompts.remaining_s) / 10);
      std::fflush(stderr);
    }
  }

 private:
  static std::string text(const live::Status& status) {
    if (status.report.frames == 0) return "waiting for the first sensor";
    std::string recorded = "recording " + clock_text(std::floor(status.recording.seconds));
    // With poses the line has little room: then only what matters soon.
    const std::optional<double> log_left_s = status.recording.log.seconds_left;
    if (log_left_s && (status.report.prompts.state == "none" || *log_left_s < 3600))
      recorded += fmt::format(" (log: {:.1f} h left)", *log_left_s / 3600);
    const Prompts& prompts = status.report.prompts;
    if (prompts.state == "none" || prompts.state == "over")
      return status.recording_ends_s
                 ? fmt::format("{} of {}", recorded, clock_text(std::ceil(*status.recording_ends_s)))
                 : recorded;
    const std::string next = prompts.next.name.empty() ? "" : fmt::format("  (next: {})", prompts.next.name);
    const std::string place = fmt::format("{}  {}/{}  {} left", recorded, prompts.number, prompts.of,
                                          clock_text(std::ceil(prompts.left_s)));
    if (prompts.state == "paused") return fmt::format("{}  paused before: {}", place, prompts.prompt.name);
    if (prompts.state == "ready")
      return fmt::format("{}  get ready, {:.0f}: {}", place, std::ceil(prompts.remaining_s),
                         prompts.prompt.name);
    return fmt::format("{}  {:.0f}: {}{}{}{}", place, std::ceil(prompts.remaining_s), prompts.prompt.name,
                       prompts.prompt.say.empty() ? "" : " - ", prompts.prompt.say, next);
  }

  bool terminal_ = ::isatty(STDERR_FILENO) == 1;
  std::size_t shown_ = 0;
};

Result<void> run_record(RecordOptions options) {
  LiveRequest& request = options.request;
  request.only_record = true;
  request.script = "recording";
  std::string asked;
  if (!options.prompts.empty()) {
    MIEN_TRY_ASSIGN(session::PromptScript script, load_prompts(options.prompts));
    asked = fmt::format("{} poses, {} and a little{}", script.prompts.size(),
                        clock_text(std::ceil(script.seconds())),
                        request.page == "off" ? "; without the page they are shown by name only" : "");
    request.script = options.prompts;
    request.prompts = std::move(script.prompts);
  }
  MIEN_TRY_ASSIGN(const LiveSession session, open_live(std::move(request)));
  RecordingLine line;
  return run_session(session, options.json, asked,
                     [&line](const live::Status& status) { line.show(status); });
}

}  // namespace

void add_record_command(Commands& commands) {
  const auto options = std::make_shared<RecordOptions>();
  LiveRequest& request = options->request;
  const Command command =
      commands.add("record", "Records devices into a take, with prompts where they are named",
                   "mien record --prompts one_minute --out me.mien\n  mien record --for 60 --out minute.mien",
                   [options] { return run_record(*options); });
  add_session_options(command, request);
  command.add_option("--out", request.record, "The take to write, from the first packet on").required();
  command.add_option(
      "--prompts", options->prompts,
      "Poses to show on the page, one after the other; the recording ends with them. A TOML file, "
      "one_minute, "
      "or components:N[:SEED], N poses of three seconds drawn as the published eyewear study draws its own");
  add_json_flag(command, options->json);
}

}  // namespace mien::app
