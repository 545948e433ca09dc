#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "mien/core/excerpt.h"
#include "mien/session/session.h"

namespace mien::session {
namespace {

const char* const kSession = "session";

/// Calibrations of one session.
constexpr std::size_t kMaxVersions = 256;

}  // namespace

Result<void> Session::command(HostTime, std::string_view json) {
  MIEN_TRY_ASSIGN(const Command command, parse_command(json));
  return std::visit([this](const auto& c) { return execute(c); }, command);
}

Result<void> Session::execute(const Calibrate& command) {
  MIEN_TRY(check_versions());
  if (command.kind == Calibrate::Kind::wearer && !trackers_.guidance().learns_wearer)
    return fail(
        ErrorCode::unsupported, "nothing here learns a wearer", kSession,
        "it takes sensors on the skin and a model such as models/live.safetensors; or calibrate full");
  if (command.kind == Calibrate::Kind::gaze && !trackers_.guidance().learns_gaze)
    return fail(ErrorCode::unsupported, "nothing here learns where its wearer looks", kSession,
                "it takes a headset with a camera that sees an eye, such as rigs/headset.toml has");
  if (!command.steps.empty() && frames_ > 0 && command.steps.front().begin <= newest_frame_)
    return fail(ErrorCode::out_of_range, "a step of this calibration has begun already", kSession,
                "give steps that are to come");
  MIEN_TRY(execute(CancelCalibration{}));
  drop_recentring();
  failure_ = {};
  guide_.begin(command);
  return {};
}

Result<void> Session::execute(const CancelCalibration&) {
  if (guide_.running()) leave_guide("cancelled; the calibration before it is in force");
  return {};
}

Result<void> Session::execute(const UseCalibration& command) {
  const std::int64_t id = command.version;
  const auto found = std::ranges::find(versions_, id, &CalibrationVersion::id);
  if (found == versions_.end())
    return fail(ErrorCode::not_found, fmt::format("there is no calibration {}", id), kSession,
                "choose one of the list");
  MIEN_TRY_ASSIGN(const shaping::Centre centre, shaping::parse_centre(found->centre, kSession));
  MIEN_TRY_ASSIGN(const shaping::RestingFace resting, shaping::parse_resting_face(found->resting, kSession));
  MIEN_TRY(execute(CancelCalibration{}));
  if (!found->json.empty()) MIEN_TRY(trackers_.restore(found->json));
  drop_recentring();
  shaper_.use_centre(centre);
  shaper_.use_resting(resting);
  in_force_ = id;
  drift_watch_.reset();
  // What it knows of boards that sat elsewhere then does not hold of those that sit there now.
  for (std::uint16_t i = 0; i < bound_at_.size(); ++i)
    if (bound_at_[i] > found->made) forget(i);
  add_event("calibrated", newest_frame_, newest_frame_, fmt::format(R"({{"version": {}}})", id));
  return {};
}

Result<void> Session::check_versions() const {
  if (versions_.size() < kMaxVersions) return {};
  return fail(ErrorCode::out_of_range,
              fmt::format("{} calibrations are enough for one session", kMaxVersions), kSession,
              "start a new one");
}

Result<void> Session::execute(const RestoreCalibration& command) {
  MIEN_TRY(check_versions());
  MIEN_TRY(execute(CancelCalibration{}));
  MIEN_TRY(trackers_.restore(command.json));
  drop_recentring();
  add_version(newest_frame_, "restored", trackers_.scores());
  return {};
}

Result<void> Session::execute(const Recentre&) {
  if (guide_.running())
    return fail(ErrorCode::bad_usage, "a guided calibration is running", kSession, "finish or cancel it");
  MIEN_TRY(check_versions());
  recentre();
  add_event("recentre", newest_frame_, newest_frame_);
  return {};
}

void Session::recentre() {
  if (rest_end_) trackers_.rest(*rest_end_, *rest_end_);
  recentring_ = true;
  rest_ = trackers_.wants_rest();
  rest_end_.reset();
  if (rest_ == Duration::zero()) shaper_.recentre();
}

void Session::drop_recentring() {
  if (!recentring_) return;
  recentring_ = false;
  if (rest_end_) trackers_.rest(*rest_end_, *rest_end_);
  shaper_.use_centre(shaper_.recentring().centre());
  rest_ = Duration::zero();
  rest_end_.reset();
}

Result<std::uint16_t> Session::sensor_named(std::string_view name) const {
  if (const auto sensor = rig().find(name)) return *sensor;
  return fail(ErrorCode::not_found, fmt::format("the rig has no sensor \"{}\"", excerpt(name)), kSession,
              "the page lists its sensors");
}

Result<void> Session::execute(const Bind& command) {
  MIEN_TRY_ASSIGN(const std::uint16_t sensor, sensor_named(command.sensor));
  receiver_->bind(sensor, command.device, *this);
  return {};
}

Result<void> Session::execute(const Hear& command) {
  MIEN_TRY_ASSIGN(const std::uint16_t sensor, sensor_named(command.sensor));
  if (!receiver_->hear(sensor, command.source, *this))
    return fail(ErrorCode::not_found,
                fmt::format("nobody sends as {} from {}", command.sensor, excerpt(command.source)), kSession,
                "the page lists who does");
  return {};
}

Result<void> Session::execute(const Tap& command) {
  if (!command.sensor.empty()) MIEN_TRY(sensor_named(command.sensor));
  receiver_->bind_by_tap(command.sensor);
  return {};
}

Result<void> Session::execute(const Cover& command) {
  if (!command.sensor.empty()) {
    MIEN_TRY_ASSIGN(const std::uint16_t sensor, sensor_named(command.sensor));
    if (!rig().sensors[sensor].camera)
      return fail(ErrorCode::mismatch, fmt::format("{} is no camera", command.sensor), kSession,
                  "tap a sensor on the skin to bind it");
  }
  receiver_->bind_by_cover(command.sensor);
  return {};
}

Result<void> Session::execute(const View& command) {
  MIEN_TRY_ASSIGN(const std::uint16_t sensor, sensor_named(command.sensor));
  return receiver_->change_view(sensor, command.change, *this);
}

Result<void> Session::execute(const Shape& command) {
  MIEN_TRY_ASSIGN(const shaping::ShaperSettings settings,
                  shaping::parse_settings(command.json, kSession, shaper_.settings()));
  shaper_.set(settings);
  receiver_->listen_to_sound(settings.merge.audio && !takes_no_sound_);
  return {};
}

Result<void> Session::execute(const AddPrompt& command) {
  if (!command.prompt.block.empty() && !consented_)
    return fail(ErrorCode::bad_usage, "nobody has agreed to be recorded for a dataset", kSession,
                "begin it from the page, which asks the performer first");
  return prompter_.add(command.prompt);
}

Result<void> Session::execute(const Correct& command) {
  MIEN_TRY(check_versions());
  MIEN_TRY(execute(CancelCalibration{}));
  MIEN_TRY(trackers_.correct(command.correction));
  add_version(newest_frame_, "phone", trackers_.scores());
  return {};
}

Result<void> Session::execute(const EndConsent&) {
  if (std::exchange(consented_, false) && !consent_to_tell_)
    add_event("consent_over", newest_frame_, newest_frame_);
  consent_to_tell_.reset();
  return {};
}

Result<void> Session::execute(const GiveConsent& command) {
  consented_ = true;
  consent_to_tell_ = command.consent;
  return {};
}

Result<void> Session::execute(const Prompting& command) {
  switch (command.what) {
    case Prompting::Do::skip:
      return prompter_.skip();
    case Prompting::Do::pause:
      return prompter_.pause(true);
    case Prompting::Do::resume:
      return prompter_.pause(false);
    case Prompting::Do::begin:
      return prompter_.begin_block();
    case Prompting::Do::next:
      return prompter_.go_on();
    case Prompting::Do::again:
      return prompter_.repeat();
    case Prompting::Do::voice:
    case Prompting::Do::key:
      prompter_.follow_voice(command.what == Prompting::Do::voice);
      return {};
    case Prompting::Do::stop:
      break;
  }
  return prompter_.stop();
}

}  // namespace mien::session
