#include "mien/session/recorded_lines.h"

#include <algorithm>
#include <map>
#include <string_view>

#include "mien/session/json_fields.h"

namespace mien::session {
namespace {

using nlohmann::json;

/// None where the details cannot be read, name nothing, or are a pose of a calibration or for oneself.
std::optional<RecordedLine> line_of(const take::Event& event) {
  const json details = json::parse(event.json, nullptr, false);
  if (!details.is_object()) return std::nullopt;
  RecordedLine line{.begin = event.begin,
                    .end = event.end,
                    .name = text_field(details, "name"),
                    .text = text_field(details, "text"),
                    .block = text_field(details, "block"),
                    .emotion = text_field(details, "emotion"),
                    .language = text_field(details, "language")};
  if (line.name.empty() || line.block.empty()) return std::nullopt;
  if (const auto target = details.find("target"); target != details.end() && target->is_object()) {
    line.has_target = true;
    for (const auto& [name, weight] : target->items())
      if (const std::size_t shape = face::shape_index(name); shape < face::kShapeCount && weight.is_number())
        line.target[shape] = std::clamp(weight.get<float>(), 0.0F, 1.0F);
  }
  if (const auto attempt = details.find("attempt"); attempt != details.end() && attempt->is_number_integer())
    line.attempt = static_cast<int>(std::clamp<std::int64_t>(attempt->get<std::int64_t>(), 1, 1000));
  if (const auto poor = details.find("poor"); poor != details.end() && poor->is_array())
    for (const json& sentence : *poor)
      if (sentence.is_string()) line.poor.push_back(sentence.get<std::string>());
  return line;
}

}  // namespace

std::optional<RecordedPart> recorded_part(std::span<const take::Event> events) {
  std::optional<RecordedPart> part;
  for (const take::Event& event : events)
    if (event.kind == "consent")
      if (std::optional<Consent> consent = consent_of(event.json))
        part = RecordedPart{*std::move(consent), event.begin, {}, {}};
  if (!part) return part;
  for (const take::Event& event : events)
    if (event.kind == "consent_over" && event.begin >= part->begin && !part->end) part->end = event.begin;
  for (const take::Event& event : events)
    if (event.kind == "prompt" && event.begin >= part->begin && (!part->end || event.begin < *part->end))
      if (std::optional<RecordedLine> line = line_of(event)) part->lines.push_back(*std::move(line));
  return part;
}

std::vector<const RecordedLine*> lines_that_count(const RecordedPart& part) {
  std::vector<const RecordedLine*> counting;
  std::map<std::string_view, std::size_t> places;
  for (const RecordedLine& line : part.lines) {
    const auto [place, first] = places.try_emplace(line.name, counting.size());
    if (first)
      counting.push_back(&line);
    else if (line.poor.empty() || !counting[place->second]->poor.empty())
      counting[place->second] = &line;
  }
  return counting;
}

}  // namespace mien::session
