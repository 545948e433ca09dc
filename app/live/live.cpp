#include <filesystem>
#include <memory>
#include <utility>

#include "app/command.h"
#include "app/json_output.h"
#include "app/live/live_command.h"
#include "app/live/live_session.h"
#include "mien/modalities/modalities.h"
#include "mien/session/replay.h"

namespace mien::app {
namespace {

struct LiveOptions {
  LiveRequest request;
  std::filesystem::path replay;
  bool json = false;
};

Result<void> run_replay(LiveOptions options) {
  MIEN_TRY_ASSIGN(const take::Take take, take::Take::open(options.replay));
  MIEN_TRY_ASSIGN(const std::filesystem::path model,
                  modalities::live_model(take.rig(), options.request.model));
  MIEN_TRY_ASSIGN(const std::unique_ptr<session::Session> session,
                  modalities::make_session(take.rig(), model));
  MIEN_TRY_ASSIGN(const std::vector<take::Tick> ticks, take.ticks());
  const Progress progress = terminal_progress("replay");
  std::size_t calibrated = 0;
  MIEN_TRY(session::replay(take, *session, [&](const take::Tick&, const face::OutputFrame&) {
    if (!session->versions().empty()) ++calibrated;
    const auto done = static_cast<double>(session->frames());
    return session->frames() % 64 != 0 || progress(done / static_cast<double>(ticks.size()), "replaying");
  }));
  progress(1, "replayed");
  const std::string hash = session->hash(), kernels = modalities::live_kernels(take.rig());
  MIEN_TRY_ASSIGN(const std::string live_hash, take.note("live.hash"));
  session::Report report;
  session->report(ticks.back().fired, report);
  if (options.json) {
    print_json({{"take", options.replay.string()},
                {"frames", session->frames()},
                {"calibrated_frames", calibrated},
                {"calibration", report.calibration.state},
                {"prompt", report.calibration.prompt},
                {"kernels", kernels},
                {"hash", hash},
                {"live_hash", live_hash}});
  } else {
    fmt::print("{}: {} frames, kernels {}, hash {}\n", options.replay.string(), session->frames(), kernels,
               hash);
    if (live_hash == hash) {
      fmt::print("The same bits as the session that recorded it.\n");
    } else if (!live_hash.empty()) {
      MIEN_TRY_ASSIGN(const std::string live_model, take.note("live.model"));
      MIEN_TRY_ASSIGN(const std::string live_kernels, take.note("live.kernels"));
      fmt::print(
          "Not the bits of the session that recorded it, which had the model {} and the kernels {}: give "
          "that model with --model, or it was another build.\n",
          one_line(live_model), one_line(live_kernels));
    }
  }
  return {};
}

Result<void> run_live(LiveOptions options) {
  if (!options.replay.empty()) return run_replay(std::move(options));
  MIEN_TRY_ASSIGN(const LiveSession session, open_live(std::move(options.request)));
  return run_session(session, options.json);
}

}  // namespace

void add_live_command(Commands& commands) {
  auto options = std::make_shared<LiveOptions>();
  LiveRequest& request = options->request;
  const Command command = commands.add(
      "live", "Devices in, avatar out: with page, sinks and recording",
      "mien live --listen udp://0.0.0.0:5005 --out livelink://192.168.1.7 --out vmc://127.0.0.1 --record "
      "take.mien",
      [options] { return run_live(*options); });
  const Option listen = add_session_options(command, request);
  const Option sinks = command.add_option(
      "--out", request.out,
      "Where the face goes: livelink://, vmc://, vrchat://, ifacialmocap://, ws://HOST[:PORT] "
      "or csv:FILE; may be given often");
  const Option record =
      command.add_option("--record", request.record, "The take to write, from the first packet on")
          .check([](const std::string& file) { return file.empty() ? "the take has no name" : ""; });
  command
      .add_option("--takes", request.takes,
                  "The folder of takes that the page records and shows (default: that of --record, or the "
                  "present one)")
      .existing_folder();
  command.add_option(
      "--texts", request.texts,
      "A recording script of your own (TOML, as prompts/dataset_en.toml) for the page's Record a "
      "dataset, beside ours in four languages; may be given often");
  const Option replay =
      command
          .add_option("--replay", options->replay,
                      "Instead of devices a take's log, as fast as it goes: prints frames, kernels and hash")
          .existing_file()
          .excludes(listen)
          .excludes(sinks)
          .excludes(record);
  // A log has its rig and its length, and nobody looks on.
  for (const char* name : {"--rig", "--constraints", "--blinks", "--audio", "--hears-by", "--no-audio",
                           "--images", "--phone", "--force", "--takes", "--texts", "--page", "--token",
                           "--token-file", "--face", "--performer", "--key", "--for", "--log-limit"})
    replay.excludes(command.option(name));
  add_json_flag(command, options->json);
}

}  // namespace mien::app
