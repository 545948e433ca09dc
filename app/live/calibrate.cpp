#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "app/command.h"
#include "app/json_output.h"
#include "app/live/calibration_text.h"
#include "app/live/page_token.h"
#include "app/live/session_client.h"

namespace mien::app {
namespace {

using Calibration = session::Report::Calibration;
using Version = session::CalibrationVersion;

struct CalibrateOptions {
  std::string at = "127.0.0.1:8740";
  TokenOption token;
  bool json = false;
  std::string kind = "short";
  double wait_s = 60;
  std::int64_t version = 0;
  std::int64_t other = 0;
};

/// A status may be older than the reply before it, by two of them at most; this many are five seconds.
constexpr int kStatusesToBelieve = 25;
/// Letters of a notice that names all sensors of a rig.
constexpr std::size_t kLongestNotice = 600;
/// A re-centring takes 3.5 s with sensors on the skin or cameras, else 1.5 s; this many are eight seconds.
constexpr int kStatusesToRecentre = 40;

Result<std::unique_ptr<SessionClient>> open_session(const CalibrateOptions& options) {
  return SessionClient::open(options.at, options.token, stop_asked());
}

std::int64_t newest_id(const Calibration& calibration) {
  std::int64_t newest = 0;
  for (const Version& version : calibration.versions) newest = std::max(newest, version.id);
  return newest;
}

/// The one of this origin that was made after version `before`; null while there is none.
const Version* made_since(const Calibration& calibration, std::int64_t before, std::string_view origin) {
  const auto made = std::ranges::find_if(
      calibration.versions, [&](const Version& v) { return v.id > before && v.origin == origin; });
  return made == calibration.versions.end() ? nullptr : &*made;
}

Result<Version> version_of(const Calibration& calibration, std::int64_t id) {
  const auto found = std::ranges::find(calibration.versions, id, &Version::id);
  if (found == calibration.versions.end())
    return fail(ErrorCode::not_found, fmt::format("there is no calibration {}", id), "the session",
                "see mien calibrate list");
  return *found;
}

/// Shows the performer what to do now: one line that is drawn anew, or a line a step where nobody looks at a
/// terminal.
class Prompter {
 public:
  void show(const Calibration& calibration) {
    const bool waits = calibration.prompt.empty();
    const std::string prompt = waits ? "waiting for the first sensor" : one_line(calibration.prompt);
    const std::string step = waits ? "" : one_line(calibration.step, 8);
    if (terminal_) {
      draw_line(fmt::format("{:3.0f} %  {:<7} {:2.0f} s  {}", 100 * calibration.progress, step,
                            std::ceil(calibration.remaining_s), prompt));
    } else if (prompt != shown_) {
      fmt::print(stderr, "{}{}{}, {:.1f} s\n", step, step.empty() ? "" : ": ", prompt,
                 calibration.remaining_s);
      std::fflush(stderr);
    }
    shown_ = prompt;
  }

 private:
  bool terminal_ = ::isatty(STDERR_FILENO) == 1;
  std::string shown_;
};

/// Which sensors measure nothing, by what is the matter with them: "lost: jaw; silent: head, zygomaticus_L".
std::string unheard_text(const std::vector<SessionStatus::Link>& links) {
  constexpr std::size_t kNamesShown = 16;
  std::string text;
  constexpr std::array<std::pair<std::string_view, std::string_view>, 4> kStates = {
      {{"lost", "lost"}, {"no_face", "no face"}, {"silent", "silent"}, {"unbound", "unbound"}}};
  for (const auto& [state, word] : kStates) {
    std::vector<std::string> names;
    for (const SessionStatus::Link& link : links)
      if (link.state == state) names.push_back(one_line(link.sensor, 40));
    if (names.empty()) continue;
    const std::size_t more = names.size() > kNamesShown ? names.size() - kNamesShown : 0;
    names.resize(names.size() - more);
    text += fmt::format("{}{}: {}{}", text.empty() ? "" : "; ", word, fmt::join(names, ", "),
                        more > 0 ? fmt::format(" and {} more", more) : "");
  }
  return text;
}

/// Watches whether the session has new frames, without which no calibration goes on.
class Patience {
 public:
  explicit Patience(double wait_s) : wait_(from_seconds(wait_s)) {}

  /// Takes a look; says once, after a while without frames, which sensors are missing. False when it was too
  /// long.
  bool lasts(const SessionStatus& status, const std::string& at) {
    const auto now = std::chrono::steady_clock::now();
    if (status.time_s != newest_s_ || !since_) {
      newest_s_ = status.time_s;
      since_ = now;
      said_ = false;
    }
    const auto waited = now - *since_;
    if (waited >= std::min<Duration>(kUntilSaid, wait_ / 2) && !said_) {
      said_ = true;
      clear_progress();
      const std::string unheard = unheard_text(status.links);
      fmt::print(stderr,
                 "mien: {}: still waiting for frames{}{}; the page there shows every sensor, and "
                 "docs/reference/links.md says what to do; ends after {:g} s (--wait)\n",
                 at, unheard.empty() ? "" : ", nothing from ", unheard, to_seconds(wait_));
      std::fflush(stderr);
    }
    return waited < wait_;
  }

