#include "mien/session/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <utility>

#include "mien/sensor/level.h"

namespace mien::session {
namespace {

using sensor::DeviceKey;
using sensor::Verdict;
using tracker::Step;

const char* const kSession = "session";

/// A device that was heard from one place lately is not believed from another: two with one id.
constexpr Duration kSamePlace = std::chrono::seconds(1);
/// Nor is one whose time is so far from what it said last, ...
constexpr Duration kSameClock = std::chrono::seconds(1);
/// ... unless it was silent for as long as a board takes to begin anew.
constexpr Duration kSameBoard = std::chrono::milliseconds(300);
/// A sensor is lost when nothing was heard of it for this long, ...
constexpr Duration kLost = std::chrono::milliseconds(100);
/// ... or, where the board sends nothing while nothing changes, for this.
constexpr Duration kLostEstimated = std::chrono::seconds(1);
/// A shake that judges a calibration ends within this time of it.
constexpr Duration kShakeFollows = std::chrono::seconds(20);
/// Calibrations of one session.
constexpr std::size_t kMaxVersions = 256;
/// Samples that one datagram can hold.
constexpr std::size_t kMostSamples = 256;
/// Ids of virtual nodes: "MIEN" and the sensor's place in the rig.
constexpr std::uint64_t kVirtualNode = 0x024D'4945'4E00ULL;

std::string quoted(std::string_view key, std::string_view value) {
  return nlohmann::json({{std::string(key), std::string(value)}}).dump();
}

}  // namespace

Result<std::unique_ptr<Session>> Session::create(Parts parts) {
  std::unique_ptr<Session> session(new Session(std::move(parts)));
  MIEN_TRY(session->bind_as_rig_says());
  return session;
}

Session::Session(Parts parts)
    : rig_(std::move(parts.rig)),
      tracker_(std::move(parts.tracker)),
      protocols_(std::move(parts.protocols)),
      shaper_(parts.shaping),
      reshape_(std::move(parts.reshape)),
      ticks_(rig_),
      links_(rig_.sensors.size()),
      bound_at_(rig_.sensors.size()) {
  devices_.reserve(kMaxDevices + rig_.sensors.size());
  bound_.reserve(kMaxDevices + rig_.sensors.size());
  samples_.reserve(kMostSamples);
  inbox_.readings.reserve(kMostSamples);
}

Result<void> Session::bind_as_rig_says() {
  bool any = false;
  for (std::uint16_t i = 0; i < rig_.sensors.size(); ++i) {
    const sensor::Mount& mount = rig_.sensors[i];
    if (mount.device.empty()) continue;
    any = true;
    MIEN_TRY_ASSIGN(const DeviceKey key, sensor::parse_device(mount.device));
    for (const auto& [other, sensor] : bound_)
      if (other == key)
        return fail(ErrorCode::bad_usage,
                    fmt::format("{} and {} are bound to one device, {}", rig_.sensors[sensor].name,
                                mount.name, mount.device),
                    "rig " + rig_.name, "give each sensor a device of its own");
    bound_.emplace_back(key, i);
  }
  if (any) return {};
  for (std::uint16_t i = 0; i < rig_.sensors.size(); ++i)
    bound_.emplace_back(DeviceKey{kVirtualNode + i, 0}, i);
  return {};
}

Session::Device* Session::device(const DeviceKey& key) {
  const auto found = std::ranges::find(devices_, key, &Device::key);
  return found == devices_.end() ? nullptr : &*found;
}

Session::Device* Session::meet(const DeviceKey& key, sensor::Peer peer, std::size_t protocol,
                               HostTime arrival) {
  if (Device* known = device(key)) return known;
  // A stranger's inventions must not keep the rig's own boards out.
  const bool expected = std::ranges::any_of(bound_, [&](const auto& b) { return b.first == key; });
  if (devices_.size() >= kMaxDevices && !expected) return nullptr;
  Device& met = devices_.emplace_back();
  met.key = key;
  met.peer = peer;
  met.heard = arrival;
  met.protocol = protocol;
  for (const auto& [bound, sensor] : bound_)
    if (bound == key) met.sensor = sensor;
  return &met;
}

void Session::bind(std::uint16_t sensor, const DeviceKey& key) {
  if (std::ranges::find(bound_, std::pair(key, sensor)) != bound_.end()) return;
  std::erase_if(bound_, [&](const auto& b) { return b.first == key || b.second == sensor; });
  bound_.emplace_back(key, sensor);
  for (Device& known : devices_) {
    if (known.sensor == sensor) known.sensor.reset();
    if (known.key != key) continue;
    if (known.sensor) links_[*known.sensor] = Link();
    known.sensor = sensor;
  }
  // A guided calibration that has begun with the board before is none.
  if (links_[sensor].heard && guide_.running())
    leave_guide(failure_ = "a sensor came to another place meanwhile; calibrate again");
  links_[sensor] = Link();
  bound_at_[sensor] = newest_frame_;
  const bool anew = in_force_ != 0;
  forget(sensor);
  add_event(
      "bind", newest_frame_, newest_frame_,
      nlohmann::json(
          {{"sensor", rig_.sensors[sensor].name}, {"device", sensor::format_device(key)}, {"anew", anew}})
          .dump());
}

void Session::leave_guide(std::string_view why) {
  guide_.cancel();
  tracker_->cancel_guidance();
  calibrations_ = tracker_->calibration_count();
  // Without a frame there is no time at which it could have been.
  if (frames_ > 0) add_event("calibration_failed", newest_frame_, newest_frame_, quoted("why", why));
}

void Session::forget(std::uint16_t sensor) {
  ticks_.forget(sensor);
  tracker_->forget(sensor);
  if (tracker_->calibration().empty()) in_force_ = 0;
}

void Session::take_reading(HostTime arrival, sensor::Peer peer, std::size_t protocol,
                           const sensor::Reading& reading) {
  Device* from = meet(reading.from, peer, protocol, arrival);
  if (from == nullptr) {
    ++refused_;
    return;
  }
  // Another place, or another clock, while the one that is known still speaks.
  const Duration silent = arrival - from->heard;
  const Duration off = (reading.sample.time - from->newest) - silent;
  const bool other_clock = from->newest != DeviceTime{} && (off > kSameClock || off < -kSameClock);
  const bool impostor = (from->peer != peer && silent < kSamePlace) || (other_clock && silent < kSameBoard);
  if (!impostor) {
    from->peer = peer;
    from->heard = arrival;
    from->newest = reading.sample.time;
    if (const auto tapped = tap_.add(arrival, reading)) {
      const auto sensor = rig_.find(tap_.armed());
      tap_.arm({});
      if (sensor) bind(*sensor, *tapped);
    }
  }
  if (!from->sensor) return;
  Link& link = links_[*from->sensor];
  link.health.add(arrival, reading.sample, reading.saturated);
  if (impostor) return;
  link.heard = arrival;
  link.newest = reading.sample.time;
  link.level = sensor::level(reading.sample);
  link.estimated = reading.sample.time_estimated;
  sensor::Sample& sample = samples_.emplace_back(reading.sample);
  sample.sensor = *from->sensor;
  ticks_.add(arrival, sample);
  tracker_->add(arrival, sample);
}

bool Session::speaks_from(const DeviceKey& key, sensor::Peer peer) const {
  const auto found = std::ranges::find(devices_, key, &Device::key);
  return found != devices_.end() && found->peer == peer;
}

Session::Received Session::receive(HostTime arrival, sensor::Peer peer, std::span<const std::byte> datagram) {
  inbox_.clear();
  samples_.clear();
  Received out;
  out.log = datagram;
  std::size_t protocol = 0;
  while (protocol < protocols_.size() && !protocols_[protocol]->recognises(datagram)) ++protocol;
  out.verdict = protocol < protocols_.size() ? protocols_[protocol]->receive(arrival, peer, datagram, inbox_)
                                             : Verdict::malformed;
  if (out.verdict == Verdict::malformed) {
    ++malformed_;
    for (const Device& known : devices_)
      if (known.peer == peer && known.sensor) links_[*known.sensor].health.add_malformed();
    return out;
  }
  if (out.verdict == Verdict::refused) {
    ++refused_;
    return out;
  }
  for (const sensor::Announcement& said : inbox_.announcements) {
    Device* from = meet(said.from, peer, protocol, arrival);
    if (from == nullptr) continue;
    from->announces = said.site;
    const auto sensor = rig_.find(said.site);
    const bool taken =
        sensor && std::ranges::any_of(bound_, [&](const auto& b) { return b.second == *sensor; });
    if (sensor && !taken && !from->sensor) bind(*sensor, said.from);
  }
  for (const sensor::Reading& reading : inbox_.readings) take_reading(arrival, peer, protocol, reading);
  for (const sensor::Inbox::Pulse& pulse : inbox_.pulses) {
    // A board's sensors share its clock.
    for (const auto& [key, sensor] : bound_) {
      if (key.device != pulse.from.device || !speaks_from(key, peer)) continue;
      ticks_.pulse(sensor, pulse.index, pulse.edge);
      tracker_->pulse(sensor, pulse.index, pulse.edge);
    }
  }
  for (const sensor::Inbox::Battery& battery : inbox_.batteries)
    if (const Device* from = device(battery.from); from != nullptr && from->sensor && from->peer == peer)
      links_[*from->sensor].health.set_battery(battery.percent);
  // A board that says anything at all is there, whichever of its sensors it speaks of.
  const std::optional<DeviceKey> speaker =
      !inbox_.readings.empty() ? std::optional(inbox_.readings.front().from) : inbox_.alive;
  if (speaker)
    for (const Device& known : devices_)
      if (known.key.device == speaker->device && known.peer == peer && known.sensor)
        links_[*known.sensor].health.add_alive(arrival);
  out.samples = samples_;
  if (!inbox_.opened.empty()) out.log = inbox_.opened;
  out.reply = inbox_.reply;
  return out;
}

void Session::say(HostTime now, std::vector<sensor::Protocol::Outgoing>& out) {
  for (const auto& protocol : protocols_) protocol->say(now, out);
}

const face::OutputFrame& Session::tick(DeviceTime frame, HostTime fired) {
  newest_frame_ = frame;
  guide_.before(frame, *tracker_);
  const std::size_t felt = tracker_->tick(frame, frame_);
  shaper_.apply(frame_, felt);
  if (guide_.after(frame_)) {
    failure_ = tracker_->calibration_state().hint;
    for (const Guide::Part& part : guide_.parts()) {
      if (part.target != nullptr)
        add_event("prompt", part.begin, part.end,
                  prompt_event_json({.name = std::string(part.name), .say = {}, .target = *part.target}));
      else if (part.step != Step::none && failure_.empty())
        add_event(std::string(step_name(part.step)), part.begin, part.end, R"({"guided": true})");
    }
    if (!failure_.empty()) add_event("calibration_failed", frame, frame, quoted("why", failure_));
    // Of several trackers one may have failed and another not.
    if (failure_.empty() || tracker_->calibration_count() != calibrations_) {
      std::vector<sensor::Score> scores = tracker_->scores();
      for (const sensor::Score& score : guide_.anchor_scores()) scores.push_back(score);
      add_version(frame, "guided", std::move(scores));
    }
    calibrations_ = tracker_->calibration_count();
  } else if (guide_.steps_over(frame) && tracker_->calibration_count() == calibrations_ &&
             !tracker_->calibration_state().hint.empty()) {
    // Its steps made no calibration: nobody is to make faces for nothing.
    leave_guide(failure_ = tracker_->calibration_state().hint);
  }
  watch_calibration(frame);
  if (std::optional<take::Event> shown = prompter_.at(frame)) events_.push_back(*std::move(shown));
  watch_links(frame, fired);
  ++frames_;
  hash_.add(frame_);
  return frame_;
}

void Session::watch_calibration(DeviceTime frame) {
  using Centring = shaping::Recentre::State;
  if (const Centring state = shaper_.recentring().state();
      recentring_ && (state == Centring::done || state == Centring::failed)) {
    recentring_ = false;
    if (state == Centring::done)
      add_version(frame, "recentre", {});
    else
      add_event("recentre_failed", frame, frame,
                quoted("why", in_force_ == 0 ? "nothing is calibrated yet" : "no sensor was heard"));
  }
  if (guide_.running() || tracker_->calibration_count() == calibrations_) return;
  calibrations_ = tracker_->calibration_count();
  std::vector<sensor::Score> scores = tracker_->scores();
  const std::vector<tracker::PerformedStep> found = new_steps();
  // The shake judges what is in force; all else is a version of its own, and so is what another modality's
  // tracker found.
  const bool judged = !found.empty() &&
                      std::ranges::all_of(found, [](const auto& s) { return s.step == Step::shake; }) &&
                      !versions_.empty() && versions_.back().origin == "self" &&
                      versions_.back().id == in_force_ && frame - versions_.back().made < kShakeFollows;
  if (judged)
    versions_.back().scores = std::move(scores);
  else
    add_version(frame, "self", std::move(scores));
  for (const tracker::PerformedStep& step : found) {
    add_event(std::string(step_name(step.step)), step.begin, step.end, R"({"found": true})");
    told_.push_back(step);
  }
}

std::vector<tracker::PerformedStep> Session::new_steps() const {
  std::vector<tracker::PerformedStep> steps = tracker_->found_steps();
  std::erase_if(steps, [this](const tracker::PerformedStep& step) {
    return std::ranges::any_of(told_,
                               [&](const auto& t) { return t.step == step.step && t.end == step.end; });
  });
  return steps;
}

void Session::add_version(DeviceTime frame, std::string_view origin, std::vector<sensor::Score> scores) {
  CalibrationVersion& version = versions_.emplace_back();
  version.id = static_cast<std::int64_t>(versions_.size());
  version.made = frame;
  version.origin = origin;
  version.json = tracker_->calibration();
  version.centre = shaping::write_centre(shaper_.recentring().centre());
  version.scores = std::move(scores);
  in_force_ = version.id;
  const auto failed = std::ranges::count(version.scores, false, &sensor::Score::pass);
  add_event(
      "calibrated", frame, frame,
      nlohmann::json({{"origin", std::string(origin)}, {"failed", failed}, {"scores", version.scores.size()}})
          .dump());
}

void Session::watch_links(DeviceTime frame, HostTime fired) {
  for (std::size_t i = 0; i < links_.size(); ++i) {
    Link& link = links_[i];
    if (!link.heard) continue;
    const bool lost = fired - *link.heard > (link.estimated ? kLostEstimated : kLost);
    if (lost == link.lost) continue;
    link.lost = lost;
    add_event(lost ? "sensor_lost" : "sensor_back", frame, frame, quoted("sensor", rig_.sensors[i].name));
  }
}

void Session::add_event(std::string kind, DeviceTime begin, DeviceTime end, std::string json) {
  events_.push_back({std::move(kind), begin, end, std::move(json)});
}

std::vector<take::Event> Session::take_events() {
  return std::exchange(events_, {});
}

Result<void> Session::command(HostTime, std::string_view json) {
  MIEN_TRY_ASSIGN(const Command command, parse_command(json));
  return std::visit([this](const auto& c) { return obey(c); }, command);
}

Result<void> Session::obey(const Calibrate& command) {
  MIEN_TRY(check_versions());
  if (command.kind == Calibrate::Kind::wearer && !tracker_->guidance().learns_wearer)
    return fail(
        ErrorCode::unsupported, "nothing here learns a wearer", kSession,
        "it takes sensors on the skin and a model such as models/live.safetensors; or calibrate full");
  MIEN_TRY(obey(CancelCalibration{}));
  failure_ = {};
  guide_.begin(command.kind);
  return {};
}

Result<void> Session::obey(const CancelCalibration&) {
  if (guide_.running()) leave_guide("cancelled; the calibration before it is in force");
  return {};
}

Result<void> Session::use_version(std::int64_t id) {
  const auto found = std::ranges::find(versions_, id, &CalibrationVersion::id);
  if (found == versions_.end())
    return fail(ErrorCode::not_found, fmt::format("there is no calibration {}", id), kSession,
                "choose one of the list");
  MIEN_TRY_ASSIGN(const shaping::Centre centre, shaping::parse_centre(found->centre, kSession));
  MIEN_TRY(obey(CancelCalibration{}));
  if (!found->json.empty()) MIEN_TRY(tracker_->restore(found->json));
  shaper_.use_centre(centre);
  calibrations_ = tracker_->calibration_count();
  in_force_ = id;
  // What it knows of boards that sat elsewhere then does not hold of those that sit there now.
  for (std::uint16_t i = 0; i < bound_at_.size(); ++i)
    if (bound_at_[i] > found->made) forget(i);
  add_event("calibrated", newest_frame_, newest_frame_, fmt::format(R"({{"version": {}}})", id));
  return {};
}

Result<void> Session::obey(const UseCalibration& command) {
  return use_version(command.version);
}

Result<void> Session::check_versions() const {
  if (versions_.size() < kMaxVersions) return {};
  return fail(ErrorCode::out_of_range,
              fmt::format("{} calibrations are enough for one session", kMaxVersions), kSession,
              "start a new one");
}

Result<void> Session::obey(const RestoreCalibration& command) {
  MIEN_TRY(check_versions());
  MIEN_TRY(obey(CancelCalibration{}));
  MIEN_TRY(tracker_->restore(command.json));
  calibrations_ = tracker_->calibration_count();
  add_version(newest_frame_, "restored", tracker_->scores());
  return {};
}

Result<void> Session::obey(const Recentre&) {
  MIEN_TRY(check_versions());
  shaper_.recentre();
  recentring_ = true;
  add_event("recentre", newest_frame_, newest_frame_);
  return {};
}

Result<void> Session::obey(const Bind& command) {
  const auto sensor = rig_.find(command.sensor);
  if (!sensor)
    return fail(ErrorCode::not_found, fmt::format("the rig has no sensor \"{}\"", command.sensor), kSession,
                "the page lists its sensors");
  bind(*sensor, command.device);
  return {};
}

Result<void> Session::obey(const Tap& command) {
  if (!command.sensor.empty() && !rig_.find(command.sensor))
    return fail(ErrorCode::not_found, fmt::format("the rig has no sensor \"{}\"", command.sensor), kSession);
  tap_.arm(command.sensor);
  return {};
}

Result<void> Session::obey(const Shape& command) {
  MIEN_TRY_ASSIGN(const shaping::ShaperSettings settings,
                  shaping::parse_settings(command.json, kSession, shaper_.settings()));
  shaper_.set(settings);
  if (reshape_) reshape_(settings);
  return {};
}

Result<void> Session::obey(const AddPrompt& command) {
  return prompter_.add(command.prompt);
}

Result<void> Session::obey(const Prompting& command) {
  switch (command.what) {
    case Prompting::Do::skip:
      return prompter_.skip();
    case Prompting::Do::pause:
      return prompter_.pause(true);
    case Prompting::Do::resume:
      return prompter_.pause(false);
    case Prompting::Do::stop:
      break;
  }
  return prompter_.stop();
}

void Session::report_prompts(Report::Prompts& out) const {
  static constexpr std::array<std::string_view, 5> kStates = {"none", "ready", "running", "paused", "over"};
  const Prompter::Place place = prompter_.place(newest_frame_);
  out.state = kStates.at(static_cast<std::size_t>(place.state));
  out.name = place.prompt != nullptr ? std::string_view(place.prompt->name) : std::string_view();
  out.say = place.prompt != nullptr ? std::string_view(place.prompt->say) : std::string_view();
  out.target = place.prompt != nullptr ? place.prompt->target : face::BlendshapeWeights();
  out.next = place.next != nullptr ? std::string_view(place.next->name) : std::string_view();
  out.next_target = place.next != nullptr ? place.next->target : face::BlendshapeWeights();
  out.number = place.number;
  out.of = place.of;
  out.progress = place.progress;
  out.remaining_s = to_seconds(place.remaining);
  out.left_s = to_seconds(place.left);
}

void Session::report(HostTime now, Report& out) const {
  out.time = newest_frame_;
  out.frames = frames_;
  out.malformed = malformed_;
  out.refused = refused_;
  out.tap = tap_.armed();
  out.shaping = shaping::write_settings(shaper_.settings());

  out.links.resize(links_.size());
  for (std::uint16_t i = 0; i < links_.size(); ++i) {
    Report::Link& link = out.links[i];
    const auto bound = std::ranges::find(bound_, i, &std::pair<DeviceKey, std::uint16_t>::second);
    link.device = bound == bound_.end() ? std::string() : sensor::format_device(bound->first);
    std::optional<sensor::LinkClock> clock;
    const sensor::TimeLines& lines = ticks_.lines();
    if (links_[i].heard && lines.clock(i).ready()) {
      const sensor::ClockModel& model = lines.clock(i);
      clock = sensor::LinkClock{
          .offset = model.to_host(links_[i].newest).time_since_epoch() - links_[i].newest.time_since_epoch(),
          .drift_ppm = 1e6 * model.rate(),
          .uncertainty = model.uncertainty(links_[i].newest)};
    }
    link.health = links_[i].health.report(now, clock);
    if (bound == bound_.end()) link.health.state = sensor::LinkState::unbound;
    link.level = links_[i].level;
    link.heading_sigma_rad = tracker_->heading_sigma_rad(i);
  }

  out.unbound.clear();
  for (const Device& known : devices_)
    if (!known.sensor)
      out.unbound.push_back({sensor::format_device(known.key), known.announces,
                             std::string(protocols_[known.protocol]->name()), now - known.heard});

  report_prompts(out.prompts);
  Report::Calibration& calibration = out.calibration;
  const tracker::CalibrationState state = tracker_->calibration_state();
  calibration.in_force = in_force_;
  calibration.target.reset();
  calibration.progress = calibration.remaining_s = 0;
  calibration.step_number = calibration.steps = 0;
  if (guide_.running()) {
    calibration.state = "running";
    const Guide::Place place = guide_.place(newest_frame_);
    calibration.step_number = place.number;
    calibration.steps = guide_.parts().size();
    calibration.progress = place.progress;
    calibration.remaining_s = to_seconds(place.remaining);
    calibration.step = place.part == nullptr           ? ""
                       : place.part->target != nullptr ? "anchor"
                                                       : place.part->name;
    calibration.prompt = place.part == nullptr ? std::string_view() : place.part->prompt;
    if (place.part != nullptr && place.part->target != nullptr) calibration.target = *place.part->target;
  } else if (!failure_.empty()) {
    calibration.state = "failed";
    calibration.step.clear();
    calibration.prompt = failure_;
  } else if (state.phase == tracker::CalibrationState::Phase::watching) {
    calibration.state = "watching";
    calibration.step = step_name(state.step);
    calibration.prompt = !state.hint.empty() ? state.hint
                         : state.step == tracker::Step::neutral
                             ? "Look ahead, relax your face and hold still"
                             : "Keep your face still and nod twice, down first";
  } else {
    calibration.state = "done";
    calibration.step.clear();
    calibration.prompt.clear();
  }
  calibration.versions.resize(versions_.size());
  for (std::size_t i = 0; i < versions_.size(); ++i) {
    CalibrationVersion& version = calibration.versions[i];
    version.id = versions_[i].id;
    version.made = versions_[i].made;
    version.origin = versions_[i].origin;
    version.scores = versions_[i].scores;
  }
}

}  // namespace mien::session
