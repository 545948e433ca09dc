#include "mien/solve/prompted.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "mien/solve/solve.h"
#include "mien/solve/trace_features.h"

namespace mien::solve {
namespace {

using Json = nlohmann::json;

/// Of a prompt that is shown until its end, and says nothing of how quickly it is to be reached.
constexpr double kUsualRise_s = 0.4;

std::optional<tracker::PromptedExpression> parse_prompt(const take::Event& event) {
  const Json details = Json::parse(event.json, nullptr, false);
  if (!details.is_object() || !details.contains("target") || !details["target"].is_object())
    return std::nullopt;
  tracker::PromptedExpression prompt{.name = {}, .begin = event.begin, .end = event.end, .target = {}};
  if (const auto name = details.find("name"); name != details.end() && name->is_string())
    prompt.name = name->get<std::string>();
  const auto rise = details.find("rise_s");
  prompt.held = rise == details.end() || !rise->is_number();
  prompt.rise_s = prompt.held ? kUsualRise_s : rise->get<double>();
  if (!(prompt.rise_s > 0 && prompt.rise_s < to_seconds(event.end - event.begin))) return std::nullopt;
  bool any = false;
  for (const auto& [name, weight] : details["target"].items()) {
    const auto shape = std::ranges::find(face::kShapeNames, name);
    if (shape == face::kShapeNames.end() || !weight.is_number()) continue;
    const double asked = std::clamp(weight.get<double>(), 0.0, 1.0);
    prompt.target[static_cast<std::size_t>(shape - face::kShapeNames.begin())] = static_cast<float>(asked);
    any = any || asked > 0;
  }
  if (!any) return std::nullopt;
  return prompt;
}

}  // namespace

std::vector<tracker::PromptedExpression> prompted_expressions(std::span<const take::Event> events) {
  std::vector<tracker::PromptedExpression> prompts;
  for (const take::Event& event : events)
    if (event.kind == "prompt")
      if (auto prompt = parse_prompt(event)) prompts.push_back(*std::move(prompt));
  return prompts;
}

Result<std::optional<DeviceTime>> first_evaluated(const take::Take& take) {
  MIEN_TRY_ASSIGN(const std::vector<take::TruthFrame> truth, take.truth());
  const auto first = std::ranges::find_if(truth, &take::TruthFrame::evaluated);
  return first == truth.end() ? std::nullopt : std::optional(first->time);
}

Result<tracker::Personalisation> personalise_on(const take::Take& take,
                                                std::span<const model::FeatureFrame> features,
                                                model::ModelFile& file, std::optional<DeviceTime> until) {
  MIEN_TRY_ASSIGN(const std::vector<take::Event> events, take.events());
  std::vector<tracker::PromptedExpression> prompts = prompted_expressions(events);
  if (until) {
    const auto beyond = std::ranges::lower_bound(features, *until, {}, &model::FeatureFrame::time);
    features = features.first(static_cast<std::size_t>(beyond - features.begin()));
    std::erase_if(prompts, [&](const tracker::PromptedExpression& prompt) { return prompt.end > *until; });
  }
  return tracker::personalise(features, prompts, traced_sensor_names(take.rig()), file);
}

}  // namespace mien::solve
