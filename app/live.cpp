#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sodium.h>

#include <charconv>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <memory>

#include "app/command.h"
#include "app/json_output.h"
#include "app/page_files.h"
#include "mien/core/files.h"
#include "mien/face/load.h"
#include "mien/live/engine.h"
#include "mien/live/registry.h"
#include "mien/live/replay.h"
#include "mien/model/kernels.h"
#include "mien/render/gltf_export.h"

namespace mien::app {
namespace {

struct Options {
  std::string rig;
  std::string model;
  std::vector<std::string> listen;
  std::vector<std::string> out;
  std::filesystem::path record;
  bool force = false;
  std::filesystem::path takes = ".";
  std::string page = "127.0.0.1:8740";
  std::string token;
  std::string face = "builtin";
  std::string performer;
  std::string key;
  double seconds = 0;
  std::filesystem::path replay;
  bool json = false;
};

std::string now_utc() {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(now));
}

Result<model::ModelFile> read_live_model(std::string& path) {
  if (path.empty()) {
    MIEN_TRY_ASSIGN(path, find_resource("models/live.safetensors"));
  }
  return model::read_model(path);
}

/// A key file holds a number of 0 to 255 and 64 hexadecimal digits.
Result<std::vector<live::PairingKey>> read_key(const std::string& path) {
  if (path.empty()) return std::vector<live::PairingKey>();
  MIEN_TRY_ASSIGN(const std::string text, read_text(path, 4096));
  live::PairingKey key;
  unsigned id = 0;
  const auto [end, wrong] = std::from_chars(text.data(), text.data() + text.size(), id);
  std::size_t length = 0;
  const char* rest = nullptr;
  const bool good = wrong == std::errc{} && id < 256 &&
                    sodium_hex2bin(reinterpret_cast<unsigned char*>(key.secret.data()), key.secret.size(),
                                   end, static_cast<std::size_t>(text.data() + text.size() - end), " \t\r\n",
                                   &length, &rest) == 0 &&
                    length == key.secret.size() && rest == text.data() + text.size();
  if (!good)
    return fail(ErrorCode::malformed, "not a key file", path,
                "write a number from 0 to 255, a space and 64 hexadecimal digits into it");
  key.id = static_cast<std::uint8_t>(id);
  return std::vector{key};
}

Result<std::optional<live::PageSettings>> page_settings(const Options& options,
                                                        std::span<const std::byte> face_glb) {
  if (options.page == "off") return std::optional<live::PageSettings>();
  live::PageSettings page;
  const std::size_t colon = options.page.rfind(':');
  const std::string digits = colon == std::string::npos ? "" : options.page.substr(colon + 1);
  const auto [end, wrong] = std::from_chars(digits.data(), digits.data() + digits.size(), page.port);
  if (wrong != std::errc{} || end != digits.data() + digits.size())
    return fail(ErrorCode::bad_usage, "not an address for the page", options.page,
                "write it as 127.0.0.1:8740, or off");
  page.host = options.page.substr(0, colon);
  if (page.host.starts_with('[') && page.host.ends_with(']'))
    page.host = page.host.substr(1, page.host.size() - 2);
  page.token = options.token;
  const bool loopback = page.host == "localhost" || page.host == "::1" || page.host.starts_with("127.");
  if (!loopback && page.token.empty()) {
    // Whoever opens the page to a network gets a token, whether they thought of one or not.
    std::array<unsigned char, 16> bytes{};
    randombytes_buf(bytes.data(), bytes.size());
    for (const unsigned char byte : bytes) page.token += fmt::format("{:02x}", byte);
  }
  page.assets = page_files();
  if (page.assets.empty())
    return fail(ErrorCode::not_found, "this program was built without its page", options.page,
                "run with --page off, or build it with npm installed");
  page.assets.push_back({"/face.glb", "model/gltf-binary", face_glb});
  return std::optional(std::move(page));
}

nlohmann::ordered_json summary_json(const live::EngineSummary& summary) {
  const auto ms = [](Duration d) { return 1e3 * to_seconds(d); };
  nlohmann::ordered_json sinks = nlohmann::ordered_json::array();
  for (const sink::Status& sink : summary.sinks)
    sinks.push_back({{"address", sink.address}, {"sent", sink.sent}, {"failed", sink.failed}});
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
          {"calibrations", summary.report.calibration.versions.size()},
          {"take", summary.take ? nlohmann::ordered_json(summary.take->string()) : nlohmann::ordered_json()},
          {"recording_error", summary.recording_error},
          {"sinks", std::move(sinks)},
          {"links", std::move(links)}};
}

