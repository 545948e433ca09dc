#include "mien/session/tracker_set.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cassert>
#include <nlohmann/json.hpp>
#include <utility>

#include "mien/core/excerpt.h"
#include "mien/sensor/rig_part.h"

namespace mien::session {
namespace {

using nlohmann::json;
using tracker::CalibrationState;

constexpr std::uint8_t kNobodys = 0xFF;
/// A tracker without a sample from any of its sensors for this long counts as absent.
constexpr Duration kAbsentAfter = std::chrono::seconds(2);

void append(const tracker::RestOutcome& one, std::optional<tracker::RestOutcome>& all) {
  if (!all) all.emplace();
  const auto add = [](const std::vector<std::uint16_t>& from, std::vector<std::uint16_t>& to) {
    to.insert(to.end(), from.begin(), from.end());
  };
  add(one.corrected, all->corrected);
  add(one.moved, all->moved);
  add(one.absent, all->absent);
}

}  // namespace

TrackerSet::TrackerSet(const sensor::Rig& rig, std::vector<std::unique_ptr<tracker::Tracker>> trackers)
    : member_of_(rig.sensors.size(), kNobodys), sources_(trackers.size()) {
  assert(trackers.size() <= shaping::Merge::kMostSources);
  members_.reserve(trackers.size());
  for (std::unique_ptr<tracker::Tracker>& tracker : trackers) {
    const std::string_view modality = tracker->modality();
    for (const std::uint16_t sensor : sensor::sensors_of(rig, modality))
      member_of_[sensor] = static_cast<std::uint8_t>(members_.size());
    const bool listens = modality == shaping::Merge::kListening;
    members_.push_back({std::move(tracker), {}, {}, {}, listens});
  }
  modality_ = fmt::format("{}", fmt::join(modalities(), "+"));
}

std::vector<std::string> TrackerSet::modalities() const {
  std::vector<std::string> names;
  for (const Member& member : members_) names.emplace_back(member.tracker->modality());
  return names;
}

const TrackerSet::Member* TrackerSet::member_with(std::uint16_t sensor) const {
  if (sensor >= member_of_.size() || member_of_[sensor] == kNobodys) return nullptr;
  return &members_[member_of_[sensor]];
}

void TrackerSet::add(HostTime arrival, const sensor::Sample& sample, std::span<const std::byte> payload) {
  newest_ = std::max(newest_, arrival);
  if (member_with(sample.sensor) == nullptr) return;
  Member& member = members_[member_of_[sample.sensor]];
  member.received = arrival;
  if (payload.empty())
    member.tracker->add(arrival, sample);
  else
    member.tracker->add_with_payload(arrival, sample, payload);
}

void TrackerSet::forget(std::uint16_t sensor) {
  for (Member& member : members_) member.tracker->forget(sensor);
  retiming_.reset();
}

void TrackerSet::change_view(std::uint16_t sensor, const sensor::PictureView& view) {
  for (Member& member : members_) member.tracker->change_view(sensor, view);
}

TrackerSet::Answer TrackerSet::tick(DeviceTime frame, const sensor::TimeLines& lines) {
  Answer all;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    Member& member = members_[i];
    tracker::TickResult one = tick(member, frame, lines);
    if (one.hearing) all.hearing = one.hearing;
    if (one.rested) append(*one.rested, all.rested);
    for (tracker::CalibrationEvent& event : one.calibration) all.calibration.push_back(std::move(event));
    member.explained = one.explained;
    sources_[i] = {.frame = &member.frame,
                   .sensors_present = one.sensors_present,
                   .explained = member.explained ? &*member.explained : nullptr};
  }
  if (std::exchange(half_restored_, false)) all.calibration.push_back({.modality = modality_});
  return all;
}

tracker::TickResult TrackerSet::tick(Member& member, DeviceTime frame, const sensor::TimeLines& lines) const {
  if (!member.listens) return member.tracker->tick(frame, lines, member.frame);
  tracker::TickResult result = member.tracker->tick(frame + retiming_.offset(), lines, member.frame);
  member.frame.time = frame;
  if (result.hearing) result.hearing->later = retiming_.offset();
  return result;
}

void TrackerSet::follow_lag(Duration behind, float sure) {
  constexpr std::size_t kJaw = face::shape("jawOpen");
  if (members_.size() < 2) return;
  std::optional<float> from_sound, sensed;
  bool listens = false;
  float most = sure;
  for (const Member& member : members_) {
    if (member.listens) {
      listens = true;
      if (member.frame.provenance[kJaw] == face::Provenance::audio) from_sound = member.frame.weights[kJaw];
    } else if (member.explained && (*member.explained)[kJaw] >= most &&
               member.frame.provenance[kJaw] != face::Provenance::neutral) {
      most = (*member.explained)[kJaw];
      sensed = member.frame.weights[kJaw];
    }
  }
  if (listens) retiming_.push(from_sound, sensed, behind);
}

const model::FeatureFrame* TrackerSet::features() const {
  for (const Member& member : members_)
    if (const model::FeatureFrame* const features = member.tracker->features()) return features;
  return nullptr;
}

bool TrackerSet::any_present() const {
  return std::ranges::any_of(
      members_, [this](const Member& m) { return m.received && newest_ - *m.received <= kAbsentAfter; });
}

bool TrackerSet::counts(const Member& member) const {
  return (member.received && newest_ - *member.received <= kAbsentAfter) || !any_present();
}

