#include <utility>  // Before Asio 1.74, which forgets it.

#include "mien/live/engine.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <iterator>
#include <nlohmann/json.hpp>

#include "mien/live/intake.h"
#include "mien/live/line_news.h"
#include "mien/live/network_interfaces.h"
#include "mien/live/page_messages.h"
#include "mien/live/page_requests.h"
#include "mien/live/recorder.h"
#include "mien/live/recording_news.h"
#include "mien/live/take_listing.h"
#include "mien/live/tracker_loop.h"
#include "mien/live/unheard.h"
#include "mien/modalities/modalities.h"
#include "mien/session/command.h"

namespace mien::live {
namespace {

namespace asio = boost::asio;
using nlohmann::json;

constexpr auto kFrame = std::chrono::milliseconds(8);  // Half a frame: none is shown late by more.
constexpr auto kBeat = std::chrono::milliseconds(100);
/// Status messages: five a second.
constexpr int kBeatsPerStatus = 2;
/// A session that is over goes on for a second, so that the page hears of it.
constexpr int kLastBeats = 10;
/// A device that is on has been heard by then.
constexpr auto kSilence = std::chrono::seconds(10);

/// A session that calibrates itself has done so by then: half a minute.
constexpr std::uint64_t kUncalibratedFrames = 30 * 60;
/// The rolling latency is that of this many beats: ten seconds, in pieces of one.
constexpr std::size_t kPieces = 10;
constexpr int kBeatsPerPiece = 10;
constexpr std::size_t kMaxSinks = 16;

/// Names of files need not be UTF-8.
std::string text(const json& object) {
  return object.dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace

struct Engine::State {
  State(EngineSettings s, std::unique_ptr<session::Session> made)
      : settings(std::move(s)),
        session(std::move(made)),
        begun(std::chrono::steady_clock::now()),
        network(1),
        intake(network, [this] { return now(); }),
        recorder(settings.takes, settings.log_limit),
        loop(*session, intake, recorder, [this] { return now(); }),
        player(settings.make_session),
        listing(settings.takes, [this] { asio::post(network, [this] { send_takes(); }); }),
        wake(network),
        beat(network),
        play(network) {}

  [[nodiscard]] HostTime now() const {
    return HostTime(std::chrono::duration_cast<Duration>(std::chrono::steady_clock::now() - begun));
  }

  struct Outlet {
    std::int64_t id = 0;
    bool on = true;
    std::unique_ptr<sink::Sink> sink;
    std::string told;  // What is wrong with it, as it was said last.
  };

  Result<void> add_sink(const std::string& address);
  void wait_for_answers();
  void take_answers();
  void send_frame(const Answer& answer);
  void wait_for_beat();
  void on_beat();
  [[nodiscard]] bool recording_is_over() const;
  [[nodiscard]] std::vector<CameraStatus> cameras() const;
  [[nodiscard]] Status status() const;
  [[nodiscard]] NetworkState network_state() const;
  void look_at_interfaces();
  void on_message(std::uint64_t client, std::string_view text);
  void answer(std::uint64_t client, std::string_view text);
  Result<std::string> execute(std::uint64_t client, const json& command);
  Result<std::string> execute_record(const json& command);
  Result<std::string> execute_sink(const json& command);
  Result<std::string> execute_replay(const json& command);
  Result<std::string> execute_listen(const json& command);
  Result<std::string> execute_pair();
  [[nodiscard]] json list_takes(bool read_lengths);
  void send_takes();
  void wait_for_play();
  Result<void> start_recording(const std::filesystem::path& path, bool replace);
  [[nodiscard]] std::vector<take::Note> notes() const;
  void tell(const std::string& kind, const std::string& text);

  EngineSettings settings;
  std::unique_ptr<session::Session> session;
  std::chrono::steady_clock::time_point begun;
  asio::io_context network;
  Intake intake;
  Recorder recorder;
  TrackerLoop loop;
  Hearing hearing;  // Before what its feeds fill is gone they have ended.
  PagePictures pictures;
  Player player;
  TakeListing listing;
  asio::posix::stream_descriptor wake;
  asio::steady_timer beat;
  asio::steady_timer play;  // Runs while the page looks at a take.
  std::unique_ptr<PageServer> page;
  std::vector<std::string> listening;
  std::vector<std::string> open;             // Those on every interface, ...
  std::vector<NetworkInterface> interfaces;  // ... and by what they are reached, as of a second ago.
  std::vector<Outlet> outlets;
  LineNews line_news;
  std::int64_t next_sink = 1;

  Latencies latency;
  std::array<Latencies, kPieces> pieces;
  std::size_t piece = 0;
  int beats = 0;
  int beats_over = 0;  // Since the recording was over that the session is there for.
  std::uint64_t frames = 0;
  std::string frame_text;
  std::optional<std::filesystem::path> take;
  RecordingNews recording_news;
  bool told_silent = false;        // That nothing is heard; already told, ...
  bool told_uncalibrated = false;  // ... as this.
  std::atomic<std::size_t> watchers = 0;
  const std::atomic<bool>* stop = nullptr;
  EngineListener listener;
};

Result<void> Engine::State::add_sink(const std::string& address) {
  if (outlets.size() == kMaxSinks)
    return fail(ErrorCode::bad_usage, fmt::format("{} sinks are enough", kMaxSinks), address,
                "remove one first");
  MIEN_TRY_ASSIGN(std::unique_ptr<sink::Sink> opened, sink::open_sink(network, address));
  outlets.push_back({next_sink++, true, std::move(opened), {}});
  return {};
}

void Engine::State::wait_for_answers() {
  wake.async_wait(asio::posix::stream_descriptor::wait_read, [this](boost::system::error_code code) {
    if (code) return;
    loop.signal().take();
    take_answers();
    wait_for_answers();
  });
}

void Engine::State::take_answers() {
  while (const Answer* answer = loop.front()) {
    send_frame(*answer);
    loop.release();
  }
  while (const auto said = loop.front_said()) {
    const std::string_view text(reinterpret_cast<const char*>(said->bytes.data()), said->bytes.size());
    switch (said->kind) {
      case OutgoingMessage::Kind::datagram:
        intake.send(static_cast<sensor::Peer>(said->to), said->bytes);
        break;
      case OutgoingMessage::Kind::reply:
        if (page) page->send(said->to, reply_json(said->number, text));
        break;
      case OutgoingMessage::Kind::event: {
        const std::size_t space = text.find(' ');
        tell(std::string(text.substr(0, space)),
             space == std::string_view::npos ? std::string() : std::string(text.substr(space + 1)));
        break;
      }
    }
    loop.release_said();
  }
}

void Engine::State::send_frame(const Answer& answer) {
  for (const Outlet& outlet : outlets)
    if (outlet.on) outlet.sink->send(answer.frame, answer.tick.index);
  const Duration took = now() - answer.cause;
  latency.add(took);
  pieces[piece].add(took);
  ++frames;
  if (!page || page->clients() == 0 || player.on()) return;
  sink::write_frame_json(answer.frame, answer.tick.index, nullptr, frame_text);
  page->send_frame(frame_text);
}

void Engine::State::wait_for_play() {
  play.expires_after(kFrame);
  play.async_wait([this](boost::system::error_code code) {
    if (code || !player.on()) return;
    if (const auto moment = player.next(now())) {
      sink::write_frame_json(*moment->frame, moment->index, moment->truth, frame_text);
      page->send_frame(frame_text);
    }
    wait_for_play();
  });
}

void Engine::State::wait_for_beat() {
  beat.expires_after(kBeat);
  beat.async_wait([this](boost::system::error_code code) {
    if (code) return;
    on_beat();
    if (network.stopped()) return;
    wait_for_beat();
  });
}

void Engine::State::on_beat() {
  if (recording_is_over() && ++beats_over == 1)
    tell("recording_over", "the recording is over, and the session with it");
  if (*stop || (settings.seconds && to_seconds(now().time_since_epoch()) >= *settings.seconds) ||
      beats_over > kLastBeats) {
    network.stop();
    return;
  }
  ++beats;
  watchers = page ? page->clients() : 0;
  if (beats % kBeatsPerPiece == 0) {
    piece = (piece + 1) % kPieces;
    pieces[piece].clear();
    look_at_interfaces();
  }
  for (const RecordingNews::Sentence& news : recording_news.tell(recorder.state()))
    tell(news.kind, news.text);
  for (const CameraNews::Sentence& news : line_news.tell(now(), intake.lines())) tell(news.kind, news.text);
  for (Outlet& outlet : outlets) {
    const sink::Status state = outlet.sink->status();
    // A receiver that is there and not there by turns is told of once.
    if (!outlet.on || state.note.empty() || state.note == outlet.told) continue;
    outlet.told = state.note;
    tell("sink", state.address + ": " + state.note);
  }
  if (!told_silent && std::chrono::steady_clock::now() - begun > kSilence) {
    told_silent = true;
    if (const session::Report report = loop.report(); report.frames == 0) {
      const Intake::Counts counts = intake.counts();
      tell("nothing_heard",
           unheard_text(why_unheard({counts.received, counts.elsewhere, settings.sealed}, report)));
    }
  }
  if (!told_uncalibrated) {
    const session::Report report = loop.report();
    told_uncalibrated = report.frames > kUncalibratedFrames;
    if (told_uncalibrated && report.calibration.state == "watching")
      tell("not_calibrated",
           "nothing is calibrated yet, so the face stays neutral: " + report.calibration.prompt);
  }
  const session::Report report = loop.report();
  hearing.look(report.hearing ? std::optional(report.hearing->on) : std::nullopt, page.get());
  // A take's face has no part in what cameras see now.
  if (page && pictures.watched(*page) && !player.on()) pictures.look(report.links, *page);
  const bool watched = page && page->clients() > 0;
  if (beats % kBeatsPerStatus != 0 || (!watched && !listener.seen)) return;
  const Status now_is = status();
  if (watched) page->send(status_json(now_is, session->rig()));
  if (listener.seen) listener.seen(now_is);
}

bool Engine::State::recording_is_over() const {
  if (!settings.ends_with_recording) return false;
  return !recorder.state().on || (!settings.prompts.empty() && loop.report().prompts.state == "over");
}

std::vector<CameraStatus> Engine::State::cameras() const {
  std::vector<CameraStatus> all = hearing.cameras();
  for (SerialPort::Status& line : intake.lines())
    if (line.camera) all.push_back(*std::move(line.camera));
  return all;
}

Status Engine::State::status() const {
  Status out;
  out.report = loop.report();
  out.missed = loop.missed();
  out.hearing = hearing.state();
  out.pictures = pictures.state();
  for (const Latencies& part : pieces) out.latency += part;
  for (const Outlet& outlet : outlets) out.sinks.push_back({outlet.id, outlet.on, outlet.sink->status()});
  out.lines = intake.lines();
  out.cameras = cameras();
  out.network = network_state();
  out.recording = recorder.state();
  if (out.recording.on) out.recording_ends_s = settings.seconds;
  std::error_code ignored;
  const auto bytes = std::filesystem::file_size(out.recording.path, ignored);
  if (!ignored) out.recording_megabytes = static_cast<double>(bytes) / 1e6;
  if (player.on()) {
    const Player::View view = player.view(now());
    out.replay =
        ReplayState{view.take, view.time_s, view.duration_s, view.paused, view.has_truth, view.error};
  }
  return out;
}

NetworkState Engine::State::network_state() const {
  return {.open = open,
          .interfaces = interfaces,
          .only = intake.entrance(),
          .elsewhere = intake.counts().elsewhere,
          .sealed = settings.sealed,
          .unsealed = settings.unsealed};
}

void Engine::State::look_at_interfaces() {
  if (open.empty()) return;
  intake.look_up_entrance();
  interfaces.clear();
  const std::vector<NetworkInterface> all = network_interfaces();
  for (const std::string& port : open)
    for (NetworkInterface& one : reached_by(port, all))
      if (std::ranges::find(interfaces, one) == interfaces.end()) interfaces.push_back(std::move(one));
}

void Engine::State::tell(const std::string& kind, const std::string& text) {
  if (listener.told) listener.told(text);
  if (page) page->send(event_json(kind, text));
}

Result<void> Engine::State::start_recording(const std::filesystem::path& path, bool replace) {
  MIEN_TRY(recorder.start(path, settings.header, replace));
  take = path;
  recording_news.begin();
  tell("recording", "recording " + path.string());
  return {};
}

std::vector<take::Note> Engine::State::notes() const {
  return {{"live.model", settings.model}, {"live.kernels", modalities::live_kernels(session->rig())}};
}

void Engine::State::on_message(std::uint64_t client, std::string_view text) {
  try {
    answer(client, text);
  } catch (const std::exception& error) {
    page->send(client, reply_json(0, error.what()));  // Nothing that a page says ends the session.
  }
}

void Engine::State::answer(std::uint64_t client, std::string_view text) {
  const json command = json::parse(text, nullptr, false);
  if (!command.is_object() || !command.contains("command") || !command["command"].is_string()) {
    page->send(client, reply_json(0, "not a command; docs/reference/page_protocol.md lists them"));
    return;
  }
  const std::int64_t number =
      command.contains("id") && command["id"].is_number_integer() ? command["id"].get<std::int64_t>() : 0;
  if (session::is_session_command(command["command"].get<std::string>())) {
    if (!intake.command(client, number, text))
      page->send(client, reply_json(number, "the session is busy; try again"));
    return;
  }
  const Result<std::string> done = execute(client, command);
  page->send(client, done ? reply_json(number, {}, *done) : reply_json(number, done.error().message()));
}

Result<std::string> Engine::State::execute(std::uint64_t client, const json& command) {
  const std::string name = command["command"].get<std::string>();
  if (name == "record") return execute_record(command);
  if (name == "sink") return execute_sink(command);
  if (name == "replay") return execute_replay(command);
  if (name == "listen") return execute_listen(command);
  if (name == "pair") return execute_pair();
  if (name == "microphone") {
    MIEN_TRY_ASSIGN(const bool on, switch_field(command, name));
    MIEN_TRY(hearing.microphone(client, on, *page));
    return std::string();
  }
  if (name == "pictures") {
    MIEN_TRY_ASSIGN(const bool on, switch_field(command, name));
    MIEN_TRY_ASSIGN(const bool first, pictures.show(client, on));
    if (first) tell("pictures", "a page is shown what the cameras see");
    return std::string();
  }
  if (name == "save_rig") return save_views(settings.rig, session->rig(), loop.report().links);
  if (name == "takes") return text(list_takes(true));
  return fail(ErrorCode::unsupported, fmt::format("there is no command \"{}\"", name.substr(0, 40)), "page");
}

Result<std::string> Engine::State::execute_record(const json& command) {
  MIEN_TRY_ASSIGN(const bool on, switch_field(command, "record"));
  if (!on) {
    recorder.end(notes());
    return std::string();
  }
  MIEN_TRY_ASSIGN(const std::filesystem::path path, take_path(settings.takes, text_field(command, "name")));
  MIEN_TRY(start_recording(path, false));
  return text(json({{"take", path.string()}}));
}

Result<std::string> Engine::State::execute_sink(const json& command) {
  if (const std::string address = text_field(command, "add"); !address.empty()) {
    MIEN_TRY(check_page_sink(address));
    MIEN_TRY(add_sink(address));
    return std::string();
  }
  const auto number = command.find("sink");
  const auto outlet = std::ranges::find_if(outlets, [&](const Outlet& o) {
    return number != command.end() && number->is_number_integer() && o.id == number->get<std::int64_t>();
  });
  if (outlet == outlets.end())
    return fail(ErrorCode::not_found, "there is no such sink", "sink", "name one of the status' list");
  if (command.contains("remove"))
    outlets.erase(outlet);
  else if (command.contains("on") && command["on"].is_boolean())
    outlet->on = command["on"].get<bool>();
  return std::string();
}

Result<std::string> Engine::State::execute_listen(const json& command) {
  const auto only = command.find("only");
  if (only == command.end() || !only->is_string())
    return fail(ErrorCode::malformed, "\"only\" is missing", "listen");
  MIEN_TRY(intake.listen_only(only->get<std::string>()));
  tell("listening", intake.entrance().empty()
                        ? "what comes in on any interface is received again"
                        : fmt::format("only what comes in at {} is received", intake.entrance()));
  return std::string();
}

Result<std::string> Engine::State::execute_pair() {
  if (!settings.pair) return fail(ErrorCode::unsupported, "this session pairs nothing", "pair");
  MIEN_TRY_ASSIGN(const Pairing made, settings.pair());
  return text(json({{"file", made.file},
                    {"firmware", made.firmware},
                    {"command", made.command},
                    {"in_force", settings.sealed}}));
}

Result<std::string> Engine::State::execute_replay(const json& command) {
  if (const std::string name = text_field(command, "take"); !name.empty()) {
    if (!settings.make_session) return fail(ErrorCode::unsupported, "this session replays nothing", "replay");
    MIEN_TRY_ASSIGN(const std::filesystem::path path, take_path(settings.takes, name));
    const bool was_on = player.on();
    player.load(path);
    if (!was_on) wait_for_play();
    return std::string();
  }
  if (!player.on())
    return fail(ErrorCode::bad_usage, "no take is being replayed", "replay", "choose one first");
  if (command.contains("stop")) player.stop();
  if (command.contains("paused") && command["paused"].is_boolean())
    player.pause(command["paused"].get<bool>(), now());
  if (command.contains("seek") && command["seek"].is_number())
    player.seek(command["seek"].get<double>(), now());
  return std::string();
}

json Engine::State::list_takes(bool read_lengths) {
  std::optional<TakeListing::Growing> growing;
  if (const Recorder::State recorded = recorder.state(); recorded.on)
    growing = {recorded.path, recorded.seconds};
  return takes_json(listing.list(growing, read_lengths));
}

void Engine::State::send_takes() {
  json message = list_takes(false);
  message["type"] = "takes";
  page->send(text(message));
}

Engine::Engine(std::unique_ptr<State> state) : state_(std::move(state)) {}

Engine::~Engine() {
  state_->loop.stop();
}

Result<std::unique_ptr<Engine>> Engine::open(EngineSettings settings,
                                             std::unique_ptr<session::Session> session) {
  auto made = std::make_unique<State>(std::move(settings), std::move(session));
  State* state = made.get();
  for (const std::string& address : state->settings.listen) {
    std::optional<LineCamera> camera;
    if (auto found = state->settings.line_cameras.extract(address)) camera = std::move(found.mapped());
    MIEN_TRY_ASSIGN(state->listening.emplace_back(), state->intake.listen(address, std::move(camera)));
  }
  std::ranges::copy_if(state->listening, std::back_inserter(state->open), is_on_every_interface);
  state->pictures.open(state->settings.feeds);
  MIEN_TRY(state->hearing.open(std::move(state->settings.feeds), state->settings.hear, state->settings.shut,
                               state->intake));
  state->look_at_interfaces();
  for (const std::string& address : state->settings.out) MIEN_TRY(state->add_sink(address));
  if (state->settings.page) {
    const auto hello = [state] {
      return sink::hello_json(hello_for(state->session->rig(), state->settings.header.software,
                                        state->settings.model, state->listening, false));
    };
    const auto message = [state](std::uint64_t client, std::string_view text) {
      state->on_message(client, text);
    };
    const auto bytes = [state](std::uint64_t client, std::span<const std::byte> sent) {
      state->hearing.take(client, sent);
    };
    MIEN_TRY_ASSIGN(state->page,
                    PageServer::open(state->network, *state->settings.page, hello, message, bytes));
  }
  if (state->settings.record)
    MIEN_TRY(state->start_recording(*state->settings.record, state->settings.replace));
  return std::unique_ptr<Engine>(new Engine(std::move(made)));
}

const std::vector<std::string>& Engine::listening() const {
  return state_->listening;
}

NetworkState Engine::network() const {
  return state_->network_state();
}

std::string Engine::page() const {
  return state_->page ? state_->page->address() : std::string();
}

std::size_t Engine::watchers() const {
  return state_->watchers;
}

Result<EngineSummary> Engine::run(const std::atomic<bool>& stop, const EngineListener& listener) {
  State& s = *state_;
  s.stop = &stop;
  s.listener = listener;
  if (s.settings.shut) s.session->take_no_sound();
  for (const session::Command& command : s.settings.commands)
    MIEN_TRY(s.loop.execute(session::write_command(command)));
  for (const session::Prompt& prompt : s.settings.prompts)
    MIEN_TRY(s.loop.execute(session::write_command(session::AddPrompt{prompt})));
  s.begun = std::chrono::steady_clock::now();
  s.wake.assign(s.loop.signal().descriptor());
  s.wait_for_answers();
  s.wait_for_beat();
  s.loop.start();
  s.hearing.begin([&s](std::string kind, std::string said) {
    asio::post(s.network, [&s, kind = std::move(kind), said = std::move(said)] { s.tell(kind, said); });
  });
  s.network.run();
  s.hearing.end();
  s.loop.stop();
  s.take_answers();
  s.wake.release();

  EngineSummary out;
  out.kernels = modalities::live_kernels(s.session->rig());
  out.frames = s.session->frames();
  out.missed = s.loop.missed();
  out.hash = s.session->hash();
  out.latency = s.latency;
  const Intake::Counts counts = s.intake.counts();
  out.datagrams = counts.received;
  out.listening = s.listening;
  out.network = s.network_state();
  out.dropped = counts.too_fast + counts.too_long + counts.elsewhere + counts.too_many +
                counts.kernel_dropped + counts.overrun + counts.payload_overrun;
  out.lines = s.intake.lines();
  out.cameras = s.cameras();
  for (const SerialPort::Status& line : out.lines) out.dropped += line.overlong;
  s.intake.close();
  s.session->report(s.now(), out.report);
  out.evicted = counts.evicted;
  out.malformed = out.report.malformed;
  for (const State::Outlet& outlet : s.outlets) out.sinks.push_back(outlet.sink->status());
  out.take = s.take;
  std::vector<take::Note> notes = s.notes();
  notes.push_back({"live.hash", out.hash});
  notes.push_back({"live.frames", std::to_string(out.frames)});
  out.log = s.recorder.state().log;
  s.recorder.end(std::move(notes));
  if (const auto finished = s.recorder.wait(); !finished) out.recording_error = finished.error().message();
  return out;
}

}  // namespace mien::live
