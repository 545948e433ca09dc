#include "app/live/live_command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdio>
#include <fstream>
#include <string>
#include <utility>

#include "app/command.h"
#include "app/json_output.h"
#include "app/live/camera_feed.h"
#include "app/live/page_address.h"
#include "app/live/phones_beside.h"
#include "mien/core/units.h"
#include "mien/live/network_interfaces.h"
#include "mien/live/unheard.h"
#include "mien/shaping/blinks.h"

namespace mien::app {
namespace {

/// The most memory that this process ever had resident, in MiB; null where the system does not tell.
Json peak_memory_mb() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;)
    if (double kb = 0; word == "VmHWM:" && status >> kb) return kb / 1024;
  return nullptr;
}

/// Each port and, where that is every one, the interfaces by which it is reached now.
Json listening_json(const live::EngineSummary& summary) {
  Json all = Json::array();
  for (const std::string& address : summary.listening) {
    Json interfaces = Json::array();
    const bool every = live::is_on_every_interface(address);
    if (every)
      for (const live::NetworkInterface& one : live::reached_by(address, summary.network.interfaces))
        interfaces.push_back({{"name", one.name}, {"address", one.address}});
    all.push_back({{"address", address}, {"every_interface", every}, {"interfaces", std::move(interfaces)}});
  }
  return all;
}

Json summary_json(const live::EngineSummary& summary) {
  const bool none = summary.latency.count() == 0;
  const auto ms = [none](Duration d) { return none ? Json() : Json(1e3 * to_seconds(d)); };
  Json sinks = Json::array();
  for (const sink::Status& sink : summary.sinks)
    sinks.push_back({{"address", sink.address}, {"sent", sink.sent}, {"failed", sink.failed}});
  Json lines = Json::array();
  for (const live::SerialPort::Status& line : summary.lines)
    lines.push_back({{"address", line.address},
                     {"open", line.open},
                     {"unplugged", line.unplugged},
                     {"bytes", line.bytes},
                     {"overlong", line.overlong}});
  Json cameras = Json::array();
  for (const live::CameraStatus& camera : summary.cameras) cameras.push_back(Json(live::camera_json(camera)));
  Json links = Json::array();
  for (const session::Report::Link& link : summary.report.links)
    links.push_back({{"device", link.device},
                     {"state", sensor::link_state_name(link.health.state)},
                     {"lost", link.health.lost},
                     {"late", link.health.late},
                     {"reordered", link.health.reordered},
                     {"doubled", link.health.doubled}});
  return {{"frames", summary.frames},
          {"missed", summary.missed},
          {"kernels", summary.kernels},
          {"hash", summary.hash},
          {"latency_ms",
           {{"p50", ms(summary.latency.percentile(0.5))},
            {"p99", ms(summary.latency.percentile(0.99))},
            {"max", ms(summary.latency.largest())}}},
          {"hold_ms",
           {{"last", 1e3 * to_seconds(summary.report.hold)},
            {"max", 1e3 * to_seconds(summary.report.longest_hold)}}},
          {"peak_memory_mb", peak_memory_mb()},
          {"datagrams", summary.datagrams},
          {"dropped", summary.dropped},
          {"malformed", summary.malformed},
          {"refused", summary.report.refused},
          {"evicted", summary.evicted},
          {"listening", listening_json(summary)},
          {"only", summary.network.only},
          {"elsewhere", summary.network.elsewhere},
          {"sealed", summary.network.sealed},
          {"unsealed", summary.network.unsealed},
          {"calibrations", summary.report.calibration.versions.size()},
          {"calibration", summary.report.calibration.state},
          {"rotation_sigma_deg", summary.report.calibration.sigma_rad
                                     ? Json(kDegPerRad * *summary.report.calibration.sigma_rad)
                                     : Json()},
          {"prompt", summary.report.calibration.prompt},
          {"take", summary.take ? Json(summary.take->string()) : Json()},
          {"recording_error", summary.recording_error},
          {"log",
           {{"bytes", summary.log.bytes},
            {"limit", summary.log.limit},
            {"payload_bytes", summary.log.payload_bytes},
            {"payload_limit", summary.log.payload_limit},
            {"hours_left", summary.log.seconds_left ? Json(*summary.log.seconds_left / 3600) : Json()}}},
          {"sinks", std::move(sinks)},
          {"lines", std::move(lines)},
          {"cameras", std::move(cameras)},
          {"links", std::move(links)}};
}

