#include "mien/live/engine.h"

#include "mien/live/engine_state.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "mien/live/link_news.h"
#include "mien/live/network_interfaces.h"
#include "mien/live/page_messages.h"
#include "mien/live/unheard.h"
#include "mien/modalities/modalities.h"
#include "mien/session/command.h"

namespace mien::live {
namespace {

namespace asio = boost::asio;

constexpr auto kBeat = std::chrono::milliseconds(100);
/// Status messages: five a second.
constexpr int kBeatsPerStatus = 2;
/// A session that is over goes on for a second, so that the page hears of it.
constexpr int kLastBeats = 10;
/// A device that is on has been heard by then.
constexpr auto kSilence = std::chrono::seconds(10);

/// A session that calibrates itself has done so by then: half a minute.
constexpr std::uint64_t kUncalibratedFrames = 30 * 60;
constexpr int kBeatsPerPiece = 10;
constexpr std::size_t kMaxSinks = 16;

}  // namespace

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
        if (said->to == kNobody && !text.empty()) own_command_failed(std::string(text));
        if (page) page->send(said->to, reply_json(said->number, text));
        break;
      case OutgoingMessage::Kind::event: {
        const std::size_t space = text.find(' ');
        const std::string_view kind = text.substr(0, space);
        const std::string words(space == std::string_view::npos ? std::string_view()
                                                                : text.substr(space + 1));
        // Of what was played to its end that is told, and no loss.
        if (kind == "sensor_lost" && std::ranges::any_of(feeds.over(), [&](const std::string& sensor) {
              return words == LinkNews::loss_text(sensor);
            }))
          break;
        tell(std::string(kind), words);
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
    piece = (piece + 1) % kLatencyPieces;
    pieces[piece].clear();
    look_at_interfaces();
  }
  for (const Sentence& news : recording_news.tell(recorder.state(), recorder.take_ended()))
    tell(news.kind, news.text);
  for (const Sentence& news : line_news.tell(now(), intake.lines())) tell(news.kind, news.text);
  intake.fast_senders(fast_senders);
  for (const Sentence& news : fast_sender_news.tell(now(), fast_senders)) tell(news.kind, news.text);
  for (Outlet& outlet : outlets) {
    const sink::Status state = outlet.sink->status();
    // A receiver that is there and not there by turns is told of once.
    if (!outlet.on || state.note.empty() || state.note == outlet.told) continue;
    outlet.told = state.note;
    tell("sink", state.address + ": " + state.note);
  }
  const session::Report report = loop.report();
  if (!told_silent && std::chrono::steady_clock::now() - begun > kSilence) {
    told_silent = true;
    if (report.frames == 0) {
      const Intake::Counts counts = intake.counts();
      tell("nothing_heard",
           unheard_text(why_unheard({counts.received, counts.elsewhere, settings.sealed}, report), report));
    }
  }
  if (!told_uncalibrated) {
    told_uncalibrated = report.frames > kUncalibratedFrames;
    if (told_uncalibrated && report.calibration.state == "watching")
      tell("not_calibrated",
           "nothing is calibrated yet, so the face stays neutral: " + report.calibration.prompt);
  }
  if (const auto silence = unheard_microphone.tell(now(), session->rig(), report))
    tell("microphone_missing", *silence);
  look_at_video();
  follow_recordings(recorder.state(), report);
  feeds.look(report.hearing ? std::optional(report.hearing->on) : std::nullopt, page.get());
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
  std::vector<CameraStatus> all = feeds.cameras();
  for (SerialPort::Status& line : intake.lines())
    if (line.camera) all.push_back(*std::move(line.camera));
  return all;
}

Status Engine::State::status() const {
  Status out;
  out.report = loop.report();
  out.missed = loop.missed();
  out.hearing = feeds.state();
  out.pictures = pictures.state();
  for (const Latencies& part : pieces) out.latency += part;
  for (const Outlet& outlet : outlets) out.sinks.push_back({outlet.id, outlet.on, outlet.sink->status()});
  out.lines = intake.lines();
  out.cameras = cameras();
  out.network = network_state();
  out.recording = recorder.state();
  out.dataset = dataset.state();
  out.video = video.state();
  out.lesson = lesson.state();
  if (out.recording.on) out.recording_ends_s = settings.seconds;
  std::error_code ignored;
  const auto bytes = std::filesystem::file_size(out.recording.path, ignored);
  if (!ignored) out.recording_megabytes = static_cast<double>(bytes) / 1e6;
  if (player.on()) out.replay = player.view(now());
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

void Engine::State::start_recording(const std::filesystem::path& path, take::Header header,
                                    std::function<void(const Result<void>&)> then) {
  recorder.start(path, std::move(header), false, [this, path, then = std::move(then)](Result<void> started) {
    boost::asio::post(network, [this, path, then, started = std::move(started)] {
      // Nothing that a page asked for ends the session.
      try {
        if (started) has_begun(path);
        then(started);
      } catch (const std::exception& error) {
        own_command_failed(error.what());
      }
    });
  });
}

void Engine::State::has_begun(const std::filesystem::path& path) {
  tell("recording", "recording " + path.string());
}

std::vector<take::Note> Engine::State::notes() const {
  return {{"live.model", settings.model}, {"live.kernels", modalities::live_kernels(session->rig())}};
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
  MIEN_TRY(state->feeds.open(std::move(state->settings.feeds), state->settings.hear, state->settings.shut,
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
      state->on_bytes(client, sent);
    };
    MIEN_TRY_ASSIGN(state->page,
                    PageServer::open(state->network, *state->settings.page, hello, message, bytes));
  }
  if (state->settings.record) {
    MIEN_TRY(state->recorder.start(*state->settings.record, state->settings.header, state->settings.replace));
    state->has_begun(*state->settings.record);
  }
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
  s.feeds.begin([&s](std::string kind, std::string said) {
    asio::post(s.network, [&s, kind = std::move(kind), said = std::move(said)] { s.tell(kind, said); });
  });
  s.network.run();
  s.feeds.end();
  s.video.close(s.now());
  s.look_at_video();
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
  std::vector<take::Note> notes = s.notes();
  notes.push_back({"live.hash", out.hash});
  notes.push_back({"live.frames", std::to_string(out.frames)});
  out.log = s.recorder.state().log;
  s.recorder.end(std::move(notes));
  if (const auto finished = s.recorder.wait(); !finished) out.recording_error = finished.error().message();
  if (const std::filesystem::path take = s.recorder.state().path; !take.empty()) out.take = take;
  return out;
}

}  // namespace mien::live
