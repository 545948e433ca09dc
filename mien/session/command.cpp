#include "mien/session/command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <optional>

#include "mien/core/excerpt.h"
#include "mien/model/correction_json.h"
#include "mien/session/json_fields.h"
#include "mien/take/layout.h"

namespace mien::session {
namespace {

using nlohmann::json;

const char* const kCommand = "command";
/// No command is deeper; what is would be copied level by level.
constexpr int kMaxDepth = 8;

Result<std::string> text_of(const json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_string())
    return fail(ErrorCode::malformed, fmt::format("\"{}\" is missing or no text", key), kCommand,
                "docs/reference/page_protocol.md lists the fields");
  return found->get<std::string>();
}

/// The words of `Prompting::Do`, in its order.
constexpr std::array<std::string_view, 9> kPromptingWords = {"skip", "pause", "resume", "stop", "begin",
                                                             "next", "again", "voice",  "key"};

/// A text that may be left out.
Result<std::string> text_or_none(const json& object, const char* key) {
  if (!object.contains(key)) return std::string();
  return text_of(object, key);
}

/// A flag that may be left out.
Result<std::optional<bool>> flag_or_none(const json& object, const char* key, std::string fix = {}) {
  const auto found = object.find(key);
  if (found == object.end()) return std::nullopt;
  if (found->is_boolean()) return found->get<bool>();
  return fail(ErrorCode::malformed, fmt::format("\"{}\" is neither true nor false", key), kCommand,
              std::move(fix));
}

Result<GiveConsent> consent_in(const json& object) {
  GiveConsent given;
  MIEN_TRY_ASSIGN(given.consent.performer, text_of(object, "performer"));
  MIEN_TRY_ASSIGN(given.consent.recorded_by, text_of(object, "recorded_by"));
  MIEN_TRY_ASSIGN(given.consent.purpose, text_of(object, "purpose"));
  const auto sound = object.find("sound");
  if (sound == object.end() || !sound->is_boolean())
    return fail(ErrorCode::malformed, "\"sound\" is missing", kCommand,
                "true where the voice is recorded too");
  given.consent.sound = sound->get<bool>();
  // Older logs say nothing of it.
  MIEN_TRY_ASSIGN(const auto video,
                  flag_or_none(object, "video", "true where the face is recorded on video too"));
  given.consent.video = video.value_or(false);
  MIEN_TRY(check_consent(given.consent, kCommand));
  return given;
}

Result<Prompt> prompt_of(const json& object) {
  Prompt prompt;
  MIEN_TRY_ASSIGN(prompt.name, text_of(object, "name"));
  MIEN_TRY_ASSIGN(prompt.say, text_or_none(object, "say"));
  MIEN_TRY_ASSIGN(prompt.text, text_or_none(object, "text"));
  MIEN_TRY_ASSIGN(prompt.block, text_or_none(object, "block"));
  MIEN_TRY_ASSIGN(prompt.emotion, text_or_none(object, "emotion"));
  MIEN_TRY_ASSIGN(prompt.language, text_or_none(object, "language"));
  MIEN_TRY_ASSIGN(const auto own_pace, flag_or_none(object, "own_pace"));
  prompt.own_pace = own_pace.value_or(false);
  if (const auto seconds = object.find("seconds"); seconds != object.end()) {
    if (!seconds->is_number()) return fail(ErrorCode::malformed, "\"seconds\" is not a number", kCommand);
    prompt.seconds = seconds->get<double>();
  }
  if (const auto target = object.find("target"); target != object.end()) {
    if (!target->is_object()) return fail(ErrorCode::malformed, "\"target\" is not an object", kCommand);
    for (const auto& [name, weight] : target->items()) {
      const std::size_t shape = face::shape_index(name);
      if (shape == face::kShapeCount || !weight.is_number())
        return fail(ErrorCode::malformed, fmt::format("\"{}\" is no shape or has no number", excerpt(name)),
                    kCommand, "name ICT-FaceKit's shapes, each with a weight from 0 to 1");
      prompt.target[shape] = weight.get<float>();
    }
  }
  MIEN_TRY(check_prompt(prompt, kCommand));
  return prompt;
}

/// Numbers are taken as they are: whether they are a view is the session's to say.
Result<View> view_of(const json& object) {
  View view;
  MIEN_TRY_ASSIGN(view.sensor, text_of(object, "sensor"));
  if (const auto crop = object.find("crop"); crop != object.end()) {
    auto& edges = view.change.crop.emplace();
    if (!crop->is_array() || crop->size() != edges.size() ||
        !std::ranges::all_of(*crop, [](const json& edge) { return edge.is_number(); }))
      return fail(ErrorCode::malformed, "\"crop\" is not a list of four numbers", kCommand,
                  "give left, top, width and height as shares of the picture");
    for (std::size_t i = 0; i < edges.size(); ++i) edges[i] = (*crop)[i].get<double>();
  }
  if (const auto turn = object.find("turn_deg"); turn != object.end()) {
    if (!turn->is_number_integer())
      return fail(ErrorCode::malformed, "\"turn_deg\" is not a whole number", kCommand, "0, 90, 180 or 270");
    // What is no turn stays none, however large.
    view.change.turn_deg = static_cast<int>(std::clamp<std::int64_t>(turn->get<std::int64_t>(), -1, 361));
  }
  MIEN_TRY_ASSIGN(view.change.mirror, flag_or_none(object, "mirror"));
  if (view.change == sensor::PictureViewChange())
    return fail(ErrorCode::malformed, "\"view\" changes nothing", kCommand,
                "give \"crop\", \"turn_deg\" or \"mirror\"");
  return view;
}

/// The shaping settings that a command may change.
constexpr std::array<std::string_view, 10> kShapeKeys = {
    "smoothing", "resting", "blinks_per_min", "lids_follow_eyes", "gains", "limits", "constraints", "rules",
    "merge",     "off"};

Result<Shape> shape_of(const json& object) {
  json settings = json::object();
  for (const auto& [key, value] : object.items()) {
    if (key == "command" || key == "id") continue;
    if (std::ranges::find(kShapeKeys, key) == kShapeKeys.end())
      return fail(ErrorCode::malformed, fmt::format("\"shape\" has no \"{}\"", excerpt(key)), kCommand,
                  fmt::format("{}", fmt::join(kShapeKeys, ", ")));
    settings[key] = value;
  }
  return Shape{settings.dump()};
}

/// By the numbers of Calibrate::Kind.
constexpr std::array<std::string_view, 4> kCalibrationKinds = {"short", "full", "wearer", "gaze"};

json write_step(const Calibrate::GivenStep& given) {
  json out = {{"step", given.range             ? "range"
                       : given.look != nullptr ? "gaze"
                                               : std::string(step_name(given.step))},
              {"begin_ns", given.begin.time_since_epoch().count()},
              {"end_ns", given.end.time_since_epoch().count()}};
  if (given.look != nullptr) out["name"] = std::string(given.look->name);
  return out;
}

Result<Calibrate::GivenStep> step_of(const json& object) {
  if (!object.is_object()) return fail(ErrorCode::malformed, "a step is no object", kCommand);
  MIEN_TRY_ASSIGN(const std::string name, text_of(object, "step"));
  Calibrate::GivenStep given{.step = tracker::step_named(name), .range = name == "range"};
  if (name == "gaze") given.look = gaze_event_target(object.dump());
  if (given.step == tracker::Step::none && !given.range && given.look == nullptr)
    return fail(ErrorCode::malformed, fmt::format("there is no step \"{}\"", excerpt(name)), kCommand,
                "neutral, nod, shake, range, or gaze with the name of a target");
  const auto time = [&object](const char* key) -> std::optional<DeviceTime> {
    const auto found = object.find(key);
    if (found == object.end() || !found->is_number_integer()) return std::nullopt;
    if (found->is_number_unsigned() && found->get<std::uint64_t>() > std::uint64_t{take::kMaxTimeNs})
      return std::nullopt;
    const auto ns = found->get<std::int64_t>();
    return ns < -take::kMaxTimeNs ? std::nullopt : std::optional(DeviceTime(Duration(ns)));
  };
  const auto begin = time("begin_ns"), end = time("end_ns");
  if (!begin || !end || *end <= *begin)
    return fail(ErrorCode::malformed, fmt::format("the step {} has no begin_ns and later end_ns", name),
                kCommand, "give both as whole nanoseconds of the frames' clock, within 2^58");
  given.begin = *begin;
  given.end = *end;
  return given;
}

Result<Calibrate> calibrate_of(const json& object) {
  Calibrate command;
  if (const auto steps = object.find("steps"); steps != object.end()) {
    if (!steps->is_array() || steps->empty() || steps->size() > Calibrate::kMostSteps)
      return fail(ErrorCode::malformed,
                  fmt::format("\"steps\" is no list of 1 to {} steps", Calibrate::kMostSteps), kCommand);
    if (object.contains("kind"))
      return fail(ErrorCode::malformed, "a calibration has \"kind\" and \"steps\"", kCommand, "give one");
    for (const json& step : *steps) {
      MIEN_TRY_ASSIGN(const Calibrate::GivenStep given, step_of(step));
      if (!command.steps.empty() && given.begin < command.steps.back().begin)
        return fail(ErrorCode::malformed, "a step begins before the one before it", kCommand);
      command.steps.push_back(given);
    }
    return command;
  }
  MIEN_TRY_ASSIGN(const std::string kind, text_of(object, "kind"));
  const auto found = std::ranges::find(kCalibrationKinds, kind);
  if (found == kCalibrationKinds.end())
    return fail(ErrorCode::malformed, fmt::format("there is no calibration \"{}\"", excerpt(kind)), kCommand,
                "short, full, wearer or gaze");
  command.kind = static_cast<Calibrate::Kind>(found - kCalibrationKinds.begin());
  return command;
}

struct Writer {
  json operator()(const Calibrate& c) const {
    json out = {{"command", "calibrate"}};
    if (c.steps.empty()) out["kind"] = kCalibrationKinds.at(static_cast<std::size_t>(c.kind));
    for (const Calibrate::GivenStep& given : c.steps) out["steps"].push_back(write_step(given));
    return out;
  }
  json operator()(const CancelCalibration&) const { return {{"command", "cancel_calibration"}}; }
  json operator()(const UseCalibration& c) const {
    return {{"command", "use_calibration"}, {"version", c.version}};
  }
  json operator()(const RestoreCalibration& c) const {
    return {{"command", "restore_calibration"}, {"calibration", c.json}};
  }
  json operator()(const Recentre&) const { return {{"command", "recentre"}}; }
  json operator()(const Bind& c) const {
    return {{"command", "bind"}, {"sensor", c.sensor}, {"device", sensor::format_device(c.device)}};
  }
  json operator()(const Hear& c) const {
    return {{"command", "hear"}, {"sensor", c.sensor}, {"source", c.source}};
  }
  json operator()(const Tap& c) const { return {{"command", "tap"}, {"sensor", c.sensor}}; }
  json operator()(const Cover& c) const { return {{"command", "cover"}, {"sensor", c.sensor}}; }
  json operator()(const View& c) const {
    json out = {{"command", "view"}, {"sensor", c.sensor}};
    if (c.change.crop) out["crop"] = *c.change.crop;
    if (c.change.turn_deg) out["turn_deg"] = *c.change.turn_deg;
    if (c.change.mirror) out["mirror"] = *c.change.mirror;
    return out;
  }
  json operator()(const Shape& c) const {
    json out = json::parse(c.json);
    out["command"] = "shape";
    return out;
  }
  json operator()(const AddPrompt& c) const {
    json out = {{"command", "prompt"},
                {"name", c.prompt.name},
                {"say", c.prompt.say},
                {"seconds", c.prompt.seconds},
                {"target", json::parse(target_json(c.prompt.target))}};
    const auto add = [&out](const char* key, const std::string& text) {
      if (!text.empty()) out[key] = text;
    };
    add("text", c.prompt.text);
    add("block", c.prompt.block);
    add("emotion", c.prompt.emotion);
    add("language", c.prompt.language);
    if (c.prompt.own_pace) out["own_pace"] = true;
    return out;
  }
  json operator()(const Correct& c) const {
    json out = json::parse(model::write_correction(c.correction));
    out["command"] = "correct";
    return out;
  }
  json operator()(const EndConsent&) const { return {{"command", "consent_over"}}; }
  json operator()(const GiveConsent& c) const {
    json out = json::parse(consent_event_json(c.consent));
    out["command"] = "consent";
    return out;
  }
  json operator()(const Prompting& c) const {
    return {{"command", "prompts"}, {"do", kPromptingWords.at(static_cast<std::size_t>(c.what))}};
  }
};

}  // namespace