/// By what a port on every interface is reached: ", every interface: wlan0 192.168.1.7, lo 127.0.0.1".
std::string reach_text(const std::string& address, const live::NetworkState& network) {
  if (!live::is_on_every_interface(address)) return {};
  std::string text = ", every interface";
  const char* between = ": ";
  for (const live::NetworkInterface& one : live::reached_by(address, network.interfaces)) {
    text += fmt::format("{}{} {}", between, one.name, one.address);
    between = ", ";
  }
  return text;
}

std::string latency_text(const live::Latencies& latency) {
  if (latency.count() == 0) return "no latency without a frame";
  const auto ms = [](Duration d) { return 1e3 * to_seconds(d); };
  return fmt::format("latency p50 {:.2f} ms, p99 {:.2f} ms, at most {:.2f} ms", ms(latency.percentile(0.5)),
                     ms(latency.percentile(0.99)), ms(latency.largest()));
}

/// "http://192.168.1.7/: 812 pictures of eye_L, 3 broken, 2 refused (progressive)".
std::string camera_text(const live::CameraStatus& camera) {
  std::string text =
      fmt::format("{}: {} pictures of {}", camera.address, camera.pictures.whole, camera.sensor);
  const auto add = [&text](std::uint64_t count, std::string_view what) {
    if (count > 0) text += fmt::format(", {} {}", count, what);
  };
  add(camera.pictures.broken, "broken");
  add(camera.pictures.overlong, "too long");
  for (const sensor::Refusal& one : camera.refusals) add(one.count, fmt::format("refused ({})", one.why));
  add(camera.too_fast, "too fast");
  return text;
}

Result<void> no_frame_came(live::Unheard why, const session::Report& report) {
  const auto failed = [](std::string what, const char* fix) {
    return fail(ErrorCode::io, std::move(what), "no frame came", fix);
  };
  switch (why) {
    case live::Unheard::silence:
      return failed("nothing was received",
                    "see that the devices are on, and send to where the session listened");
    case live::Unheard::elsewhere:
      return failed("packets came, but by an interface or address that the page had excluded",
                    "let the page listen on every interface, or on the one that the devices send to");
    case live::Unheard::not_sealed:
      return failed("packets did that were not sealed with the session's key",
                    "pair the devices with it, or leave --key out");
    case live::Unheard::not_opened:
      return failed("packets did that are sealed with a key", "give the devices' key with --key");
    case live::Unheard::other_version: {
      std::string versions;
      for (const session::Report::UnknownVersion& packets : report.unknown_versions)
        versions +=
            fmt::format("{}{} version {}", versions.empty() ? "" : ", ", packets.protocol, packets.version);
      return failed("packets did of versions that this program does not know: " + versions,
                    "update this program, or what sends there");
    }
    case live::Unheard::unreadable:
      return failed("packets did, but none that could be read",
                    "see that what sends there is a device that docs/guide/devices.md names");
    case live::Unheard::no_reference:
      break;
  }
  return failed("packets did, but none of the rig's reference sensor",
                "docs/reference/links.md says why that may be");
}

std::string log_text(const live::Spool::Usage& log) {
  const std::string used = fmt::format("{:.3g} of {:g} GB", 1e-9 * static_cast<double>(log.bytes),
                                       1e-9 * static_cast<double>(log.limit));
  return log.seconds_left ? fmt::format("{}, {:.1f} h left", used, *log.seconds_left / 3600) : used;
}

