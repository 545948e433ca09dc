#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <utility>

#include "app/command.h"
#include "app/json_output.h"
#include "app/live_session.h"
#include "app/page_address.h"
#include "mien/live/registry.h"
#include "mien/live/replay.h"
#include "mien/model/kernels.h"

namespace mien::app {
namespace {

struct Options {
  LiveRequest request;
  std::filesystem::path replay;
  bool json = false;
};

nlohmann::ordered_json summary_json(const live::EngineSummary& summary) {
  const auto ms = [](Duration d) { return 1e3 * to_seconds(d); };
  nlohmann::ordered_json sinks = nlohmann::ordered_json::array();
  for (const sink::Status& sink : summary.sinks)
    sinks.push_back({{"address", sink.address}, {"sent", sink.sent}, {"failed", sink.failed}});
  nlohmann::ordered_json lines = nlohmann::ordered_json::array();
  for (const live::SerialPort::Status& line : summary.lines)
    lines.push_back({{"address", line.address},
                     {"open", line.open},
                     {"unplugged", line.unplugged},
                     {"bytes", line.bytes},
                     {"overlong", line.overlong}});
  nlohmann::ordered_json links = nlohmann::ordered_json::array();
  for (const live::Report::Link& link : summary.report.links)
    links.push_back({{"device", link.device},
                     {"state", sensor::link_state_name(link.health.state)},
                     {"lost", link.health.lost},
                     {"late", link.health.late},
                     {"reordered", link.health.reordered},
                     {"doubled", link.health.doubled}});
  return {{"frames", summary.frames},
          {"missed", summary.missed},
          {"kernels", model::kernel_name()},
          {"hash", summary.hash},
          {"latency_ms",
           {{"p50", ms(summary.latency.percentile(0.5))},
            {"p99", ms(summary.latency.percentile(0.99))},
            {"max", ms(summary.latency.largest())}}},
          {"datagrams", summary.datagrams},
          {"dropped", summary.dropped},
          {"malformed", summary.malformed},
          {"evicted", summary.evicted},
          {"calibrations", summary.report.calibration.versions.size()},
          {"calibration", summary.report.calibration.state},
          {"prompt", summary.report.calibration.prompt},
          {"take", summary.take ? nlohmann::ordered_json(summary.take->string()) : nlohmann::ordered_json()},
          {"recording_error", summary.recording_error},
          {"sinks", std::move(sinks)},
          {"lines", std::move(lines)},
          {"links", std::move(links)}};
}

Result<void> run_replay(Options options) {
  MIEN_TRY_ASSIGN(const take::Take take, take::Take::open(options.replay));
  MIEN_TRY_ASSIGN(const std::filesystem::path model, live::live_model(take.rig(), options.request.model));
  MIEN_TRY_ASSIGN(const std::unique_ptr<live::Session> session, live::make_session(take.rig(), model));
  MIEN_TRY_ASSIGN(const std::vector<take::Tick> ticks, take.ticks());
  const Progress progress = terminal_progress("replay");
  std::size_t calibrated = 0;
  MIEN_TRY(live::replay(take, *session, [&](const take::Tick&, const face::OutputFrame&) {
    if (!session->versions().empty()) ++calibrated;
    const auto done = static_cast<double>(session->frames());
    return session->frames() % 64 != 0 || progress(done / static_cast<double>(ticks.size()), "replaying");
  }));
  progress(1, "replayed");
  const std::string hash = session->hash();
  MIEN_TRY_ASSIGN(const std::string live_hash, take.note("live.hash"));
  live::Report report;
  session->report(ticks.back().fired, report);
  if (options.json) {
    print_json({{"take", options.replay.string()},
                {"frames", session->frames()},
                {"calibrated_frames", calibrated},
                {"calibration", report.calibration.state},
                {"prompt", report.calibration.prompt},
                {"kernels", model::kernel_name()},
                {"hash", hash},
                {"live_hash", live_hash}});
  } else {
    fmt::print("{}: {} frames, kernels {}, hash {}\n", options.replay.string(), session->frames(),
               model::kernel_name(), hash);
    if (!live_hash.empty())
      fmt::print("{}\n",
                 live_hash == hash
                     ? "The same bits as the session that recorded it."
                     : "Not the bits of the session that recorded it: another model, kernels or build.");
  }
  return {};
}

Result<void> run(Options options) {
  if (!options.replay.empty()) return run_replay(std::move(options));
  const std::vector<std::string> sinks = options.request.out;
  MIEN_TRY_ASSIGN(const LiveSession session, open_live(std::move(options.request)));
  live::Engine* const engine = session.engine.get();
  std::FILE* const out = options.json ? stderr : stdout;
  for (const std::string& address : engine->listening()) fmt::print(out, "Listening on {}\n", address);
  for (const std::string& address : sinks) fmt::print(out, "Sending to {}\n", address);
  if (!engine->page().empty())
    fmt::print(out, "The page is at {}\n",
               fmt::join(openable_addresses(engine->page(), own_addresses()), "\n            or "));
  fmt::print(out, "Ctrl-C ends it\n");
  std::fflush(out);

  MIEN_TRY_ASSIGN(const live::EngineSummary summary,
                  engine->run(stop_asked(), [out](const std::string& news) {
                    fmt::print(out, "{}\n", news);
                    std::fflush(out);
                  }));
  if (options.json) {
    print_json(summary_json(summary));
  } else {
    fmt::print("{} frames, {} missed; latency p50 {:.2f} ms, p99 {:.2f} ms, at most {:.2f} ms\n",
               summary.frames, summary.missed, 1e3 * to_seconds(summary.latency.percentile(0.5)),
               1e3 * to_seconds(summary.latency.percentile(0.99)),
               1e3 * to_seconds(summary.latency.largest()));
    for (const sink::Status& sink : summary.sinks)
      fmt::print("{}: {} sent, {} failed{}{}\n", sink.address, sink.sent, sink.failed,
                 sink.note.empty() ? "" : "; ", sink.note);
    if (summary.take) fmt::print("Wrote {}\n", summary.take->string());
    fmt::print("kernels {}, hash {}\n", model::kernel_name(), summary.hash);
  }
  if (!summary.recording_error.empty())
    return fail(ErrorCode::io, summary.recording_error, summary.take ? summary.take->string() : "recording");
  return {};
}

}  // namespace

void add_live_command(Commands& commands) {
  auto options = std::make_shared<Options>();
  LiveRequest& request = options->request;
  CLI::App* command = commands.add(
      "live", "Devices in, avatar out: tracks live, with page, sinks and recording",
      "mien live --listen udp://0.0.0.0:5005 --out livelink://192.168.1.7 --out vmc://127.0.0.1 --record "
      "take.mien",
      [options] { return run(*options); });
  CLI::Option* listen = command->add_option(
      "--listen", request.listen,
      "Where devices send to: udp://HOST:PORT, or a serial line, serial:/dev/ttyUSB0[?baud=250000]; may be "
      "given often. Devices' languages are told apart by what they say (default: udp://0.0.0.0:5005 and "
      "udp://0.0.0.0:6969)");
  CLI::Option* sinks = command->add_option(
      "--out", request.out,
      "Where the face goes: livelink://, vmc://, vrchat://, ifacialmocap://, ws://HOST[:PORT] "
      "or csv:FILE; may be given often");
  command->add_option("--rig", request.rig, "Which sensors sit where (default: rigs/default.toml)");
  command->add_option("--model", request.model,
                      "The live model (default: the one in models/ for the rig's sensors)");
  CLI::Option* record =
      command->add_option("--record", request.record, "The take to write, from the first packet on");
  command->add_flag("--force", request.force, "Replace an existing take");
  command
      ->add_option("--takes", request.takes,
                   "The folder of takes that the page records and shows (default: that of --record, or the "
                   "present one)")
      ->check(CLI::ExistingDirectory);
  command
      ->add_option(
          "--page", request.page,
          "Where the page is served: HOST[:PORT], or off; 0.0.0.0 lets other machines see it. Another host "
          "than this machine asks for a token")
      ->capture_default_str();
  command->add_option("--token", request.token,
                      "What the page's visitors must know (default: drawn anew where one is needed)");
  command
      ->add_option(
          "--face", request.face,
          "The face that the page shows: builtin, builtin:SEED, an ICT-FaceKit folder, a .glb or .vrm")
      ->capture_default_str();
  command->add_option("--performer", request.performer, "Who is captured: goes into takes");
  command->add_option("--key", request.key,
                      "A file with the key that devices were paired with; others are then not heard");
  command->add_option("--for", request.seconds, "End by itself after so many seconds")
      ->check(number_between(0.1, 1e6));
  command
      ->add_option("--replay", options->replay,
                   "Instead of devices a take's log, as fast as it goes: prints frames, kernels and hash")
      ->check(CLI::ExistingFile)
      ->excludes(listen)
      ->excludes(sinks)
      ->excludes(record);
  command->add_flag("--json", options->json, "Print one JSON object at the end");
}

}  // namespace mien::app
