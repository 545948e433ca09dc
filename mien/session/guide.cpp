#include "mien/session/guide.h"

#include <fmt/format.h>

#include <algorithm>

#include "mien/face/anchors.h"

namespace mien::session {
namespace {

using tracker::Step;

// The performer reads first.
constexpr Duration kLeadIn = std::chrono::milliseconds(1500);
constexpr Duration kGesture = std::chrono::milliseconds(4500);
constexpr Duration kAnchor = std::chrono::milliseconds(2400);
constexpr Duration kRange = std::chrono::milliseconds(2000);
constexpr Duration kLook = std::chrono::milliseconds(2700);
/// Of it. A saccade begins a quarter of a second after what calls for it was understood; the rest is reading.
constexpr Duration kReaction = std::chrono::milliseconds(900);
constexpr Duration kLearning = tracker::kWearerLearnt + tracker::kWearerShown;
/// An anchor of which less than this share came through was not done, or is not felt.
constexpr double kMinResponse = 0.25;

}  // namespace

DeviceTime Guide::Part::looks_from() const {
  return begin + kReaction;
}

void Guide::begin(const Calibrate& command) {
  *this = {};
  state_ = State::wanted;
  command_ = command;
}

void Guide::plan(DeviceTime begin, const tracker::Guidance& wanted) {
  DeviceTime at = begin + kLeadIn;
  const auto add = [&](Step step, std::string_view name, std::string_view prompt, Duration length,
                       const face::BlendshapeWeights* target) {
    parts_.push_back(
        {.step = step, .name = name, .prompt = prompt, .target = target, .begin = at, .end = at + length});
    at += length;
  };
  add(Step::neutral, "neutral", "Look ahead, relax your face and hold still", wanted.neutral, nullptr);
  if (wanted.gestures) {
    add(Step::nod, "nod", "Keep your face still and nod twice, down first", kGesture, nullptr);
    add(Step::shake, "shake", "Keep your face still and shake your head twice", kGesture, nullptr);
  }
  if (command_.kind == Calibrate::Kind::gaze)
    for (const face::GazeTarget& look : face::gaze_targets()) {
      add(Step::none, look.name, look.prompt, kLook, nullptr);
      parts_.back().look = &look;
    }
  if (command_.kind == Calibrate::Kind::full || command_.kind == Calibrate::Kind::wearer)
    for (const face::Anchor& anchor : face::anchors()) {
      add(Step::none, anchor.name, anchor.prompt, kAnchor, &anchor.target);
      parts_.back().scored = true;
    }
  if (command_.kind == Calibrate::Kind::wearer) {
    for (const face::Anchor& asked : face::range_of_motion())
      add(Step::none, asked.name, asked.prompt, kRange, &asked.target);
    add(Step::none, "learning", "Relax: how your skin turns is being learnt", kLearning, nullptr);
  }
}

void Guide::plan_given() {
  for (const Calibrate::GivenStep& given : command_.steps)
    parts_.push_back({.step = given.step,
                      .name = given.look != nullptr ? given.look->name
                              : given.range         ? "range"
                                                    : step_name(given.step),
                      .look = given.look,
                      .range = given.range,
                      .begin = given.look != nullptr ? given.begin - kReaction : given.begin,
                      .end = given.end});
}

void Guide::before(DeviceTime frame, TrackerSet& trackers) {
  if (state_ != State::wanted) return;
  if (command_.steps.empty())
    plan(frame, trackers.guidance());
  else
    plan_given();
  response_.assign(parts_.size(), 0.0F);
  for (const Part& part : parts_) {
    if (part.step != Step::none) trackers.guide(part.step, part.begin, part.end);
    if (part.look != nullptr) trackers.guide_gaze(*part.look, part.looks_from(), part.end);
    if (part.range) trackers.guide_range(part.begin, part.end);
  }
  const auto asked = [](const Part& part) { return part.target != nullptr; };
  const auto first = std::ranges::find_if(parts_, asked);
  if (first != parts_.end()) {
    const auto last = std::find_if(parts_.rbegin(), parts_.rend(), asked);
    trackers.guide_range(first->begin, last->end);
  }
  if (command_.kind == Calibrate::Kind::wearer)
    for (const Part& part : parts_)
      if (asked(part))
        trackers.guide_expression({.name = std::string(part.name),
                                   .begin = part.begin,
                                   .end = part.end,
                                   .held = true,
                                   .target = *part.target});
  state_ = State::running;
}

bool Guide::after(const face::OutputFrame& frame) {
  if (state_ != State::running) return false;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const Part& part = parts_[i];
    if (!part.scored || frame.time < part.begin || frame.time >= part.end) continue;
    float sum = 0, asked = 0;
    for (std::size_t k = 0; k < face::kShapeCount; ++k) {
      sum += std::min(frame.weights[k], (*part.target)[k]);
      asked += (*part.target)[k];
    }
    response_[i] = std::max(response_[i], sum / asked);
  }
  if (frame.time < std::ranges::max_element(parts_, {}, &Part::end)->end) return false;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    if (!parts_[i].scored) continue;
    const bool seen = response_[i] >= kMinResponse;
    scores_.push_back({.name = fmt::format("anchor {}", parts_[i].name),
                       .value = response_[i],
                       .unit = "",
                       .pass = seen,
                       .sentence = seen ? "the sensors saw this expression"
                                        : "little of this expression was seen; do it more strongly, or check "
                                          "the sensors near it"});
  }
  state_ = State::idle;
  return true;
}

bool Guide::steps_over(DeviceTime frame) const {
  return state_ == State::running && std::ranges::none_of(parts_, [&](const Part& part) {
           return part.step != Step::none && frame < part.end;
         });
}

Guide::Place Guide::place(DeviceTime frame) const {
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const Part& part = parts_[i];
    if (frame >= part.end) continue;
    const double share = to_seconds(frame - part.begin) / to_seconds(part.end - part.begin);
    return {&part, i + 1, std::clamp(share, 0.0, 1.0), part.end - frame};
  }
  return {};
}

}  // namespace mien::session
