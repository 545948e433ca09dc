#include "mien/live/page_messages.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <utility>

#include "mien/core/units.h"
#include "mien/session/json_fields.h"

namespace mien::live {
namespace {

using nlohmann::json;
using session::dumped;

/// Two digits behind the point are enough for people.
double rounded(double value) {
  return std::isfinite(value) ? std::round(value * 100) / 100 : 0;
}
double milliseconds(Duration duration) {
  return std::round(1e6 * to_seconds(duration)) / 1e3;
}

json rivals_json(const std::vector<session::Report::Rival>& rivals) {
  json out = json::array();
  for (const session::Report::Rival& rival : rivals)
    out.push_back(
        {{"source", rival.source}, {"age_ms", milliseconds(rival.age)}, {"implausible", rival.implausible}});
  return out;
}

json view_json(const std::optional<sensor::PictureView>& view) {
  if (!view) return nullptr;
  return {{"crop", view->crop}, {"turn_deg", view->turn_deg}, {"mirror", view->mirror}};
}

json cover_json(const session::Report::Cover& cover) {
  if (cover.sensor.empty() && cover.trouble.empty()) return nullptr;
  return {{"sensor", cover.sensor.empty() ? json(nullptr) : json(cover.sensor)},
          {"trouble", cover.trouble.empty() ? json(nullptr) : json(cover.trouble)}};
}

json link_json(const session::Report::Link& link, const std::string& sensor) {
  const sensor::LinkReport& health = link.health;
  json out = {{"sensor", sensor},
              {"device", link.device},
              {"source", link.source},
              {"rivals", rivals_json(link.rivals)},
              {"state", sensor::link_state_name(health.state)},
              {"age_ms", health.age ? json(milliseconds(*health.age)) : json(nullptr)},
              {"rate_hz", rounded(health.rate_hz)},
              {"lost", health.lost},
              {"late", health.late},
              {"doubled", health.doubled},
              {"reordered", health.reordered},
              {"malformed", health.malformed},
              {"loss", std::round(health.loss * 1e4) / 1e4},
              {"offset_ms", nullptr},
              {"drift_ppm", nullptr},
              {"uncertainty_ms", nullptr},
              {"battery", health.battery_percent ? json(*health.battery_percent) : json(nullptr)},
              {"heading_sigma_deg", link.heading_sigma_rad
                                        ? json(rounded(*link.heading_sigma_rad * 180 / std::numbers::pi))
                                        : json(nullptr)},
              {"rotation_sigma_deg",
               link.certainty ? json(rounded(kDegPerRad * link.certainty->sigma_rad)) : json(nullptr)},
              {"left_out", link.certainty && link.certainty->left_out},
              {"level", link.level ? json(std::round(*link.level * 1e3) / 1e3) : json(nullptr)},
              {"estimated", health.estimated},
              {"view", view_json(link.view)}};
  if (health.clock) {
    out["offset_ms"] = milliseconds(health.clock->offset);
    out["drift_ppm"] = rounded(health.clock->drift_ppm);
    out["uncertainty_ms"] = milliseconds(health.clock->uncertainty);
  }
  return out;
}

/// Null where no frame came: none is not quick.
json latency_json(const Latencies& latency) {
  if (latency.count() == 0) return {{"p50", nullptr}, {"p99", nullptr}, {"max", nullptr}};
  return {{"p50", milliseconds(latency.percentile(0.5))},
          {"p99", milliseconds(latency.percentile(0.99))},
          {"max", milliseconds(latency.largest())}};
}

/// What is kept of the session until its end, and how long it can be kept at the present rate.
json log_json(const Recorder::State& recording) {
  const auto megabytes = [](std::uint64_t bytes) { return rounded(static_cast<double>(bytes) / 1e6); };
  const Spool::Usage& log = recording.log;
  return {{"megabytes", megabytes(log.bytes)},
          {"limit_megabytes", megabytes(log.limit)},
          {"payload_megabytes", megabytes(log.payload_bytes)},
          {"payload_limit_megabytes", megabytes(log.payload_limit)},
          {"hours_left", log.seconds_left ? json(rounded(*log.seconds_left / 3600)) : json(nullptr)},
          {"error", recording.unable.empty() ? json(nullptr) : json(recording.unable)}};
}

json hearing_json(const session::Report& report, const HearingState& feeds) {
  // Who shut every microphone is shown that, whatever the rig has.
  if (!report.hearing && !feeds.shut) return nullptr;
  const session::Report::Hearing hearing = report.hearing.value_or(
      session::Report::Hearing{.on = false, .speaks = false, .share = 0, .later = {}});
  json browser = nullptr;
  if (feeds.browser) browser = {{"heard", feeds.browser->heard}, {"refused", feeds.browser->refused}};
  return {{"on", hearing.on},
          {"speaks", hearing.speaks},
          {"share", rounded(hearing.share)},
          {"later_ms", milliseconds(hearing.later)},
          {"shut", feeds.shut},
          {"blocks", feeds.handed_over},
          {"trouble", feeds.trouble.empty() ? json(nullptr) : json(feeds.trouble)},
          {"browser", std::move(browser)}};
}

json pictures_json(const std::optional<PicturesState>& pictures) {
  if (!pictures) return nullptr;
  return {{"cameras", pictures->cameras}, {"watchers", pictures->watchers}};
}

/// Which way a sensor looks that does not sit on the skin.
std::optional<Vec3> aim_of(const sensor::Mount& mount) {
  if (!mount.camera || !mount.position_m) return mount.aim;
  const Vec3 sight = mount.camera->look_at_m - *mount.position_m;
  return sight.norm() > 0 ? std::optional<Vec3>(sight.normalized()) : std::nullopt;
}

/// The settings, and the resting face that is in force.
json shaping_json(const session::Report& report) {
  json shaping = json::parse(report.shaping, nullptr, false);
  json resting = json::parse(report.resting, nullptr, false);
  if (!shaping.is_object()) return shaping;
  shaping.erase("rules");  // A file's whole text, five times a second.
  if (resting.is_object()) shaping["resting_face"] = std::move(resting);
  return shaping;
}

json network_json(const NetworkState& network, std::uint64_t refused) {
  json interfaces = json::array();
  for (const NetworkInterface& one : network.interfaces)
    interfaces.push_back({{"name", one.name}, {"address", one.address}, {"loopback", one.loopback}});
  return {{"open", network.open},     {"interfaces", std::move(interfaces)},
          {"only", network.only},     {"elsewhere", network.elsewhere},
          {"sealed", network.sealed}, {"unsealed", network.unsealed},
          {"refused", refused}};
}

json target_object(const face::BlendshapeWeights& target) {
  json out = json::object();
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    if (target[k] != 0) out[std::string(face::kShapeNames[k])] = rounded(target[k]);
  return out;
}

json prompts_json(const session::Report::Prompts& prompts) {
  if (prompts.state == "none" || prompts.state.empty()) return nullptr;
  const bool over = prompts.state == "over";
  return {{"state", prompts.state},
          {"name", prompts.prompt.name},
          {"say", prompts.prompt.say},
          {"text", prompts.prompt.text},
          {"block", prompts.prompt.block},
          {"emotion", prompts.prompt.emotion},
          {"language", prompts.prompt.language},
          {"own_pace", prompts.prompt.own_pace},
          {"attempt", prompts.prompt.attempt},
          {"poor", prompts.poor},
          {"again", prompts.again},
          {"target", over ? json(nullptr) : target_object(prompts.prompt.target)},
          {"next", prompts.next.name.empty() ? json(nullptr)
                                             : json({{"name", prompts.next.name},
                                                     {"text", prompts.next.text},
                                                     {"target", target_object(prompts.next.target)}})},
          {"number", prompts.number},
          {"of", prompts.of},
          {"progress", rounded(prompts.progress)},
          {"remaining_s", rounded(prompts.remaining_s)},
          {"left_s", rounded(prompts.left_s)}};
}

json dataset_json(const std::optional<DatasetRecording::State>& dataset) {
  if (!dataset) return nullptr;
  return {{"name", dataset->name},
          {"performer", dataset->performer},
          {"take", dataset->take},
          {"lines", dataset->lines},
          {"done", dataset->done},
          {"over", dataset->over},
          {"error", dataset->error.empty() ? json(nullptr) : json(dataset->error)}};
}

json video_state_json(const std::optional<VideoState>& video) {
  if (!video) return nullptr;
  return {{"agreed", video->agreed},
          {"on", video->on},
          {"file", video->file},
          {"files", video->files},
          {"megabytes", rounded(video->megabytes)},
          {"trouble", video->trouble.empty() ? json(nullptr) : json(video->trouble)},
          {"refused", video->refused}};
}

json lesson_json(const PhoneLesson::State& lesson) {
  if (lesson.stage == PhoneLesson::Stage::none) return nullptr;
  return {{"state", stage_name(lesson.stage)}, {"sentence", lesson.sentence}, {"learnt", lesson.learnt}};
}

json calibration_json(const session::Report::Calibration& calibration) {
  json versions = json::array();
  for (const session::CalibrationVersion& version : calibration.versions) {
    json scores = json::array();
    for (const sensor::Score& score : version.scores)
      scores.push_back({{"name", score.name},
                        {"value", rounded(score.value)},
                        {"unit", score.unit},
                        {"pass", score.pass},
                        {"sentence", score.sentence}});
    versions.push_back({{"id", version.id},
                        {"time", rounded(to_seconds(version.made.time_since_epoch()))},
                        {"in_force", version.id == calibration.in_force},
                        {"origin", version.origin},
                        {"scores", std::move(scores)}});
  }
  json target = calibration.target ? target_object(*calibration.target) : json(nullptr);
  json look = nullptr;
  if (calibration.look_rad)
    look = {{"yaw_deg", rounded(kDegPerRad * double{calibration.look_rad->x()})},
            {"pitch_deg", rounded(kDegPerRad * double{calibration.look_rad->y()})}};
  const auto number = [](const std::optional<double>& value) {
    return value ? json(rounded(*value)) : json(nullptr);
  };
  return {{"state", calibration.state},
          {"age_s", number(calibration.age_s)},
          {"recentred_s", number(calibration.recentred_s)},
          {"sigma_deg",
           calibration.sigma_rad ? json(rounded(kDegPerRad * *calibration.sigma_rad)) : json(nullptr)},
          {"advises_recentring", calibration.advises_recentring},
          {"drift_faults", calibration.faults},
          {"step", calibration.step},
          {"prompt", calibration.prompt},
          {"target", std::move(target)},
          {"look", std::move(look)},
          {"progress", rounded(calibration.progress)},
          {"remaining_s", rounded(calibration.remaining_s)},
          {"step_number", calibration.step_number},
          {"steps", calibration.steps},
          {"versions", std::move(versions)}};
}

/// The names in a list of an event's details: "mentalis, buccinator_L"; empty where there are none.
std::string names_text(const json& details, const char* key) {
  std::string all;
  if (!details.is_object() || !details.contains(key) || !details[key].is_array()) return all;
  for (const json& name : details[key])
    if (name.is_string()) all += (all.empty() ? "" : ", ") + name.get<std::string>();
  return all;
}

}  // namespace

sink::Hello hello_for(const sensor::Rig& rig, std::string software, std::string model,
                      std::vector<std::string> listening, bool replay) {
  sink::Hello hello;
  hello.software = std::move(software);
  sink::Hello::Rig shown{rig.name, {}};
  for (const sensor::Mount& mount : rig.sensors)
    shown.sensors.push_back({mount.name, mount.kind, mount.site, std::string(1, mount.side), mount.role,
                             mount.position_m, aim_of(mount)});
  hello.rig = std::move(shown);
  hello.face = "/face.glb";
  hello.model = std::move(model);
  hello.mode = replay ? "replay" : "live";
  hello.listening = std::move(listening);
  return hello;
}

json camera_json(const CameraStatus& camera) {
  json refusals = json::object();
  for (const sensor::Refusal& one : camera.refusals) refusals[std::string(one.why)] = one.count;
  return {{"address", camera.address},
          {"sensor", camera.sensor},
          {"open", camera.open},
          {"note", camera.problem},
          {"lost", camera.lost},
          {"bytes", camera.bytes},
          {"pictures", camera.pictures.whole},
          {"broken", camera.pictures.broken},
          {"overlong", camera.pictures.overlong},
          {"refused", std::move(refusals)},
          {"too_fast", camera.too_fast},
          {"held_back", camera.held_back}};
}

std::string status_json(const Status& status, const sensor::Rig& rig) {
  json links = json::array();
  for (std::size_t i = 0; i < status.report.links.size(); ++i)
    links.push_back(link_json(status.report.links[i], rig.sensors[i].name));
  json unbound = json::array();
  for (const session::Report::Unbound& device : status.report.unbound)
    unbound.push_back({{"device", device.device},
                       {"announces", device.announces},
                       {"age_ms", milliseconds(device.age)},
                       {"protocol", device.protocol}});
  json sinks = json::array();
  for (const SinkState& sink : status.sinks)
    sinks.push_back({{"id", sink.id},
                     {"address", sink.status.address},
                     {"on", sink.on},
                     {"sent", sink.status.sent},
                     {"failed", sink.status.failed},
                     {"rate_hz", rounded(sink.status.rate_hz)},
                     {"receivers", sink.status.receivers ? json(*sink.status.receivers) : json()},
                     {"note", sink.status.note}});
  json lines = json::array();
  for (const SerialPort::Status& line : status.lines)
    lines.push_back({{"address", line.address},
                     {"open", line.open},
                     {"unplugged", line.unplugged},
                     {"note", line.problem}});
  json cameras = json::array();
  for (const CameraStatus& camera : status.cameras) cameras.push_back(camera_json(camera));
  json replay = nullptr;
  if (status.replay)
    replay = {{"take", status.replay->take},
              {"time", rounded(status.replay->time_s)},
              {"duration", rounded(status.replay->duration_s)},
              {"paused", status.replay->paused},
              {"has_truth", status.replay->has_truth},
              {"error", status.replay->error.empty() ? json(nullptr) : json(status.replay->error)}};
  const Recorder::State& recording = status.recording;
  return dumped(
      {{"type", "status"},
       {"time", to_seconds(status.report.time.time_since_epoch())},
       {"frames", status.report.frames},
       {"missed", status.missed},
       {"latency_ms", latency_json(status.latency)},
       {"hold_ms", milliseconds(status.report.hold)},
       {"links", std::move(links)},
       {"unbound", std::move(unbound)},
       {"calibration", calibration_json(status.report.calibration)},
       {"prompts", prompts_json(status.report.prompts)},
       {"sinks", std::move(sinks)},
       {"lines", std::move(lines)},
       {"cameras", std::move(cameras)},
       {"network", network_json(status.network, status.report.refused)},
       {"recording",
        {{"on", recording.on},
         {"path", recording.path.string()},
         {"seconds", rounded(recording.seconds)},
         {"ends_s", status.recording_ends_s ? json(rounded(*status.recording_ends_s)) : json(nullptr)},
         {"megabytes", rounded(status.recording_megabytes)},
         {"error", recording.error.empty() ? json(nullptr) : json(recording.error)}}},
       {"log", log_json(recording)},
       {"dataset", dataset_json(status.dataset)},
       {"video", video_state_json(status.video)},
       {"phone_lesson", lesson_json(status.lesson)},
       {"shaping", shaping_json(status.report)},
       {"hearing", hearing_json(status.report, status.hearing)},
       {"pictures", pictures_json(status.pictures)},
       {"replay", std::move(replay)},
       {"cover", cover_json(status.report.cover)},
       {"tap", status.report.tap.empty() ? json(nullptr) : json({{"sensor", status.report.tap}})}});
}

std::string reply_json(std::int64_t number, std::string_view error, std::string_view result) {
  json object = {
      {"type", "reply"}, {"id", number}, {"ok", error.empty()}, {"error", error}, {"result", nullptr}};
  if (!result.empty()) object["result"] = json::parse(result, nullptr, false);
  return dumped(object);
}

std::string event_text(const take::Event& event) {
  const json details = json::parse(event.json, nullptr, false);
  const auto text = [&](const char* key) { return session::text_field(details, key); };
  if (event.kind == "bind") {
    const bool anew = session::flag_field(details, "anew");
    return text("sensor") + " is now device " + text("device") +
           (anew ? "; calibrate again when all are in their places, it has no neutral yet" : "");
  }
  if (event.kind == "view") return text("sensor") + " is seen otherwise; calibrate again";
  if (event.kind == "contested")
    return fmt::format("two devices send as {}: {} is heard, {} is not; the page's sensors let you choose",
                       text("sensor"), text("accepted"), text("other"));
  if (event.kind == "calibration_failed") return "not calibrated: " + text("why");
  if (event.kind == "recentre_failed") return "not re-centred: " + text("why");
  if (event.kind == "recentre")
    return text("source").empty()
               ? std::string()
               : "re-centring, as " + text("source") + " asks by OSC: relax your face and look ahead";
  if (event.kind == "rested") {
    const std::string moved = names_text(details, "moved"), absent = names_text(details, "absent");
    if (!moved.empty())
      return "the face moved at " + moved +
             " while it should rest, so that was not corrected; relax it and re-centre again";
    return absent.empty() ? std::string()
                          : "not corrected for lack of data: " + absent +
                                "; see to it on the page's sensors, then re-centre again";
  }
  if (event.kind == "recentre_advised") {
    const std::string left_out = names_text(details, "left_out");
    const auto sigma_deg = details.find("sigma_deg");
    const bool known = sigma_deg != details.end() && sigma_deg->is_number();
    return (left_out.empty() ? fmt::format("rotations are known to {:.1f} degrees only",
                                           known ? sigma_deg->get<double>() : 0.0)
                             : "left out for their uncertainty: " + left_out) +
           "; relax your face and press Space on the page, or mien calibrate recentre";
  }
  if (event.kind == "drift_fault")
    return "the estimate of drift was faulty and began anew, which is a defect of this program; relax your "
           "face "
           "and press Space on the page, or mien calibrate recentre";
  if (event.kind != "calibrated") return {};
  const std::string origin = text("origin");
  if (origin == "self") {
    const auto failed = details.value("failed", 0);
    if (failed == 0) return "calibrated by itself";
    return fmt::format(
        "calibrated by itself, but {} of {} scores failed; mien calibrate, or the page, does better", failed,
        details.value("scores", 0));
  }
  if (origin == "guided") return "calibrated";
  if (origin == "recentre") return "re-centred";
  if (origin == "phone") return "what the phone taught is in force";
  if (origin == "restored") return "a calibration from elsewhere is in force";
  return "an earlier calibration is in force";
}

std::string event_json(std::string_view kind, std::string_view text) {
  return dumped({{"type", "event"}, {"kind", kind}, {"text", text}});
}

std::string microphone_json(std::string_view why) {
  return dumped({{"type", "microphone"}, {"on", false}, {"why", why}});
}

std::string video_json(std::string_view why, bool again) {
  return dumped({{"type", "video"}, {"on", false}, {"why", why}, {"again", again}});
}

nlohmann::json takes_json(const std::vector<TakeListing::Entry>& takes) {
  json out = json::array();
  for (const TakeListing::Entry& one : takes)
    out.push_back({{"name", one.name},
                   {"seconds", one.seconds ? json(*one.seconds) : json(nullptr)},
                   {"error", one.error.empty() ? json(nullptr) : json(one.error)},
                   {"megabytes", one.megabytes},
                   {"recorded", fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(one.written))}});
  return {{"takes", std::move(out)}};
}

}  // namespace mien::live
