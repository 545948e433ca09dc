#include "mien/virtual/prologue_record.h"

#include <fmt/format.h>

#include <utility>

#include "mien/session/prompt.h"

namespace mien::virt {

std::vector<take::Event> prologue_events(const performer::PrologueTimes& times,
                                         const VirtualClock& reference) {
  std::vector<take::Event> events;
  const auto add = [&](const char* kind, double begin_s, double end_s, std::string json = {}) {
    if (end_s > begin_s)
      events.push_back({kind, reference.device(begin_s), reference.device(end_s), std::move(json)});
  };
  add("neutral", times.neutral.begin_s, times.neutral.end_s);
  add("nod", times.nod.begin_s, times.nod.end_s);
  add("shake", times.shake.begin_s, times.shake.end_s);
  if (!times.prompts.empty()) add("range", times.prompts.front().begin_s, times.range_of_motion.end_s);
  for (const performer::Prompt& prompt : times.prompts) {
    std::string target;
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      if (prompt.target[k] != 0)
        target +=
            fmt::format("{}\"{}\": {}", target.empty() ? "" : ", ", face::kShapeNames[k], prompt.target[k]);
    add("prompt", prompt.begin_s, prompt.end_s,
        fmt::format(R"({{"name": "{}", "anchor": {}, "rise_s": {}, "target": {{{}}}}})", prompt.name,
                    prompt.anchor, prompt.rise_s, target));
  }
  // As a session asks for them (session::Guide): the eyes have turned there.
  constexpr double kTurns_s = 0.9;
  double looks_s = times.gaze.begin_s;
  for (const face::GazeTarget& target : face::gaze_targets()) {
    const double end_s = looks_s + performer::kGazeTarget_s;
    if (times.gaze.end_s > times.gaze.begin_s)
      add("gaze", looks_s + kTurns_s, end_s, session::gaze_event_json(target));
    looks_s = end_s;
  }
  add("ease", times.ease.begin_s, times.ease.end_s);
  return events;
}

take::TruthFrame truth_of(const face::MotionFrame& moment, double true_s, double motion_start_s,
                          double duration_s, DeviceTime frame) {
  take::TruthFrame truth;
  truth.time = frame;
  truth.weights = moment.weights;
  truth.tongue_out = moment.tongue_out;
  truth.has_face = moment.has_face;
  truth.evaluated = true_s >= motion_start_s - kSameMomentS && true_s <= duration_s + kSameMomentS;
  return truth;
}

}  // namespace mien::virt
