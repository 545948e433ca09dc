#include "mien/session/session.h"

#include <algorithm>
#include <utility>

#include "mien/core/units.h"
#include "mien/sensor/rig_part.h"
#include "mien/session/json_fields.h"
#include "mien/shaping/bounds.h"

namespace mien::session {
namespace {

using sensor::DeviceKey;
using sensor::Verdict;
using tracker::Step;

/// A shake that judges a calibration ends within this time of it.
constexpr Duration kShakeFollows = std::chrono::seconds(20);
/// A datagram can ask for no re-centring sooner after another, and for so many: a stranger's must leave room
/// for the versions of who sits at the page.
constexpr Duration kAskedEvery = std::chrono::seconds(5);
constexpr std::size_t kMostAsked = 128;
/// Frames between looks at how certain rotations are: a second.
constexpr std::uint64_t kDriftEvery = 60;

std::string quoted(std::string_view key, std::string_view value) {
  return nlohmann::json({{key, value}}).dump();
}

}  // namespace

Result<std::unique_ptr<Session>> Session::create(Parts parts) {
  MIEN_TRY_ASSIGN(
      std::unique_ptr<Receiver> receiver,
      Receiver::create(std::move(parts.rig), std::move(parts.protocols), std::move(parts.reducers)));
  return std::unique_ptr<Session>(new Session(std::move(parts), std::move(receiver)));
}

Session::Session(Parts parts, std::unique_ptr<Receiver> receiver)
    : receiver_(std::move(receiver)),
      trackers_(receiver_->rig(), std::move(parts.trackers)),
      shaper_(parts.shaping, trackers_.modalities()),
      prompt_watch_(receiver_->rig()),
      bound_at_(receiver_->rig().sensors.size()),
      certainties_(receiver_->rig().sensors.size()),
      has_microphone_(!sensor::sensors_of(receiver_->rig(), shaping::Merge::kListening).empty()) {
  receiver_->listen_to_sound(parts.shaping.merge.audio);
}

void Session::rebound(std::uint16_t sensor, const DeviceKey& device, bool was_received) {
  // A guided calibration that has begun with the board before is none; of a truth nothing is calibrated.
  if (was_received && guide_.running() && !rig().sensors[sensor].is_truth())
    leave_guide(failure_ = "a sensor came to another place meanwhile; calibrate again");
  bound_at_[sensor] = newest_frame_;
  const bool anew = in_force_ != 0 && !rig().sensors[sensor].is_truth();
  forget(sensor);
  add_event(
      "bind", newest_frame_, newest_frame_,
      nlohmann::json(
          {{"sensor", rig().sensors[sensor].name}, {"device", sensor::format_device(device)}, {"anew", anew}})
          .dump());
}

void Session::view_changed(std::uint16_t sensor, const sensor::PictureView& view, bool was_received) {
  if (was_received && guide_.running())
    leave_guide(failure_ = "a camera's view was changed meanwhile; calibrate again");
  bound_at_[sensor] = newest_frame_;
  trackers_.change_view(sensor, view);
  if (trackers_.calibration().empty()) in_force_ = 0;
  add_event("view", newest_frame_, newest_frame_,
            nlohmann::json({{"sensor", rig().sensors[sensor].name},
                            {"crop", view.crop},
                            {"turn_deg", view.turn_deg},
                            {"mirror", view.mirror}})
                .dump());
}

void Session::contested(std::uint16_t sensor, std::string_view accepted, std::string_view other) {
  // A take's sources need not be UTF-8.
  add_event("contested", newest_frame_, newest_frame_,
            dumped({{"sensor", rig().sensors[sensor].name}, {"accepted", accepted}, {"other", other}}));
}

void Session::asked_to_recentre(HostTime arrival, std::string_view source) {
  if (asked_at_ && arrival - *asked_at_ < kAskedEvery) return;
  asked_at_ = arrival;
  // Who follows a calibration's steps goes on.
  if (guide_.running() || asked_ == kMostAsked || !check_versions()) return;
  ++asked_;
  recentre();
  add_event("recentre", newest_frame_, newest_frame_, dumped({{"source", source}}));
}

void Session::leave_guide(std::string_view why) {
  guide_.cancel();
  trackers_.cancel_guidance();
  renewed_.clear();
  // Without a frame there is no time at which it could have been.
  if (frames_ > 0) add_event("calibration_failed", newest_frame_, newest_frame_, quoted("why", why));
}

void Session::forget(std::uint16_t sensor) {
  receiver_->forget(sensor);
  if (rig().sensors[sensor].is_truth()) return;  // No tracker knows it.
  trackers_.forget(sensor);
  if (trackers_.calibration().empty()) in_force_ = 0;
}

const face::OutputFrame& Session::tick(DeviceTime frame, HostTime fired) {
  newest_frame_ = frame;
  guide_.before(frame, trackers_);
  begin_rest(frame);
  TrackerSet::Answer tracked = trackers_.tick(frame, receiver_->lines());
  follow_rest(frame, tracked.rested);
  hearing_ = tracked.hearing.value_or(tracker::TickResult::Hearing{});
  shape(frame);
  if (std::ranges::count(frame_.provenance, face::Provenance::audio) > 0) ++audio_frames_;
  const bool guided = guide_.running();
  if (guided) follow_guided(tracked.calibration);
  if (guide_.after(frame_)) {
    failure_ = trackers_.calibration_state().hint;
    for (const Guide::Part& part : guide_.parts()) {
      if (part.target != nullptr)
        add_event("prompt", part.begin, part.end,
                  prompt_event_json({.name = std::string(part.name), .say = {}, .target = *part.target}));
      else if (part.look != nullptr)
        add_event("gaze", part.looks_from(), part.end, gaze_event_json(*part.look));
      else if (part.step != Step::none && failure_.empty())
        add_event(std::string(step_name(part.step)), part.begin, part.end, R"({"guided": true})");
    }
    if (!failure_.empty()) add_event("calibration_failed", frame, frame, quoted("why", failure_));
    // Of several trackers one may have failed and another not.
    if (failure_.empty() || !renewed_.empty()) {
      std::vector<sensor::Score> scores = trackers_.scores();
      for (const sensor::Score& score : guide_.anchor_scores()) scores.push_back(score);
      add_version(frame, "guided", std::move(scores));
    }
    renewed_.clear();
  } else if (guide_.steps_over(frame) && renewed_.empty() && !trackers_.calibration_state().hint.empty()) {
    // Its steps made no calibration: nobody is to make faces for nothing.
    leave_guide(failure_ = trackers_.calibration_state().hint);
  }
  follow_recentring(frame);
  if (!guided) follow_calibration(frame, tracked.calibration);
  if (frames_ % kDriftEvery == 0) watch_drift(frame);
  watch_links(frame, fired);
  follow_prompts(frame);
  ++frames_;
  hash_.add(frame_);
  return frame_;
}

void Session::shape(DeviceTime frame) {
  if (trackers_.empty()) {
    frame_ = face::neutral_frame(frame);
    return;
  }
  sensors_present_ = shaper_.apply(trackers_.sources(), frame_);
  trackers_.follow_lag(hearing_.behind, shaper_.settings().merge.sure);
}

void Session::follow_prompts(DeviceTime frame) {
  if (consent_to_tell_) add_event("consent", frame, frame, consent_event_json(*consent_to_tell_));
  consent_to_tell_.reset();
  const Prompter::Place place = prompter_.place(frame);
  if (place.state == Prompter::State::running && !place.prompt->block.empty())
    prompt_watch_.add(place.begin, frame_, [this](std::uint16_t sensor) {
      return receiver_->is_lost(sensor)       ? PromptWatch::Link::lost
             : receiver_->has_no_face(sensor) ? PromptWatch::Link::no_face
                                              : PromptWatch::Link::there;
    });
  const std::optional<Prompter::Shown> shown = prompter_.at(frame, hearing_.speaks);
  if (!shown) return;
  poor_.clear();
  if (!shown->prompt.block.empty()) {
    poor_ = prompt_watch_.poor(shown->prompt, rig());
    if (poor_.empty())
      prompter_.accept(shown->prompt);
    else
      prompter_.ask_again(shown->prompt);
  }
  add_event("prompt", shown->begin, shown->end, prompt_event_json(shown->prompt, poor_));
}

void Session::begin_rest(DeviceTime frame) {
  if (rest_ <= Duration::zero() || rest_end_) return;
  rest_end_ = frame + rest_;
  trackers_.rest(frame, *rest_end_);
}

void Session::follow_rest(DeviceTime frame, const std::optional<tracker::RestOutcome>& rested) {
  if (rested) {
    const auto names = [this](const std::vector<std::uint16_t>& sensors) {
      std::vector<std::string> out;
      for (const std::uint16_t sensor : sensors) out.push_back(rig().sensors[sensor].name);
      return out;
    };
    add_event("rested", rest_end_.value_or(frame) - rest_, frame,
              nlohmann::json({{"corrected", names(rested->corrected)},
                              {"moved", names(rested->moved)},
                              {"absent", names(rested->absent)}})
                  .dump());
  }
  if (!rest_end_ || frame < *rest_end_) return;
  rest_ = Duration::zero();
  rest_end_.reset();
  shaper_.recentre();
}

void Session::follow_recentring(DeviceTime frame) {
  using Centring = shaping::Recentre::State;
  const Centring state = shaper_.recentring().state();
  if (!recentring_ || rest_ > Duration::zero() || (state != Centring::done && state != Centring::failed))
    return;
  recentring_ = false;
  if (state == Centring::done)
    add_version(frame, "recentre", {});
  else
    add_event("recentre_failed", frame, frame,
              quoted("why", in_force_ == 0 ? "nothing is calibrated yet" : "no sensor sent anything"));
}

void Session::watch_drift(DeviceTime frame) {
  for (std::uint16_t i = 0; i < certainties_.size(); ++i) certainties_[i] = trackers_.certainty(i);
  if (const auto advice = drift_watch_.add(frame, certainties_)) {
    std::vector<std::string> left_out;
    for (const std::uint16_t sensor : advice->left_out) left_out.push_back(rig().sensors[sensor].name);
    add_event("recentre_advised", frame, frame,
              nlohmann::json({{"sigma_deg", kDegPerRad * advice->sigma_rad}, {"left_out", left_out}}).dump());
  }
  if (const std::uint64_t faults = trackers_.faults(); faults != faults_) {
    faults_ = faults;
    add_event("drift_fault", frame, frame, nlohmann::json({{"count", faults}}).dump());
  }
}

void Session::follow_guided(std::span<const tracker::CalibrationEvent> events) {
  for (const tracker::CalibrationEvent& event : events) {
    std::erase(renewed_, event.modality);
    if (event.kind != tracker::CalibrationEvent::Kind::withdrawn) renewed_.push_back(event.modality);
  }
}

void Session::follow_calibration(DeviceTime frame, std::span<tracker::CalibrationEvent> events) {
  if (events.empty()) return;
  std::vector<tracker::PerformedStep> found;
  for (const tracker::CalibrationEvent& event : events)
    found.insert(found.end(), event.found.begin(), event.found.end());
  std::vector<sensor::Score> scores = trackers_.scores();
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
  for (const tracker::PerformedStep& step : found)
    add_event(std::string(step_name(step.step)), step.begin, step.end, R"({"found": true})");
}

void Session::add_version(DeviceTime frame, std::string_view origin, std::vector<sensor::Score> scores) {
  CalibrationVersion& version = versions_.emplace_back();
  version.id = static_cast<std::int64_t>(versions_.size());
  version.made = frame;
  version.origin = origin;
  version.json = trackers_.calibration();
  version.centre = shaping::write_centre(shaper_.recentring().centre());
  version.resting = shaping::write_resting_face(shaper_.resting().learnt());
  version.scores = std::move(scores);
  in_force_ = version.id;
  drift_watch_.reset();
  const auto failed = std::ranges::count(version.scores, false, &sensor::Score::pass);
  add_event(
      "calibrated", frame, frame,
      nlohmann::json({{"origin", std::string(origin)}, {"failed", failed}, {"scores", version.scores.size()}})
          .dump());
}

void Session::watch_links(DeviceTime frame, HostTime fired) {
  receiver_->watch_links(fired, [&](std::uint16_t sensor, LinkChange what) {
    add_event(std::string(link_change_name(what)), frame, frame,
              quoted("sensor", rig().sensors[sensor].name));
  });
}

void Session::add_event(std::string kind, DeviceTime begin, DeviceTime end, std::string json) {
  events_.push_back({std::move(kind), begin, end, std::move(json)});
}

std::vector<take::Event> Session::take_events() {
  return std::exchange(events_, {});
}

}  // namespace mien::session