Result<void> run_replay(Options options) {
  MIEN_TRY_ASSIGN(const take::Take take, take::Take::open(options.replay));
  MIEN_TRY_ASSIGN(model::ModelFile model, read_live_model(options.model));
  MIEN_TRY_ASSIGN(const std::unique_ptr<live::Session> session,
                  live::make_session(take.rig(), std::move(model)));
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
  if (options.json) {
    print_json({{"take", options.replay.string()},
                {"frames", session->frames()},
                {"calibrated_frames", calibrated},
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
  live::EngineSettings settings;
  if (options.rig.empty()) {
    MIEN_TRY_ASSIGN(const std::filesystem::path rig, find_resource("rigs/default.toml"));
    options.rig = rig.string();
  }
  MIEN_TRY_ASSIGN(const std::string rig_toml, read_text(options.rig));
  MIEN_TRY_ASSIGN(const sensor::Rig rig, sensor::parse_rig(rig_toml, options.rig));
  MIEN_TRY_ASSIGN(const model::ModelFile model, read_live_model(options.model));
  MIEN_TRY_ASSIGN(const std::vector<live::PairingKey> keys, read_key(options.key));
  if (!options.record.empty()) MIEN_TRY(check_output(options.record, {".mien"}));

  std::vector<std::byte> face_glb;
  if (options.page != "off") {
    MIEN_TRY_ASSIGN(const face::Face face, face::load_face(options.face));
    MIEN_TRY_ASSIGN(face_glb, render::encode_gltf(face, nullptr, render::GltfKind::binary));
  }
  MIEN_TRY_ASSIGN(settings.page, page_settings(options, face_glb));

  settings.listen = options.listen;
  if (settings.listen.empty()) settings.listen = {"udp://0.0.0.0:5005", "udp://0.0.0.0:6969"};
  settings.out = options.out;
  if (!options.record.empty()) settings.record = options.record;
  settings.replace = options.force;
  settings.takes = options.takes;
  if (options.seconds > 0) settings.seconds = options.seconds;
  settings.model = std::filesystem::path(options.model).filename().string();
  settings.header.software = "mien " MIEN_VERSION;
  settings.header.performer = options.performer;
  settings.header.script = "live";
  settings.header.devices = "live";
  settings.header.face = options.face;
  settings.header.prologue = "none";
  settings.header.rig_toml = rig_toml;
  settings.header.created_utc = now_utc();
  settings.make_session = [model](const sensor::Rig& taken) { return live::make_session(taken, model); };

  MIEN_TRY_ASSIGN(std::unique_ptr<live::Session> session, live::make_session(rig, model, {}, keys));
  MIEN_TRY_ASSIGN(const std::unique_ptr<live::Engine> engine,
                  live::Engine::open(std::move(settings), std::move(session)));
  std::FILE* const out = options.json ? stderr : stdout;
  for (const std::string& address : engine->listening()) fmt::print(out, "Listening on {}\n", address);
  for (const std::string& address : options.out) fmt::print(out, "Sending to {}\n", address);
  if (!engine->page().empty()) fmt::print(out, "The page is at {}\n", engine->page());
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
    if (summary.take) fmt::print("{}\n", summary.take->string());
    fmt::print("hash {}\n", summary.hash);
  }
  if (!summary.recording_error.empty())
    return fail(ErrorCode::io, summary.recording_error, summary.take ? summary.take->string() : "recording");
  return {};
}

}  // namespace

void add_live_command(Commands& commands) {
  auto options = std::make_shared<Options>();
  CLI::App* command = commands.add(
      "live", "Devices in, avatar out: tracks live, with page, sinks and recording",
      "mien live --listen udp://0.0.0.0:5005 --out livelink://192.168.1.7 --out vmc://127.0.0.1 --record "
      "take.mien",
      [options] { return run(*options); });
  command->add_option(
      "--listen", options->listen,
      "Where devices send to: udp://HOST:PORT; may be given often. Our own nodes and SlimeVR's "
      "are told apart by what they say (default: udp://0.0.0.0:5005 and udp://0.0.0.0:6969)");
  command->add_option(
      "--out", options->out,
      "Where the face goes: livelink://, vmc://, vrchat://, ifacialmocap://, ws://HOST[:PORT] "
      "or csv:FILE; may be given often");
  command->add_option("--rig", options->rig, "Which sensors sit where (default: rigs/default.toml)");
  command->add_option("--model", options->model, "The live model (default: models/live.safetensors)");
  command->add_option("--record", options->record, "The take to write, from the first packet on");
  command->add_flag("--force", options->force, "Replace an existing take");
  command->add_option("--takes", options->takes, "The folder of takes that the page records and shows")
      ->check(CLI::ExistingDirectory)
      ->capture_default_str();
  command
      ->add_option(
          "--page", options->page,
          "Where the page is served: HOST:PORT, or off. Another host than this machine asks for a token")
      ->capture_default_str();
  command->add_option("--token", options->token,
                      "What the page's visitors must know (default: drawn anew where one is needed)");
  command
      ->add_option(
          "--face", options->face,
          "The face that the page shows: builtin, builtin:SEED, an ICT-FaceKit folder, a .glb or .vrm")
      ->capture_default_str();
  command->add_option("--performer", options->performer, "Who is captured: goes into takes");
  command->add_option("--key", options->key,
                      "A file with the key that devices were paired with; others are then not heard");
  command->add_option("--for", options->seconds, "End by itself after so many seconds")
      ->check(number_between(0.1, 1e6));
  command
      ->add_option("--replay", options->replay,
                   "Instead of devices a take's log, as fast as it goes: prints frames, kernels and hash")
      ->check(CLI::ExistingFile);
  command->add_flag("--json", options->json, "Print one JSON object at the end");
}

}  // namespace mien::app
