#include "app/live/demo_dataset.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>
#include <utility>

#include "app/command.h"
#include "app/live/demo_session.h"
#include "app/live/perform_network.h"
#include "app/live/prompt_source.h"
#include "app/live/running_session.h"
#include "app/live/scripted_performance.h"
#include "app/live/session_client.h"
#include "mien/core/files.h"
#include "mien/session/recorded_lines.h"
#include "mien/take/take.h"
#include "mien/virtual/stage.h"
#include "mien/virtual/worn_devices.h"

namespace mien::app {
namespace {

using Clock = std::chrono::steady_clock;
using nlohmann::json;

/// A dataset of its own: what was recorded before stays as it is.
std::string new_dataset(const std::filesystem::path& folder) {
  std::string name = "faces";
  std::error_code ignored;
  for (int i = 2; std::filesystem::exists(folder / name, ignored); ++i) name = fmt::format("faces_{}", i);
  return name;
}

/// The session tells its state five times a second; what it was asked is seen by then, on a busy machine too.
constexpr auto kSeen = std::chrono::seconds(30);

/// The performer's side: sends in real time until it is told to end.
class Performer {
 public:
  /// `to`: who hears the sensors, and `phone`: who hears the phone, as the session's ports say.
  Performer(virt::Stage stage, std::string to, const std::string& phone) {
    const double motion_s = stage.motion.times.motion_start_s;
    thread_ = std::jthread([this, stage = std::move(stage), to = std::move(to),
                            phone = phone.substr(phone.find("//") + 2), motion_s]() mutable {
      NetworkOptions network;
      network.to = std::move(to);
      network.phone = std::move(phone);
      network.title = "";
      network.enough = [this, motion_s](std::size_t) {
        if (!begun_) {
          begin_ = Clock::now() +
                   std::chrono::duration_cast<Clock::duration>(from_seconds(virt::kDeviceMarginS + motion_s));
          begun_ = true;
        }
        return ended_.load();
      };
      performed_ = perform_to_network(std::move(stage), network);
      over_ = true;
    });
  }
  ~Performer() { ended_ = true; }

  /// When the motion's time is 0; none before the performance begins.
  [[nodiscard]] std::optional<Clock::time_point> begin() const {
    return begun_ ? std::optional(begin_) : std::nullopt;
  }
  [[nodiscard]] bool over() const { return over_; }
  /// Errors: the performance's.
  [[nodiscard]] Result<void> finish() {
    ended_ = true;
    thread_.join();
    if (!performed_) return std::unexpected(performed_.error());
    return {};
  }

 private:
  std::atomic<bool> begun_ = false, ended_ = false, over_ = false;
  Clock::time_point begin_;  // Before begun_.
  Result<NetworkSummary> performed_ = NetworkSummary();
  std::jthread thread_;
};

/// The page's side.
class Visitor {
 public:
  Visitor(SessionClient& session, const Performer& performer) : session_(session), performer_(performer) {}

  /// Until this time of the motion.
  Result<void> wait_until(double motion_s) {
    for (;;) {
      const auto begin = performer_.begin();
      if (begin &&
          Clock::now() >= *begin + std::chrono::duration_cast<Clock::duration>(from_seconds(motion_s)))
        return {};
      MIEN_TRY(look());
      MIEN_TRY(session_.listen_until(Clock::now() + std::chrono::milliseconds(5)));
    }
  }

  /// Until the session says so. `what`: for who reads that it did not.
  template <class Seen>
  Result<void> wait_for(const char* what, Seen&& seen) {
    const auto deadline = Clock::now() + kSeen;
    while (!seen(session_.status())) {
      if (Clock::now() > deadline)
        return fail(ErrorCode::internal, std::string("the session never ") + what, "demo");
      MIEN_TRY(look());
      MIEN_TRY(session_.next_status());
    }
    return {};
  }

  Result<void> say(json command) { return session_.command(std::move(command)); }

  /// The same of a word that the session may not be ready for by a moment: a person presses again.
  Result<void> say_until_obeyed(const json& command) {
    const auto deadline = Clock::now() + kSeen;
    for (;;) {
      auto said = session_.command(command);
      if (said || said.error().code != ErrorCode::bad_usage || Clock::now() > deadline) return said;
      MIEN_TRY(look());
      MIEN_TRY(session_.listen_until(Clock::now() + std::chrono::milliseconds(50)));
    }
  }

 private:
  Result<void> look() const {
    if (stop_asked()) return fail(ErrorCode::cancelled, "stopped", "demo");
    if (performer_.over()) return fail(ErrorCode::internal, "the performance was over too early", "demo");
    return {};
  }