 private:
  static constexpr auto kUntilSaid = std::chrono::seconds(10);
  Duration wait_;
  double newest_s_ = 0;
  std::optional<std::chrono::steady_clock::time_point> since_;
  bool said_ = false;
};

/// Why something failed, as one line for a terminal: what follows an event's "not calibrated: ".
std::string why_of(const SessionEvent& event) {
  const std::size_t colon = event.text.find(": ");
  return colon == std::string::npos ? "it did not come about" : one_line(event.text.substr(colon + 2));
}

/// How a guided calibration ended.
struct Outcome {
  std::optional<Version> made;
  ErrorCode code = ErrorCode::io;
  std::string why;  ///< Where none was made.
};

Result<Outcome> cancel(SessionClient& session, std::int64_t before) {
  MIEN_TRY(session.command({{"command", "cancel_calibration"}}));
  for (int i = 0; i < kStatusesToBelieve; ++i) {
    MIEN_TRY(session.next_status());
    if (session.status().calibration.state != "running") break;
  }
  if (const Version* made = made_since(session.status().calibration, before, "guided"))
    return Outcome{{},
                   ErrorCode::cancelled,
                   fmt::format("it was over before it could be cancelled; calibration {} is in force, and "
                               "mien calibrate use goes back to an earlier one",
                               made->id)};
  return Outcome{{}, ErrorCode::cancelled, "cancelled; nothing was changed"};
}

/// They were there and are gone: no calibration can begin. (Those that never were may be on their way.)
bool all_are_lost(const std::vector<SessionStatus::Link>& links) {
  return std::ranges::none_of(links, &SessionStatus::Link::received) &&
         std::ranges::find(links, "lost", &SessionStatus::Link::state) != links.end();
}

Result<Outcome> guide(SessionClient& session, const CalibrateOptions& options) {
  if (all_are_lost(session.status().links))
    return Outcome{
        {},
        ErrorCode::io,
        fmt::format("no sensor sends any more ({}); nothing was begun; docs/reference/links.md says what "
                    "to do",
                    unheard_text(session.status().links))};
  if (session.status().calibration.state == "running")
    return Outcome{{}, ErrorCode::io, "one runs already; wait for its end, or cancel it on the page"};
  const std::int64_t before = newest_id(session.status().calibration);
  MIEN_TRY(session.command({{"command", "calibrate"}, {"kind", options.kind}}));
  Prompter prompter;
  Patience patience(options.wait_s);
  bool begun = false;
  for (int statuses = 0;; ++statuses) {
    if (stop_asked()) return cancel(session, before);
    MIEN_TRY(session.next_status());
    const Calibration& now = session.status().calibration;
    if (const Version* made = made_since(now, before, "guided")) return Outcome{*made, {}, {}};
    if (now.state == "running") {
      begun = true;
      if (!patience.lasts(session.status(), options.at)) {
        const std::string unheard = unheard_text(session.status().links);
        MIEN_TRY_ASSIGN(Outcome outcome, cancel(session, before));
        outcome.code = ErrorCode::io;
        outcome.why = fmt::format("no frame came for {:g} s{}{}; {}", options.wait_s,
                                  unheard.empty() ? "" : ", nothing from ", unheard, outcome.why);
        return outcome;
      }
      prompter.show(now);
    } else if (begun && now.state == "failed") {
      return Outcome{{}, ErrorCode::io, one_line(now.prompt, 200)};
    } else if (begun) {
      return Outcome{{}, ErrorCode::cancelled, "cancelled from elsewhere; nothing was changed"};
    } else if (statuses == kStatusesToBelieve) {
      return fail(ErrorCode::io, "the session does not begin to calibrate", "calibration");
    }
  }
}

Result<void> run_guided(const CalibrateOptions& options) {
  MIEN_TRY_ASSIGN(const std::unique_ptr<SessionClient> session, open_session(options));
  MIEN_TRY_ASSIGN(const Outcome outcome, guide(*session, options));
  clear_progress();
  if (!outcome.made) {
    if (options.json)
      print_json(
          {{"version", nullptr}, {"scores", Json::array()}, {"passed", false}, {"error", outcome.why}});
    return fail(outcome.code, outcome.why, "calibration");
  }
  if (options.json)
    print_json(version_json(*outcome.made));
  else
    print_scores(*outcome.made);
  if (!sensor::all_pass(outcome.made->scores))
    return fail(ErrorCode::io, "not every score passed", fmt::format("calibration {}", outcome.made->id),
                "it is in force all the same: calibrate again, or go back with mien calibrate use");
  return {};
}

Result<void> run_list(const CalibrateOptions& options) {
  MIEN_TRY_ASSIGN(const std::unique_ptr<SessionClient> session, open_session(options));
  if (options.json)
    print_json(versions_json(session->status()));
  else
    print_versions(session->status());
  return {};
}

Result<void> run_use(const CalibrateOptions& options) {
  MIEN_TRY_ASSIGN(const std::unique_ptr<SessionClient> session, open_session(options));
  MIEN_TRY_ASSIGN(const Version version, version_of(session->status().calibration, options.version));
  MIEN_TRY(session->command({{"command", "use_calibration"}, {"version", version.id}}));
  if (options.json)
    print_json(version_json(version));
  else
    fmt::print("Calibration {} ({}) is in force.\n", version.id, one_line(version.origin));
  return {};
}

Result<void> run_compare(const CalibrateOptions& options) {
  MIEN_TRY_ASSIGN(const std::unique_ptr<SessionClient> session, open_session(options));
  MIEN_TRY_ASSIGN(const Version a, version_of(session->status().calibration, options.version));
  MIEN_TRY_ASSIGN(const Version b, version_of(session->status().calibration, options.other));
  if (options.json)
    print_json(comparison_json(a, b));
  else
    print_comparison(a, b);
  return {};
}

Result<void> run_recentre(const CalibrateOptions& options) {
  MIEN_TRY_ASSIGN(const std::unique_ptr<SessionClient> session, open_session(options));
  const std::int64_t before = newest_id(session->status().calibration);
  [[maybe_unused]] const auto earlier = session->take_events();
  MIEN_TRY(session->command({{"command", "recentre"}}));
  for (int statuses = 0; statuses < kStatusesToRecentre; ++statuses) {
    MIEN_TRY(session->next_status());
    const std::vector<SessionEvent> events = session->take_events();
    for (const SessionEvent& event : events)
      if (event.kind == "rested") fmt::print(stderr, "{}\n", one_line(event.text, kLongestNotice));
    if (const Version* made = made_since(session->status().calibration, before, "recentre")) {
      if (options.json)
        print_json(version_json(*made));
      else
        fmt::print("The present face is neutral now: calibration {}.\n", made->id);
      return {};
    }
    for (const SessionEvent& event : events)
      if (event.kind == "recentre_failed")
        return fail(ErrorCode::io, why_of(event) + "; the neutral face stays as it was", "re-centring",
                    "calibrate where nothing is calibrated yet; the page shows which sensors are there");
    if (stop_asked())
      return fail(ErrorCode::cancelled, "not waited for: it may still come into force", "re-centring");
  }
  return fail(ErrorCode::io, "the session has no frames to centre on", "re-centring",
              "see on the page which sensors are there");
}

}  // namespace

void add_calibrate_command(Commands& commands) {
  const auto options = std::make_shared<CalibrateOptions>();
  const Command guided =
      commands.add("calibrate", "Leads through a calibration of the running session; scores it",
                   "mien calibrate full", [options] { return run_guided(*options); });
  guided.require_commands(0, 1);
  guided
      .add_option(
          "kind", options->kind,
          "short: hold still, and nod and shake the head where the sensors need it; full: then the anchor "
          "expressions; wearer: then a minute of others, from which sensors on the skin learn yours; gaze: "
          "short, then five points to look at, from which a headset's cameras learn where you look")
      .one_of({"short", "full", "wearer", "gaze"})
      .show_default();
  guided
      .add_option("--wait", options->wait_s,
                  "Seconds without any frame, because sensors are missing, after which it is given up")
      .number_between(1.0, 3600.0)
      .show_default();
  const Command list =
      commands.add_under(guided, "list", "Shows the session's calibrations and how good they are",
                         "mien calibrate list", [options] { return run_list(*options); });
  const Command use = commands.add_under(
      guided, "use", "Puts an earlier calibration in force again: undoes what came after it",
      "mien calibrate use 1", [options] { return run_use(*options); });
  use.add_option("version", options->version, "Its id, as the list shows it").required();
  const Command compare =
      commands.add_under(guided, "compare", "Shows the scores of two calibrations beside each other",
                         "mien calibrate compare 1 2", [options] { return run_compare(*options); });
  compare.add_option("version", options->version, "The one's id, as the list shows it").required();
  compare.add_option("other", options->other, "The other's id").required();
  const Command recentre =
      commands.add_under(guided, "recentre", "Makes the face that the performer has now neutral again",
                         "mien calibrate recentre", [options] { return run_recentre(*options); });
  for (Command command : {guided, list, use, compare, recentre}) {
    command
        .add_option("--at", options->at,
                    "Where the session is: HOST:PORT of its page, or the address that mien live printed")
        .show_default();
    add_token_options(command, options->token, "The page's token, where it has one");
    add_json_flag(command, options->json);
  }
}

}  // namespace mien::app