void print_opening(std::FILE* out, const LiveSession& session) {
  const live::Engine& engine = *session.engine;
  const live::NetworkState network = engine.network();
  bool reachable = false;
  for (const std::string& address : engine.listening()) {
    reachable = reachable || !live::is_on_this_machine(address);
    fmt::print(out, "Listening on {}{}\n", address, reach_text(address, network));
  }
  for (const auto& [address, sensor] : session.cameras)
    if (is_camera(address))
      fmt::print(out, "Asking {} for its pictures, {}'s\n", address, sensor);
    else
      fmt::print(out, "Pictures on {} are {}'s\n", address, sensor);
  for (const std::string& phone : session.phones) fmt::print(out, "Asking {} for its frames\n", phone);
  if (!session.without_address.empty())
    fmt::print(out, "No --listen {} for {}: missing cameras\n",
               session.cameras.empty() ? "http://HOST/ is given" : "is left",
               fmt::join(session.without_address, ", "));
  if (!session.pictures.empty()) fmt::print(out, "{}\n", session.pictures);
  if (network.sealed)
    fmt::print(out, "Only devices with the key are received{}\n",
               network.unsealed.empty()
                   ? ""
                   : ", and pictures, which no key seals: who answers as a camera is believed");
  else if (reachable)
    fmt::print(out, "There is no key, so anybody there can send{}\n",
               network.open.empty() ? "; --key admits only paired devices"
                                    : "; the page or --listen names one interface, --key admits only paired "
                                      "devices");
  for (const std::string& address : session.out) fmt::print(out, "Sending to {}\n", address);
  if (!engine.page().empty())
    fmt::print(out, "The page is at {}\n",
               fmt::join(openable_addresses(engine.page(), own_addresses()), "\n            or "));
  fmt::print(out, "Ctrl-C ends it\n");
}

Result<void> print_closing(const live::EngineSummary& summary, bool as_json) {
  if (as_json) {
    print_json(summary_json(summary));
  } else {
    fmt::print("{} frames, {} missed; {}\n", summary.frames, summary.missed, latency_text(summary.latency));
    if (summary.report.longest_hold > Duration::zero())
      fmt::print("Frames were held up to {:.0f} ms, beside that latency: packets arrived late\n",
                 1e3 * to_seconds(summary.report.longest_hold));
    if (summary.frames > 0 && summary.report.calibration.state == "watching")
      fmt::print("Nothing was ever calibrated, so every frame is neutral: {}\n",
                 summary.report.calibration.prompt);
    if (summary.report.calibration.sigma_rad)
      fmt::print("Rotations were known to {:.1f} degrees at the end\n",
                 kDegPerRad * *summary.report.calibration.sigma_rad);
    for (const sink::Status& sink : summary.sinks)
      fmt::print("{}: {} sent, {} failed{}{}\n", sink.address, sink.sent, sink.failed,
                 sink.note.empty() ? "" : "; ", sink.note);
    for (const live::CameraStatus& camera : summary.cameras) fmt::print("{}\n", camera_text(camera));
    fmt::print("The session's log took {}\n", log_text(summary.log));
    if (summary.take) fmt::print("Wrote {}\n", summary.take->string());
    fmt::print("kernels {}, hash {}\n", summary.kernels, summary.hash);
  }
  if (!summary.recording_error.empty())
    return fail(ErrorCode::io, summary.recording_error, summary.take ? summary.take->string() : "recording");
  if (summary.frames > 0) return {};
  return no_frame_came(
      live::why_unheard({summary.datagrams, summary.network.elsewhere, summary.network.sealed},
                        summary.report),
      summary.report);
}

}  // namespace

