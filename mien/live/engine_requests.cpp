#include "mien/live/engine_state.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>

#include "mien/live/page_messages.h"
#include "mien/live/page_requests.h"
#include "mien/sensor/rig_part.h"
#include "mien/session/command.h"
#include "mien/session/json_fields.h"
#include "mien/shaping/merge.h"

// What pages ask of a session.
namespace mien::live {
namespace {

using nlohmann::json;
using session::dumped;
using session::text_field;

/// Half a frame: none of a take that is played is shown late by more.
constexpr auto kPlayStep = std::chrono::milliseconds(8);
/// The end of a recording waits for that of its video so long.
constexpr Duration kLongestEnd = VideoRecording::kLastChunk + std::chrono::seconds(1);

constexpr const char* kHeardWithoutConsent =
    "this session has heard sound already, which its takes hold, and the performer agreed to none";

constexpr const char* kDropped = "it was ended before it began";

/// Whether a microphone was ever received.
bool has_heard_sound(const sensor::Rig& rig, const session::Report& report) {
  const std::vector<std::uint16_t> microphones = sensor::sensors_of(rig, shaping::Merge::kListening);
  return std::ranges::any_of(microphones, [&report](std::uint16_t microphone) {
    return microphone < report.links.size() && report.links[microphone].health.age.has_value();
  });
}

}  // namespace

void Engine::State::wait_for_play() {
  play.expires_after(kPlayStep);
  play.async_wait([this](boost::system::error_code code) {
    if (code || !player.on()) return;
    if (const auto moment = player.next(now())) {
      sink::write_frame_json(*moment->frame, moment->index, moment->truth, frame_text);
      page->send_frame(frame_text);
    }
    wait_for_play();
  });
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
  const bool numbered = command.is_object() && command.contains("id") && command["id"].is_number_integer();
  const std::int64_t number = numbered ? command["id"].get<std::int64_t>() : 0;
  if (!command.is_object() || !command.contains("command") || !command["command"].is_string()) {
    page->send(client, reply_json(number, "not a command; docs/reference/page_protocol.md lists them"));
    return;
  }
  // Whatever was agreed to otherwise or no more: of video, it was the recording's own consent.
  if (command["command"] == "consent_over" || command["command"] == "consent") video.finish(now());
  if (session::is_session_command(command["command"].get<std::string>())) {
    if (!intake.command(client, number, text))
      page->send(client, reply_json(number, "the session is busy; try again"));
    return;
  }
  const Answered answered = [this, client, number](const Result<std::string>& done) {
    page->send(client, done ? reply_json(number, {}, *done) : reply_json(number, done.error().message()));
  };
  if (command["command"] == "record")
    answer_record(command, answered);
  else if (command["command"] == "dataset")
    answer_dataset(command, answered);
  else if (command["command"] == "learn_phone")
    answer_lesson(command, answered);
  else
    answered(execute(client, command));
}

Result<std::string> Engine::State::execute(std::uint64_t client, const json& command) {
  const std::string name = command["command"].get<std::string>();
  if (name == "sink") return execute_sink(command);
  if (name == "replay") return execute_replay(command);
  if (name == "listen") return execute_listen(command);
  if (name == "pair") return execute_pair();
  if (name == "microphone") {
    MIEN_TRY_ASSIGN(const bool on, switch_field(command, name));
    MIEN_TRY(feeds.microphone(client, on, *page));
    return std::string();
  }
  if (name == "video") return execute_video(client, command);
  if (name == "pictures") {
    MIEN_TRY_ASSIGN(const bool on, switch_field(command, name));
    MIEN_TRY_ASSIGN(const bool first, pictures.show(client, on));
    if (first) tell("pictures", "a page is shown what the cameras see");
    return std::string();
  }
  if (name == "save_rig") return save_views(settings.rig, session->rig(), loop.report().links);
  if (name == "takes") return dumped(list_takes(true));
  return fail(ErrorCode::unsupported, fmt::format("there is no command \"{}\"", name.substr(0, 40)), "page");
}

void Engine::State::answer_record(const json& command, const Answered& answered) {
  const Result<bool> on = switch_field(command, "record");
  if (!on) return answered(std::unexpected(on.error()));
  if (!*on) {
    dataset_dropped = true;
    end_recording();
    return answered(std::string());
  }
  const Result<std::filesystem::path> path = take_path(settings.takes, text_field(command, "name"));
  if (!path) return answered(std::unexpected(path.error()));
  start_recording(*path, settings.header, [answered, take = *path](const Result<void>& started) {
    answered(started ? Result<std::string>(dumped({{"take", take.string()}}))
                     : std::unexpected(started.error()));
  });
}

std::filesystem::path Engine::State::growing() const {
  const Recorder::State recorded = recorder.state();
  return recorded.on ? recorded.path : std::filesystem::path();
}

void Engine::State::answer_dataset(const json& command, const Answered& answered) {
  if (const auto begin = command.find("begin"); begin != command.end()) {
    Result<DatasetWish> wish = dataset_wish(*begin);
    if (!wish) return answered(std::unexpected(std::move(wish).error()));
    dataset_dropped = false;
    shelf.plan(*std::move(wish), growing(), [this, answered](Result<DatasetPlan> plan) {
      boost::asio::post(network, [this, answered, plan = std::move(plan)] {
        if (plan)
          begin_dataset(*plan, answered);
        else
          answered(std::unexpected(plan.error()));
      });
    });
  } else if (command.contains("list")) {
    shelf.list(growing(), [this, answered](Result<DatasetShelf::Contents> contents) {
      boost::asio::post(network, [answered, contents = std::move(contents)] {
        answered(contents ? Result<std::string>(dumped(dataset_contents_json(*contents)))
                          : std::unexpected(contents.error()));
      });
    });
  } else if (command.contains("end")) {
    dataset.end();
    dataset_dropped = true;
    answered(std::string());
  } else {
    answered(fail(ErrorCode::malformed, "a dataset is listed, begun or ended", "dataset",
                  "docs/reference/page_protocol.md lists the commands"));
  }
}

void Engine::State::begin_dataset(const DatasetPlan& plan, const Answered& answered) {
  const auto refuse = [&answered](ErrorCode code, std::string what, std::string where, std::string fix) {
    answered(fail(code, std::move(what), std::move(where), std::move(fix)));
  };
  // While its takes were read.
  if (dataset_dropped) return refuse(ErrorCode::cancelled, kDropped, "dataset", "begin it again");
  if (!plan.wish.consent.sound && has_heard_sound(session->rig(), loop.report()))
    return refuse(ErrorCode::bad_usage, kHeardWithoutConsent, "dataset",
                  "start it with --no-audio, or ask the performer");
  std::error_code code;
  std::filesystem::create_directory(plan.take.parent_path(), code);
  if (code)
    return refuse(ErrorCode::io, "the dataset's folder cannot be made: " + code.message(),
                  plan.take.parent_path().string(),
                  "start the session with --takes FOLDER where there is room");
  take::Header header = settings.header;
  header.performer = plan.wish.consent.performer;
  header.script = plan.wish.script;
  start_recording(plan.take, std::move(header), [this, answered, plan](const Result<void>& started) {
    Result<std::string> done = started ? go_through(plan) : std::unexpected(started.error());
    if (started && !done) recorder.end(notes());
    answered(done);
  });
}

Result<std::string> Engine::State::go_through(const DatasetPlan& plan) {
  // While its file was made.
  if (dataset_dropped) return fail(ErrorCode::cancelled, kDropped, "dataset", "begin it again");
  const session::Report report = loop.report();
  if (!plan.wish.consent.sound && has_heard_sound(session->rig(), report))
    return fail(ErrorCode::bad_usage, kHeardWithoutConsent, plan.take.string(),
                "delete that take; start the session with --no-audio, or ask the performer");
  const bool hears = report.hearing && report.hearing->on;
  if (!tell_session(dataset.begin(plan, report.prompts.state, hears))) {
    dataset.end();  // What the session was told of it is taken back.
    return fail(ErrorCode::out_of_range, "the session is too busy to take the script", "dataset",
                "try again");
  }
  if (plan.wish.consent.video) video.allow(plan.take);
  return dumped({{"take", plan.take.string()}, {"lines", plan.prompts.size()}, {"done", plan.done}});
}

bool Engine::State::tell_session(const std::vector<session::Command>& commands) {
  return std::ranges::all_of(commands, [this](const session::Command& one) {
    return intake.command(kNobody, 0, session::write_command(one));
  });
}

void Engine::State::own_command_failed(const std::string& why) {
  lesson.refuse(why);
  tell("command_failed", "the session refused: " + why);
}

void Engine::State::follow_recordings(const Recorder::State& recording, const session::Report& report) {
  const std::string& prompts = report.prompts.state;
  const DatasetRecording::Next next = dataset.look(recording, prompts);
  const PhoneLesson::Next after = lesson.look(recording, prompts);
  if (dataset.state() && dataset.state()->over) video.finish(now());
  if (next.end_recording || after.end_recording) end_recording();
  // A disk that is slow with the video, or fails with the take, keeps nobody from the next recording.
  if (ending &&
      ((!recording.on && !recording.beginning) || video.is_over() || now() - *ending >= kLongestEnd)) {
    ending.reset();
    recorder.end(notes());
  }
  // What is heard again after the recording is not heard before its take is closed.
  held.insert(held.end(), next.commands.begin(), next.commands.end());
  std::vector<session::Command> commands;
  if (!ending) commands = std::exchange(held, {});
  using session::Prompting;
  if (after.stop_prompts) commands.emplace_back(Prompting{Prompting::Do::stop});
  if (!tell_session(commands)) tell("command_failed", "the session is too busy to end what is asked for");
  const auto& versions = report.calibration.versions;
  if (lesson.in_force(!versions.empty() && versions.back().origin == "phone"
                          ? report.calibration.in_force == versions.back().id
                          : false))
    tell("learnt", lesson.state().sentence);
}

void Engine::State::end_recording() {
  video.finish(now());
  if (video.is_over())
    recorder.end(notes());
  else
    ending = now();
}

void Engine::State::on_bytes(std::uint64_t client, std::span<const std::byte> bytes) {
  if (is_video_message(bytes))
    video.take(client, bytes, now());
  else
    feeds.take(client, bytes);
}

void Engine::State::look_at_video() {
  const VideoRecording::News news = video.look(now(), page && page->has(video.client()));
  if (!news.events.empty()) {
    const DeviceTime newest = loop.report().time;
    for (const VideoRecording::News::Event& event : news.events)
      recorder.note({event.kind, newest, newest, event.json});
  }
  for (const Sentence& sentence : news.sentences) tell(sentence.kind, sentence.text);
  for (const VideoRecording::News::Stop& stop_it : news.stops)
    if (page) page->send(stop_it.client, video_json(stop_it.why, stop_it.again));
}

Result<std::string> Engine::State::execute_video(std::uint64_t client, const json& command) {
  MIEN_TRY_ASSIGN(const bool on, switch_field(command, "video"));
  look_at_video();  // Who is gone keeps nobody from it.
  MIEN_TRY(video.camera(client, on, now()));
  // Twice the longest chunk: who sends too long a one is told, and not dropped.
  if (on) page->allow_messages(client, 2 * kMaxVideoChunk);
  return std::string();
}

void Engine::State::answer_lesson(const json& command, const Answered& answered) {
  const std::string what = text_field(command, "do");
  if (what == "cancel") {
    lesson.cancel();
    answered(std::string());
  } else if (what != "begin") {
    answered(fail(ErrorCode::malformed, "a phone's lesson is begun or cancelled", "learn_phone",
                  "docs/reference/page_protocol.md lists the commands"));
  } else if (const Result<void> begins = begin_lesson(answered); !begins) {
    answered(std::unexpected(begins.error()));
  }
}

/// What it returns is why it does not begin; else `answered` is told when the recording has.
Result<void> Engine::State::begin_lesson(const Answered& answered) {
  if (!lesson.can() || sensor::truths_of(session->rig()).empty())
    return fail(ErrorCode::unsupported, "no phone is recorded as a truth here", "learn_phone",
                "start the session with --listen livelink://0.0.0.0 --phone truth");
  if (const Recorder::State recorded = recorder.state(); recorded.on || recorded.beginning)
    return fail(ErrorCode::bad_usage, "a recording runs already", "learn_phone", "end it first");
  const session::Report report = loop.report();
  const auto& versions = report.calibration.versions;
  if (versions.empty() || report.calibration.in_force != versions.back().id ||
      report.calibration.state == "running")
    return fail(ErrorCode::bad_usage, "the newest calibration is not in force", "learn_phone",
                "calibrate first; what is learnt belongs to it");
  MIEN_TRY_ASSIGN(const std::filesystem::path unnamed, take_path(settings.takes, {}));
  const std::filesystem::path path = unused(settings.takes / ("phone_" + unnamed.filename().string()));
  MIEN_TRY_ASSIGN(std::vector<session::Command> asked,
                  lesson.begin(path, report.prompts.state, report.calibration.in_force));
  start_recording(
      path, settings.header, [this, answered, path, asked = std::move(asked)](const Result<void>& started) {
        if (!started) {
          lesson.fail_with(started.error().message());
          return answered(std::unexpected(started.error()));
        }
        const auto give_up = [&](Error why) {
          lesson.fail_with(why.what);
          recorder.end(notes());
          answered(std::unexpected(std::move(why)));
        };
        if (lesson.is_cancelled())
          return give_up({ErrorCode::cancelled, "cancelled; nothing was learnt", "learn_phone", ""});
        if (!tell_session(asked))
          return give_up({ErrorCode::out_of_range, "the session is too busy to take the script",
                          "learn_phone", "try again"});
        lesson.recording_begun();
        answered(dumped({{"take", path.string()}}));
      });
  return {};
}

void Engine::State::finish_lesson(const Result<TaughtByPhone>& taught) {
  const std::vector<session::Command> commands = lesson.finish(taught, loop.report().calibration.in_force);
  if (!tell_session(commands)) lesson.fail_with("the session is too busy; learn again");
  if (lesson.state().stage == PhoneLesson::Stage::failed) tell("learning_failed", lesson.state().sentence);
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
  return dumped({{"file", made.file},
                 {"firmware", made.firmware},
                 {"command", made.command},
                 {"in_force", settings.sealed}});
}

Result<std::string> Engine::State::execute_replay(const json& command) {
  if (const std::string name = text_field(command, "take"); !name.empty()) {
    if (!settings.make_session) return fail(ErrorCode::unsupported, "this session replays nothing", "replay");
    std::filesystem::path folder = settings.takes;
    if (const std::string dataset_name = text_field(command, "dataset"); !dataset_name.empty()) {
      MIEN_TRY(check_file_name(dataset_name, "dataset"));
      folder /= dataset_name;
    }
    MIEN_TRY_ASSIGN(const std::filesystem::path path, take_path(folder, name));
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
  page->send(dumped(message));
}

}  // namespace mien::live