tracker::Guidance TrackerSet::guidance() const {
  tracker::Guidance all{.neutral = {}, .gestures = false};
  for (const Member& member : members_) {
    if (!counts(member)) continue;
    const tracker::Guidance one = member.tracker->guidance();
    all.neutral = std::max(all.neutral, one.neutral);
    all.gestures = all.gestures || one.gestures;
    all.learns_wearer = all.learns_wearer || one.learns_wearer;
    all.learns_gaze = all.learns_gaze || one.learns_gaze;
  }
  return all;
}

void TrackerSet::guide(tracker::Step step, DeviceTime begin, DeviceTime end) {
  for (Member& member : members_) member.tracker->guide(step, begin, end);
}

void TrackerSet::guide_range(DeviceTime begin, DeviceTime end) {
  for (Member& member : members_) member.tracker->guide_range(begin, end);
}

void TrackerSet::guide_expression(const tracker::PromptedExpression& asked) {
  for (Member& member : members_) member.tracker->guide_expression(asked);
}

void TrackerSet::guide_gaze(const face::GazeTarget& target, DeviceTime begin, DeviceTime end) {
  for (Member& member : members_) member.tracker->guide_gaze(target, begin, end);
}

void TrackerSet::cancel_guidance() {
  for (Member& member : members_) member.tracker->cancel_guidance();
}

Duration TrackerSet::wants_rest() const {
  Duration longest{};
  for (const Member& member : members_)
    if (counts(member)) longest = std::max(longest, member.tracker->wants_rest());
  return longest;
}

void TrackerSet::rest(DeviceTime begin, DeviceTime end) {
  for (Member& member : members_)
    if (counts(member) || end <= begin) member.tracker->rest(begin, end);
}

CalibrationState TrackerSet::calibration_state() const {
  using Phase = CalibrationState::Phase;
  CalibrationState all;
  bool guided = false, done = true;
  for (const Member& member : members_) {
    if (!counts(member)) continue;
    const CalibrationState one = member.tracker->calibration_state();
    guided = guided || one.phase == Phase::guided;
    done = done && one.phase == Phase::done;
    if (all.step == tracker::Step::none) all.step = one.step;
    if (all.hint.empty()) all.hint = one.hint;
  }
  all.phase = guided ? Phase::guided : done ? Phase::done : Phase::watching;
  return all;
}

std::string TrackerSet::calibration() const {
  if (members_.size() == 1) return members_.front().tracker->calibration();
  json all = json::object();
  for (const Member& member : members_) {
    const std::string one = member.tracker->calibration();
    if (one.empty()) continue;
    json parsed = json::parse(one, nullptr, false);
    assert(!parsed.is_discarded());
    all[std::string(member.tracker->modality())] = std::move(parsed);
  }
  return all.empty() ? std::string() : all.dump();
}

std::vector<sensor::Score> TrackerSet::scores() const {
  std::vector<sensor::Score> all;
  for (const Member& member : members_)
    for (sensor::Score& score : member.tracker->scores()) all.push_back(std::move(score));
  return all;
}

Result<void> TrackerSet::restore(std::string_view text) {
  if (members_.size() == 1) return members_.front().tracker->restore(text);
  const json all = json::parse(text, nullptr, false);
  if (!all.is_object() || all.empty())
    return fail(ErrorCode::malformed, "not the calibrations of several trackers", "calibration",
                "give one that was made with " + modality_);
  for (const auto& [name, one] : all.items())
    if (std::ranges::none_of(members_, [&](const Member& m) { return m.tracker->modality() == name; }))
      return fail(ErrorCode::mismatch, fmt::format("there is no tracker \"{}\" here", excerpt(name)),
                  "calibration", "give one that was made with " + modality_);
  std::vector<std::pair<tracker::Tracker*, std::string>> changed;
  for (Member& member : members_) {
    const auto found = all.find(std::string(member.tracker->modality()));
    if (found == all.end()) continue;
    std::string had = member.tracker->calibration();
    if (auto done = member.tracker->restore(found->dump()); !done) {
      bool undone = true;
      for (auto& [other, earlier] : changed) undone = !earlier.empty() && other->restore(earlier) && undone;
      // Part of the failed restore stays in force: reported as a calibration event.
      half_restored_ = !undone;
      return done;
    }
    changed.emplace_back(member.tracker.get(), std::move(had));
  }
  return {};
}

Result<void> TrackerSet::correct(const model::Correction& correction) {
  Result<void> done = fail(ErrorCode::unsupported, "nothing here is corrected for its wearer", "session",
                           "it takes sensors on the skin and a model such as models/live.safetensors");
  for (Member& member : members_) {
    done = member.tracker->correct(correction);
    if (done || done.error().code != ErrorCode::unsupported) break;
  }
  return done;
}

std::optional<double> TrackerSet::heading_sigma_rad(std::uint16_t sensor) const {
  const Member* const member = member_with(sensor);
  return member != nullptr ? member->tracker->heading_sigma_rad(sensor) : std::nullopt;
}

std::optional<tracker::SensorCertainty> TrackerSet::certainty(std::uint16_t sensor) const {
  const Member* const member = member_with(sensor);
  return member != nullptr ? member->tracker->certainty(sensor) : std::nullopt;
}

std::uint64_t TrackerSet::faults() const {
  std::uint64_t all = 0;
  for (const Member& member : members_) all += member.tracker->faults();
  return all;
}

}  // namespace mien::session
