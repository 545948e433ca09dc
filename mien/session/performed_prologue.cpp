#include "mien/session/performed_prologue.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "mien/session/prompt.h"

namespace mien::session {
namespace {

/// Of a calibration that a session made: its log has what led to it.
bool is_sessions_own(const take::Event& event) {
  const nlohmann::json details = nlohmann::json::parse(event.json, nullptr, false);
  return details.is_object() && (details.contains("found") || details.contains("guided"));
}

}  // namespace

std::optional<Calibrate> performed_prologue(std::span<const take::Event> events) {
  Calibrate command;
  bool rests = false;
  for (const take::Event& event : events) {
    const Calibrate::GivenStep given{.step = tracker::step_named(event.kind),
                                     .range = event.kind == "range",
                                     .look = event.kind == "gaze" ? gaze_event_target(event.json) : nullptr,
                                     .begin = event.begin,
                                     .end = event.end};
    if (given.step != tracker::Step::none && is_sessions_own(event)) return std::nullopt;
    const bool is_step = given.step != tracker::Step::none || given.range || given.look != nullptr;
    if (!is_step || event.end <= event.begin) continue;
    command.steps.push_back(given);
    rests = rests || given.step == tracker::Step::neutral;
  }
  if (!rests) return std::nullopt;
  std::ranges::sort(command.steps, {},
                    [](const Calibrate::GivenStep& given) { return std::pair(given.begin, given.end); });
  if (command.steps.size() > Calibrate::kMostSteps) command.steps.resize(Calibrate::kMostSteps);
  return command;
}

std::int64_t begin_log(std::span<const take::Event> events, HostTime arrival, take::TakeWriter& writer) {
  const std::optional<Calibrate> prologue = performed_prologue(events);
  if (!prologue) return 0;
  const std::string command = write_command(*prologue);
  writer.add_entry(arrival, kPageSource, std::as_bytes(std::span(command)));
  return 1;
}

}  // namespace mien::session