Option add_session_options(Command command, LiveRequest& request) {
  const Option listen = command.add_option(
      "--listen", request.listen,
      "Where devices send to: udp://HOST:PORT, or a serial line, serial:/dev/ttyUSB0[?baud=250000]; or a "
      "camera that is asked for its pictures, http://HOST[:PORT][/PATH]; or a phone, livelink://HOST[:PORT] "
      "where Live Link Face sends to, ifacialmocap://PHONE one that is asked. Cameras and serial lines are "
      "the "
      "rig's cameras in their order, the first its first and so on; lines of other devices stand behind "
      "them. May be given often. Devices' languages are told apart by what they say (default: "
      "udp://0.0.0.0:5005 and udp://0.0.0.0:6969)");
  add_rig_option(command, request.rig);
  command.add_option("--model", request.model,
                     "The live model (default: the one in models/ for the rig's sensors); a folder of "
                     "models where the rig has sensors of several kinds");
  command.add_option(
      "--constraints", request.constraints,
      "Rules between shapes that what is shown obeys: a file as rigs/constraints/ict.toml, or off "
      "for none (default: that file's rule that always holds, mouthClose at most jawOpen)");
  command
      .add_option("--blinks", request.blinks_per_min,
                  "Blinks a minute of lids that no sensor observes; 0: none. More: eyes close more often")
      .in_range(0.0, shaping::Blinks::kRateAtMost)
      .show_default();
  command
      .add_option("--audio", request.audio,
                  "What is heard: a microphone of this machine (default, or a part of its name), a WAV file "
                  "in real time, page (that of a browser that looks at the page) or network (one that sends "
                  "its blocks, as mien perform's). Mouth and jaw follow it where no sensor tells them, and a "
                  "recording keeps it. Nothing is heard unless asked")
      .check([](const std::string& file) { return file.empty() ? "the sound has no name" : ""; });
  command
      .add_option("--hears-by", request.hears_by,
                  "How the mouth is heard: network (of any language) or phones (PocketSphinx's, English)")
      .one_of({"network", "phones"});
  command
      .add_option("--phone", request.phone,
                  "What a phone is for: truth (recorded beside the sensors, it moves nothing) or source (the "
                  "face follows it as it does trackers)")
      .one_of({"truth", "source"});
  command.add_flag("--images", request.images,
                   "Keeps the cameras' pictures in recordings, so that another model can look at them later; "
                   "else only what the model finds in them");
  command
      .add_flag("--no-audio", request.no_audio,
                "Nothing is heard, and no microphone opened, from the page either")
      .excludes(command.option("--audio"));
  command.add_flag("--force", request.force, "Replace an existing take");
  command
      .add_option(
          "--page", request.page,
          "Where the page is served: HOST[:PORT], or off; 0.0.0.0 lets other machines see it. Another host "
          "than this machine asks for a token")
      .show_default();
  add_token_options(command, request.token,
                    "What the page's visitors must know (default: drawn anew where one is needed)");
  command
      .add_option(
          "--face", request.face,
          "The face that the page shows: builtin, builtin:SEED, an ICT-FaceKit folder, a .glb or .vrm")
      .show_default();
  command.add_option("--performer", request.performer, "Who is captured: goes into takes");
  command.add_option("--key", request.key,
                     "A file with the key that devices were paired with; others are then refused. The page's "
                     "Pair makes one");
  command.add_option("--for", request.seconds, "End by itself after so many seconds")
      .number_between(0.1, 1e6);
  command
      .add_option(
          "--log-limit", request.log_limit_gb,
          "How many GB the session's temporary log may take in the folder of takes, pictures and sound "
          "at most half of them; a session that reaches it goes on, but cannot be recorded any more")
      .number_between(0.001, 1e6)
      .show_default();
  return listen;
}

Result<void> run_session(const LiveSession& session, bool json, const std::string& more,
                         const std::function<void(const live::Status&)>& seen) {
  std::FILE* const out = json ? stderr : stdout;
  print_opening(out, session);
  if (!more.empty()) fmt::print(out, "{}\n", more);
  std::fflush(out);
  live::EngineListener listener;
  listener.told = [out](const std::string& news) {
    clear_progress();
    fmt::print(out, "{}\n", news);
    std::fflush(out);
  };
  listener.seen = [&listener, &seen, phones = PhonesBeside()](const live::Status& status) mutable {
    for (const std::string& news : phones.tell(status.report)) listener.told(news);
    if (seen) seen(status);
  };
  MIEN_TRY_ASSIGN(const live::EngineSummary summary, session.engine->run(stop_asked(), listener));
  clear_progress();
  return print_closing(summary, json);
}

}  // namespace mien::app