bool is_session_command(std::string_view name) {
  constexpr std::size_t kMostBytes = 64;  // Of a name: a longer one is no command's.
  if (name.size() > kMostBytes) return false;
  const auto parsed = parse_command(dumped({{"command", name}}));
  return parsed || parsed.error().code != ErrorCode::unsupported;
}

Result<Command> parse_command(std::string_view text) {
  if (text.size() > kMaxCommandBytes)
    return fail(ErrorCode::out_of_range, "a command of more than 128 KB", kCommand, "make it shorter");
  bool deep = false;
  const auto shallow = [&deep](int depth, json::parse_event_t, json&) {
    deep = deep || depth > kMaxDepth;
    return !deep;
  };
  const json object = json::parse(text, shallow, false);
  if (deep || !object.is_object())
    return fail(ErrorCode::malformed, "not a JSON object of a command", kCommand,
                "docs/reference/page_protocol.md lists the commands");
  MIEN_TRY_ASSIGN(const std::string name, text_of(object, "command"));
  if (name == "calibrate") return calibrate_of(object);
  if (name == "cancel_calibration") return CancelCalibration{};
  if (name == "use_calibration") {
    const auto version = object.find("version");
    if (version == object.end() || !version->is_number_integer())
      return fail(ErrorCode::malformed, "\"version\" is missing or no whole number", kCommand);
    return UseCalibration{version->get<std::int64_t>()};
  }
  if (name == "restore_calibration") {
    MIEN_TRY_ASSIGN(std::string calibration, text_of(object, "calibration"));
    return RestoreCalibration{std::move(calibration)};
  }
  if (name == "recentre") return Recentre{};
  if (name == "bind") {
    MIEN_TRY_ASSIGN(std::string sensor, text_of(object, "sensor"));
    MIEN_TRY_ASSIGN(const std::string device, text_of(object, "device"));
    MIEN_TRY_ASSIGN(const sensor::DeviceKey key, sensor::parse_device(device));
    return Bind{std::move(sensor), key};
  }
  if (name == "hear") {
    MIEN_TRY_ASSIGN(std::string sensor, text_of(object, "sensor"));
    MIEN_TRY_ASSIGN(std::string source, text_of(object, "source"));
    return Hear{std::move(sensor), std::move(source)};
  }
  if (name == "tap") {
    MIEN_TRY_ASSIGN(std::string sensor, text_of(object, "sensor"));
    return Tap{std::move(sensor)};
  }
  if (name == "cover") {
    MIEN_TRY_ASSIGN(std::string sensor, text_of(object, "sensor"));
    return Cover{std::move(sensor)};
  }
  if (name == "view") return view_of(object);
  if (name == "shape") return shape_of(object);
  if (name == "prompt") {
    MIEN_TRY_ASSIGN(Prompt prompt, prompt_of(object));
    return AddPrompt{std::move(prompt)};
  }
  if (name == "prompts") {
    MIEN_TRY_ASSIGN(const std::string word, text_of(object, "do"));
    const auto* const found = std::ranges::find(kPromptingWords, word);
    if (found == kPromptingWords.end())
      return fail(ErrorCode::malformed, fmt::format("\"do\": \"{}\" is nothing to do", excerpt(word)),
                  kCommand, fmt::format("{}", fmt::join(kPromptingWords, ", ")));
    return Prompting{static_cast<Prompting::Do>(found - kPromptingWords.begin())};
  }
  if (name == "consent") return consent_in(object);
  if (name == "consent_over") return EndConsent{};
  if (name == "correct") {
    Correct correct;
    MIEN_TRY_ASSIGN(correct.correction, model::parse_correction(text, kCommand));
    return correct;
  }
  return fail(ErrorCode::unsupported, fmt::format("there is no command \"{}\"", excerpt(name)), kCommand,
              "docs/reference/page_protocol.md lists them");
}

std::string write_command(const Command& command) {
  return std::visit(Writer{}, command).dump();
}

}  // namespace mien::session
