#include "mien/session/prompt.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "mien/core/units.h"

namespace mien::session {
namespace {

constexpr std::size_t kMaxName = 60;
constexpr std::size_t kMaxSentence = 200;
constexpr double kShortest_s = 0.5;
constexpr double kLongest_s = 600;

bool printable(std::string_view text) {
  return std::ranges::all_of(text, [](unsigned char c) { return c >= 0x20 && c < 0x7F; });
}

}  // namespace

Result<void> check_prompt(const Prompt& prompt, const std::string& where) {
  if (prompt.name.empty() || prompt.name.size() > kMaxName || !printable(prompt.name))
    return fail(ErrorCode::out_of_range,
                fmt::format("the pose's name is empty, not plain ASCII or longer than {} letters", kMaxName),
                where, "give it a short name");
  if (prompt.say.size() > kMaxSentence || !printable(prompt.say))
    return fail(ErrorCode::out_of_range,
                fmt::format("what pose \"{}\" says is not plain ASCII or longer than {} letters", prompt.name,
                            kMaxSentence),
                where, "say it shorter");
  if (!(prompt.seconds >= kShortest_s && prompt.seconds <= kLongest_s))
    return fail(ErrorCode::out_of_range, fmt::format("pose \"{}\" lasts {:g} s", prompt.name, prompt.seconds),
                where, fmt::format("give it {:g} to {:g} s", kShortest_s, kLongest_s));
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    if (!(prompt.target[k] >= 0 && prompt.target[k] <= 1))
      return fail(
          ErrorCode::out_of_range,
          fmt::format("pose \"{}\" has {} = {:g}", prompt.name, face::kShapeNames[k], prompt.target[k]),
          where, "weights go from 0 to 1");
  return {};
}

std::string target_json(const face::BlendshapeWeights& target) {
  std::string out;
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    if (target[k] != 0)
      out += fmt::format("{}\"{}\": {}", out.empty() ? "" : ", ", face::kShapeNames[k], target[k]);
  return "{" + out + "}";
}

std::string prompt_event_json(const Prompt& prompt) {
  return fmt::format(R"({{"name": {}, "target": {}}})", nlohmann::json(prompt.name).dump(),
                     target_json(prompt.target));
}

std::string gaze_event_json(const face::GazeTarget& target) {
  return fmt::format(R"({{"name": "{}", "yaw_deg": {:.1f}, "pitch_deg": {:.1f}}})", target.name,
                     kDegPerRad * double{target.direction_rad.x()},
                     kDegPerRad * double{target.direction_rad.y()});
}

const face::GazeTarget* gaze_event_target(std::string_view json) {
  const nlohmann::json event = nlohmann::json::parse(json, nullptr, false);
  if (!event.is_object() || !event.contains("name") || !event["name"].is_string()) return nullptr;
  const auto targets = face::gaze_targets();
  const auto found =
      std::ranges::find(targets, event["name"].get_ref<const std::string&>(), &face::GazeTarget::name);
  return found == targets.end() ? nullptr : &*found;
}

}  // namespace mien::session
