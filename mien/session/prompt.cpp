#include "mien/session/prompt.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <vector>

#include "mien/core/ascii.h"
#include "mien/core/units.h"
#include "mien/core/utf8.h"

namespace mien::session {
namespace {

constexpr std::size_t kMaxName = 60;
constexpr std::size_t kMaxSentence = 200;
constexpr std::size_t kMaxText = 2000;
constexpr std::size_t kMaxLabel = 40;
constexpr std::size_t kMaxLanguage = 35;
constexpr double kShortest_s = 0.5;
constexpr double kLongest_s = 600;

bool printable(std::string_view text) {
  return std::ranges::all_of(text, [](unsigned char c) { return c >= 0x20 && c < 0x7F; });
}

bool readable(std::string_view text) {
  return is_utf8(text) && !has_control(text);
}

Result<void> check_labels(const Prompt& prompt, const std::string& where) {
  const auto wrong = [&](std::string_view what, std::size_t most) {
    return fail(
        ErrorCode::out_of_range,
        fmt::format("{} of \"{}\" is not plain ASCII or longer than {} letters", what, prompt.name, most),
        where, "write it shorter, as \"calm\", \"joy\" or \"en\"");
  };
  if (prompt.block.size() > kMaxLabel || !printable(prompt.block)) return wrong("the block", kMaxLabel);
  if (prompt.emotion.size() > kMaxLabel || !printable(prompt.emotion)) return wrong("the emotion", kMaxLabel);
  if (prompt.language.size() > kMaxLanguage || !printable(prompt.language))
    return wrong("the language", kMaxLanguage);
  if (prompt.attempt < 1 || prompt.attempt > kMaxAttempts)
    return fail(ErrorCode::out_of_range, fmt::format("attempt {} of \"{}\"", prompt.attempt, prompt.name),
                where, fmt::format("1 to {}", kMaxAttempts));
  return {};
}

}  // namespace

Result<void> check_prompt(const Prompt& prompt, const std::string& where) {
  if (prompt.name.empty() || prompt.name.size() > kMaxName || !printable(prompt.name))
    return fail(ErrorCode::out_of_range,
                fmt::format("the pose's name is empty, not plain ASCII or longer than {} letters", kMaxName),
                where, "give it a short name");
  if (prompt.say.size() > kMaxSentence || !readable(prompt.say))
    return fail(ErrorCode::out_of_range,
                fmt::format("what \"{}\" says is not one line of UTF-8 of at most {} bytes", prompt.name,
                            kMaxSentence),
                where, "say it shorter");
  if (prompt.text.size() > kMaxText || !readable(prompt.text))
    return fail(
        ErrorCode::out_of_range,
        fmt::format("the text of \"{}\" is not one line of UTF-8 of at most {} bytes", prompt.name, kMaxText),
        where, "make two of it, and save the file as UTF-8");
  if (!(prompt.seconds >= kShortest_s && prompt.seconds <= kLongest_s))
    return fail(ErrorCode::out_of_range, fmt::format("pose \"{}\" lasts {:g} s", prompt.name, prompt.seconds),
                where, fmt::format("give it {:g} to {:g} s", kShortest_s, kLongest_s));
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    if (!(prompt.target[k] >= 0 && prompt.target[k] <= 1))
      return fail(
          ErrorCode::out_of_range,
          fmt::format("pose \"{}\" has {} = {:g}", prompt.name, face::kShapeNames[k], prompt.target[k]),
          where, "weights go from 0 to 1");
  return check_labels(prompt, where);
}

std::string target_json(const face::BlendshapeWeights& target) {
  std::string out;
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    if (target[k] != 0)
      out += fmt::format("{}\"{}\": {}", out.empty() ? "" : ", ", face::kShapeNames[k], target[k]);
  return "{" + out + "}";
}

std::string prompt_event_json(const Prompt& prompt, std::span<const std::string> poor) {
  const std::string target = target_json(prompt.target);
  std::string out = fmt::format(R"({{"name": {})", nlohmann::json(prompt.name).dump());
  if (prompt.text.empty() || target != "{}") out += fmt::format(R"(, "target": {})", target);
  const auto add = [&out](std::string_view key, const std::string& text) {
    if (!text.empty()) out += fmt::format(R"(, "{}": {})", key, nlohmann::json(text).dump());
  };
  add("text", prompt.text);
  add("block", prompt.block);
  add("emotion", prompt.emotion);
  add("language", prompt.language);
  if (prompt.attempt > 1) out += fmt::format(R"(, "attempt": {})", prompt.attempt);
  if (!poor.empty())
    out += fmt::format(R"(, "poor": {})", nlohmann::json(std::vector(poor.begin(), poor.end())).dump());
  return out + "}";
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
