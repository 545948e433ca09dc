#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <filesystem>
#include <future>
#include <iterator>
#include <memory>
#include <optional>
#include <utility>

#include "app/chosen_face.h"
#include "app/command.h"
#include "app/json_output.h"
#include "app/live/pairing_key.h"
#include "app/live/perform_cameras.h"
#include "app/live/perform_network.h"
#include "app/performance.h"
#include "app/read_aloud.h"
#include "app/seed_option.h"
#include "mien/builtin_face/load_face.h"
#include "mien/builtin_face/person.h"
#include "mien/core/files.h"
#include "mien/core/wav.h"
#include "mien/performer/encore.h"
#include "mien/performer/long_motion.h"
#include "mien/sensor/rig_part.h"
#include "mien/virtual/headset/timed_failure.h"
#include "mien/virtual/perform_take.h"

namespace mien::app {
namespace {

struct PerformOptions {
  virt::PerformRequest request;
  NetworkOptions network;
  std::optional<Option> phone, seconds_option;
  bool ahead = false;
  std::string cameras;
  std::string failure;
  std::string key;
  std::string motion;
  std::string block = "mixed";
  double seconds = 60;
  std::string voice;
  std::string sound;
  std::string rig;
  std::string prologue = "short";
  std::string pace = "fast";
  bool json = false;
};

/// Performs into a take.
Result<void> run_take(const PerformOptions& options) {
  MIEN_TRY_ASSIGN(const virt::PerformSummary summary,
                  virt::perform_take(options.request, terminal_progress("perform")));
  const std::string take = options.request.take.string();
  if (options.json)
    print_json({{"take", take},
                {"duration_s", summary.duration_s},
                {"frames", summary.frames},
                {"packets", summary.packets},
                {"samples", summary.samples}});
  else
    fmt::print("{}: {:.1f} s, {} frames, {} packets, {} samples\n", take, summary.duration_s, summary.frames,
               summary.packets, summary.samples);
  return {};
}

Json network_json(const std::string& to, const NetworkSummary& summary) {
  return {{"to", to},
          {"duration_s", summary.performed_s},
          {"rounds", summary.rounds},
          {"nodes", summary.nodes},
          {"answered", summary.answered},
          {"packets", summary.packets},
          {"refused", summary.refused},
          {"latest_ms", summary.latest_ms},
          {"stopped", summary.stopped}};
}

void print_network(const std::string& to, const NetworkSummary& summary) {
  fmt::print("{}: {:.1f} s{}, {} packets, {} refused{}; the latest went out {:.1f} ms late\n", to,
             summary.performed_s, summary.stopped ? " (stopped)" : "", summary.packets, summary.refused,
             summary.listening == 0
                 ? std::string()
                 : fmt::format(", {} of {} nodes answered", summary.answered, summary.listening),
             summary.latest_ms);
}

Result<void> check_listened(const std::string& to, const NetworkSummary& summary) {
  if (summary.stopped || !summary.nobody_listened()) return {};
  return fail(ErrorCode::io, "nobody listened there: every packet was refused", to,
              "start mien live first, and see that it listens on this port");
}

/// Performs to a receiver.
Result<void> run_network(const PerformOptions& options) {
  MIEN_TRY_ASSIGN(const NetworkSummary summary, perform_to_network(options.request, options.network));
  clear_progress();
  if (options.json)
    print_json(network_json(options.network.to, summary));
  else
    print_network(options.network.to, summary);
  return check_listened(options.network.to, summary);
}

Json cameras_json(const std::string& to, const CameraSummary& summary) {
  return {{"to", to},
          {"duration_s", summary.performed_s},
          {"rounds", summary.rounds},
          {"cameras", summary.cameras},
          {"watched", summary.watched},
          {"pictures", summary.pictures},
          {"skipped", summary.skipped},
          {"dropped", summary.dropped},
          {"latest_ms", summary.latest_ms},
          {"stopped", summary.stopped}};
}

void print_cameras(const std::string& to, const CameraSummary& summary) {
  fmt::print(
      "{}: {:.1f} s{}, {} pictures of {} cameras, {} asked for at the beginning, {} moments skipped, {} "
      "clients too slow; the latest went out {:.1f} ms late\n",
      to, summary.performed_s, summary.stopped ? " (stopped)" : "", summary.pictures, summary.cameras,
      summary.watched, summary.skipped, summary.dropped, summary.latest_ms);
}

CameraOptions camera_options(const PerformOptions& options, const std::string& to) {
  return {.to = to,
          .wait_s = options.network.wait_s,
          .loop = options.network.loop,
          .ahead = options.ahead,
          .start = nullptr};
}

/// Performs before cameras.
Result<void> run_cameras(const PerformOptions& options) {
  MIEN_TRY_ASSIGN(const CameraSummary summary,
                  perform_to_cameras(options.request, camera_options(options, options.network.to)));
  clear_progress();
  if (options.json)
    print_json(cameras_json(options.network.to, summary));
  else
    print_cameras(options.network.to, summary);
  return {};
}

/// Performs to a receiver and before cameras at once.
Result<void> run_both(const PerformOptions& options) {
  SharedStart start;
  const auto boards_send = [&]() -> Result<NetworkSummary> {
    NetworkOptions network = options.network;
    network.title.clear();  // The cameras show how far it is.
    network.start = &start;
    try {
      auto sent = perform_to_network(options.request, network);
      if (!sent || sent->stopped) start.stopped = true;
      return sent;
    } catch (const std::exception& error) {
      start.stopped = true;
      return fail(ErrorCode::internal, error.what(), options.network.to);
    }
  };
  std::future<Result<NetworkSummary>> boards = std::async(std::launch::async, boards_send);
  // Before the boards are waited for, however this ends.
  const std::unique_ptr<SharedStart, void (*)(SharedStart*)> ends(
      &start, [](SharedStart* at) { at->stopped = true; });
  CameraOptions camera = camera_options(options, options.cameras);
  camera.start = &start;
  const Result<CameraSummary> offered = perform_to_cameras(options.request, camera);
  if (!offered || offered->stopped) start.stopped = true;
  const Result<NetworkSummary> sent = boards.get();
  clear_progress();
  if (!sent) return std::unexpected(sent.error());
  if (!offered) return std::unexpected(offered.error());
  if (options.json) {
    Json both = network_json(options.network.to, *sent);
    both["cameras"] = cameras_json(options.cameras, *offered);
    print_json(both);
  } else {
    print_network(options.network.to, *sent);
    print_cameras(options.cameras, *offered);
  }
  return check_listened(options.network.to, *sent);
}

/// Checks where the performance is to go, before long work.
Result<void> check_network(PerformOptions& options) {
  const bool cameras = is_camera_address(options.network.to);
  if (!options.cameras.empty() && (cameras || !is_camera_address(options.cameras)))
    return fail(ErrorCode::bad_usage, "cameras beside boards have an address of their own",
                "--cameras " + options.cameras, "write --to udp://HOST:PORT --cameras http://HOST:PORT");
  if (options.ahead && !cameras && options.cameras.empty())
    return fail(ErrorCode::bad_usage, "only pictures are rendered ahead", "--ahead",
                "offer them: --to http://HOST:PORT");
  if (cameras) {
    if (!options.key.empty())
      return fail(ErrorCode::bad_usage, "cameras have no keys", "--key", "send to udp://HOST:PORT");
    if (options.request.phone)
      return fail(ErrorCode::bad_usage, "cameras are asked, and nobody sends for a phone beside them",
                  "--phone",
                  "write --to udp://HOST:PORT --cameras " + options.network.to + " --phone HOST[:PORT]");
    return {};
  }
  if (options.request.phone) {
    if (options.network.phone.empty())
      return fail(ErrorCode::bad_usage, "it was not said to whom the phone sends", "--phone",
                  "write --phone HOST[:PORT], where mien live --listen livelink:// hears it");
    MIEN_TRY(parse_phone_target(options.network.phone));
  }
  MIEN_TRY_ASSIGN(const NetworkTarget target, parse_target(options.network.to));
  if (!options.key.empty()) {
    if (target.language == virt::NodeLanguage::slimevr)
      return fail(ErrorCode::bad_usage, "SlimeVR's boards have no keys", "--key", "send to udp://HOST:PORT");
    MIEN_TRY_ASSIGN(options.network.key, read_pairing_key(options.key));
  }
  if (options.request.devices == "lab")
    return fail(ErrorCode::bad_usage, "the devices of --devices lab are on no network", options.network.to,
                "perform them with --take, or use --devices device");
  return {};
}

/// Checks whose skin it is, before long work.
Result<void> check_face(const std::string& what) {
  if (builtin_face::names_person(what)) {
    MIEN_TRY(builtin_face::find_person(what));
  } else {
    MIEN_TRY(builtin_face::load_face(what, face_progress(what)));
  }
  return {};
}

/// What is heard of a motion that is repeated, or cut, to last so long.
Sound as_long_as(const Sound& once, const face::Motion& motion, double seconds) {
  const double motion_s = motion.frames.empty() ? 0 : motion.duration_s() - motion.frames.front().time_s;
  Sound all{.rate_hz = once.rate_hz, .samples = {}};
  all.samples.reserve(static_cast<std::size_t>(std::ceil(seconds * once.rate_hz)));
  for (double begin_s = 0; begin_s < seconds; begin_s += motion_s + performer::kReturnS)
    mix(once, begin_s, std::min(seconds, begin_s + motion_s), all);
  return all;
}

/// What is heard of the performance, from its beginning on.
Result<void> write_sound(const PerformOptions& options) {
  MIEN_TRY(check_output(options.sound, {".wav"}));
  if (!options.request.sound)
    return fail(ErrorCode::bad_usage, "nothing is heard of this performance", "--sound " + options.sound,
                "take --script reading, or --voice espeak, or a --motion with sound");
  return write_file(options.sound, format_wav(*options.request.sound));
}

/// Says that a microphone is worn for nothing.
Result<void> tell_of_silence(const virt::PerformRequest& request) {
  if (request.sound) return {};
  MIEN_TRY_ASSIGN(const sensor::Rig rig, sensor::read_rig(request.rig));
  if (!sensor::sensors_of(rig, "speech").empty())
    fmt::print(
        stderr,
        "mien: {}: nothing is heard of this performance, so its microphone hears a room in which nobody "
        "speaks (take --script reading, or --voice espeak, or a --motion with sound)\n",
        request.rig.string());
  return {};
}

Result<void> run_perform(PerformOptions options) {
  virt::PerformRequest& request = options.request;
  request.phone = options.phone && options.phone->given();
  const bool to_network = !options.network.to.empty();
  if (!to_network && request.take.empty())
    return fail(ErrorCode::bad_usage, "it was not said where to", "perform",
                "give --take FILE, --to udp://HOST:PORT, or of cameras --to http://HOST:PORT");
  if (to_network) {
    MIEN_TRY(check_network(options));
  } else {
    if (!options.network.phone.empty())
      return fail(ErrorCode::bad_usage, "into a take nothing is sent", "--phone " + options.network.phone,
                  "leave out the address, or perform --to udp://HOST:PORT");
    MIEN_TRY(check_output(request.take, {".mien"}));
    MIEN_TRY(virt::check_take_is_new(request));
  }
  MIEN_TRY(check_face(request.face));
  if (!options.failure.empty()) {
    MIEN_TRY_ASSIGN(request.headset_failure, virt::parse_timed_failure(options.failure));
  }
  MIEN_TRY_ASSIGN(const performer::Block block, performer::parse_block(options.block));
  if (!options.motion.empty()) {
    MIEN_TRY_ASSIGN(Performance performance, load_performance(options.motion));
    request.motion = std::move(performance.motion);
    request.sound = std::move(performance.sound);
    request.script_name = std::filesystem::path(options.motion).filename().string();
    if (options.seconds_option && options.seconds_option->given()) {
      request.motion_s = options.seconds;
      if (request.sound) request.sound = as_long_as(*request.sound, *request.motion, options.seconds);
    }
  } else {
    std::vector<performer::Script> scripts = performer::piece_scripts(block, options.seconds);
    request.script_name = options.block;
    if (options.voice.empty()) options.voice = block == performer::Block::reading ? "espeak" : "babble";
    if (options.voice == "espeak") {
      MIEN_TRY_ASSIGN(request.sound, read_aloud(scripts, terminal_progress("reading aloud")));
    }
    request.script = std::move(scripts.front());
    request.later_scripts.assign(std::make_move_iterator(scripts.begin() + 1),
                                 std::make_move_iterator(scripts.end()));
  }
  if (!options.sound.empty()) MIEN_TRY(write_sound(options));
  request.prologue = performer::prologue_kind(options.prologue);
  request.real_time = options.pace == "real";
  request.software = "mien " MIEN_VERSION;
  MIEN_TRY_ASSIGN(request.rig, path_or(options.rig, "rigs/default.toml"));
  std::error_code code;
  if (!request.face.starts_with("builtin") && std::filesystem::exists(request.face, code)) {
    const auto whole = std::filesystem::weakly_canonical(request.face, code);
    if (!code) request.face = whole.string();  // A take must find it again from elsewhere.
  }
  MIEN_TRY(tell_of_silence(request));
  if (!to_network) return run_take(options);
  if (!options.cameras.empty()) return run_both(options);
  return is_camera_address(options.network.to) ? run_cameras(options) : run_network(options);
}

}  // namespace

void add_perform_command(Commands& commands) {
  auto options = std::make_shared<PerformOptions>();
  virt::PerformRequest& request = options->request;
  const Command command = commands.add(
      "perform", "A virtual performer plays a script or motion through sensors",
      "mien perform --motion talk.csv --take talk.mien\n  mien perform --script "
      "reading --to udp://127.0.0.1:5005\n  mien perform --rig rigs/headset.toml --seconds 40 "
      "--ahead --loop --to http://127.0.0.1:8081\n  mien perform --rig rigs/headset.toml --seconds "
      "20 --headset-failure hand@8-12 --take hand.mien\n  mien perform --script reading --phone --take "
      "phone.mien",
      [options] { return run_perform(*options); });
  const Option take = command.add_option("--take", request.take, "The take to write, with the truth in it");
  const Option to =
      command
          .add_option(
              "--to", options->network.to,
              "Who receives it in real time: udp://HOST:PORT (mien live) or slimevr://HOST:PORT; or "
              "where a headset's cameras can be asked for their pictures, one a port from this one on: "
              "http://HOST:PORT, an address of this machine")
          .excludes(take);
  command
      .add_option("--cameras", options->cameras,
                  "Of a performer with boards and cameras (rigs/imu_headset.toml): where the cameras can be "
                  "asked while the boards send --to udp://, as above")
      .needs(to);
  options->phone =
      command
          .add_option(
              "--phone", options->network.phone,
              "A phone with Live Link Face looks at the performer, too: into a take it is recorded as a "
              "truth, with --to it sends to HOST (port 11111 unless named). Its faults are the rig's "
              "[faults.phone], or else those of a usual phone")
          .optional_value("HOST[:PORT]");
  command
      .add_option(
          "--wait", options->network.wait_s,
          "Seconds that a receiver has to answer, or cameras have to be asked, before the performance "
          "begins without it")
      .needs(to)
      .number_between(0.0, 3600.0)
      .show_default();
  command
      .add_option("--key", options->key,
                  "A file with the key that the virtual boards are paired with, for a mien live that has it")
      .needs(to);
  command
      .add_flag("--loop", options->network.loop,
                "Play the motion again and again, until Ctrl-C; the calibration comes once, at the beginning")
      .needs(to);
  command
      .add_flag(
          "--ahead", options->ahead,
          "Render all pictures of the cameras first, into memory, then offer them at the rig's size and "
          "rate; else they are rendered as they are performed, 96 pixels wide and up to 30 a second")
      .needs(to);
  command.add_option(
      "--headset-failure", options->failure,
      "What befalls a headset's cameras, and when: NAME, or NAME@FROM-TO in seconds from the "
      "motion's start. NAME is hand, cup, mask or moustache before the mouth, poor_seat, smear, "
      "sun, dark, or covered (one lens)");
  const Option motion = command.add_option(
      "--motion", options->motion,
      "A Live Link Face CSV, or a take whose truth to perform; without it a script is played");
  command.add_option("--script", options->block, "What a virtual performer plays")
      .excludes(motion)
      .one_of({"mixed", "reading", "expressions", "acted", "range_of_motion", "free", "eating", "rapid"})
      .show_default();
  options->seconds_option =
      command
          .add_option("--seconds", options->seconds,
                      "Length of the script, of which every ten minutes are drawn anew. With --motion: the "
                      "motion is repeated, with a second from its end to its beginning, or cut, to last so "
                      "long. More than two hours are for IMUs alone, with --take")
          .number_between(1.0, virt::kLongestPerformanceS)
          .show_default();
  command
      .add_option("--voice", options->voice,
                  "Who speaks the script's lines: espeak (espeak-ng: its phonemes, timing and sound, in four "
                  "languages) or babble (the sounds of six languages, unheard). Default: espeak when reading")
      .excludes(motion)
      .one_of({"espeak", "babble"});
  command.add_option("--sound", options->sound,
                     "A WAV file to write what is heard to; it begins with the motion, after the prologue");
  command
      .add_option("--face", request.face,
                  "Whose skin: builtin, builtin:SEED (another person), an ICT-FaceKit folder, a .glb or .vrm")
      .show_default();
  command
      .add_option(
          "--unlike", request.unlike,
          "How unlike the face's own the wearer's skin turns under the sensors, drawn from the seed: 0 "
          "not at all, 1 as people may differ (30 %, 15 degrees)")
      .number_between(0.0, 3.0)
      .show_default();
  add_rig_option(command, options->rig);
  command
      .add_option("--devices", request.devices,
                  "device: real sensors' faults, as the rig states them; lab: skin rotations with 1 degree "
                  "of noise; or a "
                  "TOML file of faults")
      .show_default();
  add_seed_option(command, request.seed, "Everything that is drawn comes from it");
  command
      .add_option(
          "--prologue", options->prologue,
          "The calibration that the performance begins with: short (still, nod, shake), none, full (then "
          "expressions), guided (full, in the time of a mien calibrate that waits for the sensors) or gaze "
          "(short, then five points to look at, in that time too)")
      .one_of({"short", "none", "full", "guided", "gaze"})
      .show_default();
  command.add_option("--pace", options->pace, "fast: at once; real: as packets would arrive")
      .needs(take)
      .one_of({"fast", "real"})
      .show_default();
  command.add_flag("--force", request.replace, "Replace an existing take").needs(take);
  add_json_flag(command, options->json);
}

}  // namespace mien::app