  SessionClient& session_;
  const Performer& performer_;
};

/// Goes through the script as it was rehearsed.
Result<void> record(Visitor& visitor, const DatasetDemo& demo, const std::string& dataset,
                    const std::string& script, const ScriptedPerformance& rehearsed,
                    const Progress& progress) {
  progress(0, "calibrating");
  MIEN_TRY(visitor.wait_until(kScriptBeginS));
  MIEN_TRY(visitor.say({{"command", "dataset"},
                        {"begin",
                         {{"name", dataset},
                          {"script", script},
                          {"performer", fmt::format("virtual {}", demo.seed)},
                          {"recorded_by", "mien demo"},
                          {"purpose", "to show how a dataset is recorded"},
                          {"sound", true},
                          {"agreed", true},
                          {"pace", "key"}}}}));
  std::size_t done = 0;
  for (const ScriptedPerformance::Step& step : rehearsed.steps) {
    MIEN_TRY(visitor.wait_until(step.at_s));
    if (step.word == "begin")
      MIEN_TRY(visitor.wait_for("waited before a block",
                                [](const SessionStatus& status) { return status.prompts == "block"; }));
    MIEN_TRY(visitor.say_until_obeyed({{"command", "prompts"}, {"do", step.word}}));
    progress(static_cast<double>(++done) / static_cast<double>(rehearsed.steps.size() + 1), "recording");
  }
  // What was poor would be asked for again, of somebody who has rehearsed nothing more.
  MIEN_TRY(visitor.wait_until(rehearsed.motion.duration_s() - 0.5));
  MIEN_TRY(visitor.say({{"command", "dataset"}, {"end", true}}));
  MIEN_TRY(visitor.wait_for("ended the recording", [](const SessionStatus& status) {
    return status.dataset && status.dataset->over;
  }));
  progress(1, "recorded");
  return {};
}

Result<RecordedDemo> look_at(const std::filesystem::path& folder, const std::string& take_name) {
  RecordedDemo out{.dataset = folder, .take = folder / take_name, .lines = 0, .poor = {}};
  MIEN_TRY_ASSIGN(const take::Take take, take::Take::open(out.take));
  MIEN_TRY_ASSIGN(const std::vector<take::Event> events, take.events());
  const std::optional<session::RecordedPart> part = session::recorded_part(events);
  if (!part) return fail(ErrorCode::internal, "the take has no consent", out.take.string());
  for (const session::RecordedLine* line : session::lines_that_count(*part)) {
    ++out.lines;
    if (!line->poor.empty())
      out.poor.push_back(fmt::format("{}: {}", line->name, fmt::join(line->poor, " ")));
  }
  return out;
}

}  // namespace

Result<RecordedDemo> record_demo_dataset(const DatasetDemo& demo) {
  MIEN_TRY_ASSIGN(const session::PromptScript script, load_prompts(demo.script));
  MIEN_TRY_ASSIGN(const std::filesystem::path rig, find_resource("rigs/imu_microphone.toml"));
  MIEN_TRY_ASSIGN(const ScriptedPerformance rehearsed,
                  perform_script(script, demo.seed, terminal_progress("1/2 rehearsing")));

  virt::StageRequest stage_request;
  stage_request.face = fmt::format("builtin:{}", demo.seed);
  stage_request.seed = demo.seed;
  stage_request.motion = rehearsed.motion;
  stage_request.script_name = script.name;
  stage_request.sound = rehearsed.sound;
  stage_request.rig = rig;
  stage_request.phone = true;
  MIEN_TRY_ASSIGN(virt::Stage stage, virt::set_stage(stage_request));

  LiveRequest request;
  request.rig = rig.string();
  request.model = demo.model;
  request.listen = {"udp://127.0.0.1:0", "livelink://127.0.0.1:0"};
  request.phone = "truth";
  request.audio = "network";
  request.takes = demo.out;
  request.face = stage_request.face;
  request.page = demo.page;
  const bool is_file = demo.script.ends_with(".toml");
  if (is_file) request.texts = {demo.script};
  MIEN_TRY_ASSIGN(const LiveSession opened, open_demo_session(request));
  live::Engine& engine = *opened.engine;

  RunningSession session(engine);
  Performer performer(std::move(stage), engine.listening().front(), engine.listening().back());
  const std::string dataset = new_dataset(demo.out);
  std::string take;
  const auto visit = [&]() -> Result<void> {
    MIEN_TRY_ASSIGN(const std::unique_ptr<SessionClient> client,
                    SessionClient::open(engine.page(), {}, stop_asked()));
    Visitor visitor(*client, performer);
    MIEN_TRY(record(visitor, demo, dataset,
                    is_file ? std::filesystem::path(demo.script).stem().string() : demo.script, rehearsed,
                    terminal_progress("2/2 recording, in real time")));
    take = client->status().dataset->take;
    return {};
  };
  const Result<void> visited = visit();
  const Result<void> performed = performer.finish();
  const Result<live::EngineSummary> summary = session.finish();
  if (!performed) return std::unexpected(performed.error());
  MIEN_TRY(visited);
  if (!summary) return std::unexpected(summary.error());
  if (!summary->recording_error.empty()) return fail(ErrorCode::io, summary->recording_error, take);
  return look_at(demo.out / dataset, take);
}

}  // namespace mien::app
