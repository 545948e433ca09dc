#include "mien/shaping/combined_tracker.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <nlohmann/json.hpp>
#include <utility>

#include "mien/core/excerpt.h"

namespace mien::shaping {
namespace {

using nlohmann::json;
using tracker::CalibrationState;

constexpr std::uint8_t kNobodys = 0xFF;
/// A tracker without a sample from any of its sensors for this long counts as absent.
constexpr Duration kAbsentAfter = std::chrono::seconds(2);

std::vector<std::string> modalities_of(const std::vector<CombinedTracker::Part>& parts) {
  std::vector<std::string> names;
  for (const CombinedTracker::Part& part : parts) names.emplace_back(part.tracker->modality());
  return names;
}

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

CombinedTracker::CombinedTracker(std::vector<Part> parts, const ShaperSettings& settings)
    : modality_(fmt::format("{}", fmt::join(modalities_of(parts), "+"))),
      merge_(modalities_of(parts), settings.merge, settings.fallback),
      sure_(settings.merge.sure),
      sources_(parts.size()) {
  members_.reserve(parts.size());
  for (Part& part : parts) {
    for (const std::uint16_t sensor : part.sensors) {
      if (sensor >= member_of_.size()) member_of_.resize(sensor + std::size_t{1}, kNobodys);
      assert(member_of_[sensor] == kNobodys);
      member_of_[sensor] = static_cast<std::uint8_t>(members_.size());
    }
    const bool listens = part.tracker->modality() == Merge::kListening;
    members_.push_back({std::move(part.tracker), std::move(part.sensors), {}, {}, {}, listens});
  }
  set(settings);
}

CombinedTracker::Member* CombinedTracker::received(HostTime arrival, const sensor::Sample& sample) {
  newest_ = std::max(newest_, arrival);
  if (sample.sensor >= member_of_.size() || member_of_[sample.sensor] == kNobodys) return nullptr;
  Member& member = members_[member_of_[sample.sensor]];
  member.received = arrival;
  return &member;
}

void CombinedTracker::add(HostTime arrival, const sensor::Sample& sample) {
  if (Member* const member = received(arrival, sample)) member->tracker->add(arrival, sample);
}

void CombinedTracker::add_with_payload(HostTime arrival, const sensor::Sample& sample,
                                       std::span<const std::byte> payload) {
  if (Member* const member = received(arrival, sample))
    member->tracker->add_with_payload(arrival, sample, payload);
}

void CombinedTracker::forget(std::uint16_t sensor) {
  for (Member& member : members_) member.tracker->forget(sensor);
  retiming_.reset();
}

void CombinedTracker::change_view(std::uint16_t sensor, const sensor::PictureView& view) {
  for (Member& member : members_) member.tracker->change_view(sensor, view);
}

tracker::TickResult CombinedTracker::tick(DeviceTime frame, const sensor::TimeLines& lines,
                                          face::OutputFrame& out) {
  tracker::TickResult all;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    tracker::TickResult one = tick(members_[i], frame, lines);
    if (one.hearing) all.hearing = one.hearing;
    if (one.rested) append(*one.rested, all.rested);
    for (tracker::CalibrationEvent& event : one.calibration) all.calibration.push_back(std::move(event));
    sources_[i].sensors_present = one.sensors_present;
    sources_[i].frame = &members_[i].frame;
    members_[i].explained = one.explained;
    sources_[i].explained = members_[i].explained ? &*members_[i].explained : nullptr;
  }
  if (std::exchange(half_restored_, false)) all.calibration.push_back({.modality = modality_});
  all.sensors_present = merge_.apply(sources_, out);
  follow_lag(all.hearing ? all.hearing->behind : Duration::zero());
  return all;
}

tracker::TickResult CombinedTracker::tick(Member& member, DeviceTime frame,
                                          const sensor::TimeLines& lines) const {
  if (!member.listens) return member.tracker->tick(frame, lines, member.frame);
  tracker::TickResult result = member.tracker->tick(frame + retiming_.offset(), lines, member.frame);
  member.frame.time = frame;
  if (result.hearing) result.hearing->later = retiming_.offset();
  return result;
}

void CombinedTracker::follow_lag(Duration behind) {
  constexpr std::size_t kJaw = face::shape("jawOpen");
  std::optional<float> heard, sensed;
  bool listens = false;
  float most = sure_;
  for (const Member& member : members_) {
    if (member.listens) {
      listens = true;
      if (member.frame.provenance[kJaw] == face::Provenance::audio) heard = member.frame.weights[kJaw];
    } else if (member.explained && (*member.explained)[kJaw] >= most &&
               member.frame.provenance[kJaw] != face::Provenance::neutral) {
      most = (*member.explained)[kJaw];
      sensed = member.frame.weights[kJaw];
    }
  }
  if (listens) retiming_.push(heard, sensed, behind);
}

bool CombinedTracker::any_present() const {
  return std::ranges::any_of(
      members_, [this](const Member& m) { return m.received && newest_ - *m.received <= kAbsentAfter; });
}

bool CombinedTracker::counts(const Member& member) const {
  return (member.received && newest_ - *member.received <= kAbsentAfter) || !any_present();
}

tracker::Guidance CombinedTracker::guidance() const {
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

void CombinedTracker::guide(tracker::Step step, DeviceTime begin, DeviceTime end) {
  for (Member& member : members_) member.tracker->guide(step, begin, end);
}

void CombinedTracker::guide_range(DeviceTime begin, DeviceTime end) {
  for (Member& member : members_) member.tracker->guide_range(begin, end);
}

void CombinedTracker::guide_expression(const tracker::PromptedExpression& asked) {
  for (Member& member : members_) member.tracker->guide_expression(asked);
}

void CombinedTracker::guide_gaze(const face::GazeTarget& target, DeviceTime begin, DeviceTime end) {
  for (Member& member : members_) member.tracker->guide_gaze(target, begin, end);
}

void CombinedTracker::cancel_guidance() {
  for (Member& member : members_) member.tracker->cancel_guidance();
}

Duration CombinedTracker::wants_rest() const {
  Duration longest{};
  for (const Member& member : members_)
    if (counts(member)) longest = std::max(longest, member.tracker->wants_rest());
  return longest;
}

void CombinedTracker::rest(DeviceTime begin, DeviceTime end) {
  for (Member& member : members_)
    if (counts(member) || end <= begin) member.tracker->rest(begin, end);
}

CalibrationState CombinedTracker::calibration_state() const {
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

std::string CombinedTracker::calibration() const {
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

std::vector<sensor::Score> CombinedTracker::scores() const {
  std::vector<sensor::Score> all;
  for (const Member& member : members_)
    for (sensor::Score& score : member.tracker->scores()) all.push_back(std::move(score));
  return all;
}

Result<void> CombinedTracker::restore(std::string_view text) {
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

Result<void> CombinedTracker::correct(const model::Correction& correction) {
  for (Member& member : members_) {
    const auto done = member.tracker->correct(correction);
    if (done || done.error().code != ErrorCode::unsupported) return done;
  }
  return Tracker::correct(correction);
}

std::optional<double> CombinedTracker::heading_sigma_rad(std::uint16_t sensor) const {
  if (sensor >= member_of_.size() || member_of_[sensor] == kNobodys) return std::nullopt;
  return members_[member_of_[sensor]].tracker->heading_sigma_rad(sensor);
}

std::optional<tracker::SensorCertainty> CombinedTracker::certainty(std::uint16_t sensor) const {
  if (sensor >= member_of_.size() || member_of_[sensor] == kNobodys) return std::nullopt;
  return members_[member_of_[sensor]].tracker->certainty(sensor);
}

std::uint64_t CombinedTracker::faults() const {
  std::uint64_t all = 0;
  for (const Member& member : members_) all += member.tracker->faults();
  return all;
}

}  // namespace mien::shaping
