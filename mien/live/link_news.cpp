#include "mien/live/link_news.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <utility>

namespace mien::live {
namespace {

/// So many sensors at once are said in one sentence.
constexpr std::size_t kMany = 3;

std::string sensor_of(const take::Event& event) {
  const auto details = nlohmann::json::parse(event.json, nullptr, false);
  return details.is_object() ? details.value("sensor", std::string()) : std::string();
}

}  // namespace

bool LinkNews::is_about_a_link(const take::Event& event) {
  return event.kind == "sensor_lost" || event.kind == "sensor_back";
}

std::vector<LinkNews::Sentence> LinkNews::tell(HostTime now, std::span<const take::Event> events) {
  std::vector<std::string> lost, back;
  for (const take::Event& event : events) {
    if (!is_about_a_link(event)) continue;
    const std::string name = sensor_of(event);
    Sensor& sensor = sensors_[name];
    sensor.lost = event.kind == "sensor_lost";
    std::optional<HostTime>& said = sensor.lost ? sensor.said_lost : sensor.said_back;
    if (!sensor.held_back_since && (!said || now - *said >= kQuiet)) {
      said = now;
      (sensor.lost ? lost : back).push_back(name);
    } else {
      if (!sensor.held_back_since) sensor.held_back_since = now;
      sensor.losses += sensor.lost ? 1 : 0;
    }
  }
  std::vector<Sentence> out;
  const auto add = [&out](const char* kind, const std::vector<std::string>& names, const char* word) {
    if (names.size() >= kMany)
      out.push_back({kind, fmt::format("{} sensors are {}", names.size(), word)});
    else
      for (const std::string& name : names) out.push_back({kind, fmt::format("{} is {}", name, word)});
  };
  add("sensor_lost", lost, "lost");
  add("sensor_back", back, "back");

  // What was held back, when its time is over.
  for (auto& [name, sensor] : sensors_) {
    if (!sensor.held_back_since || now - *sensor.held_back_since < kQuiet) continue;
    out.push_back({sensor.lost ? "sensor_lost" : "sensor_back",
                   fmt::format("{} was lost {} more time{} in {} s and is {} now", name, sensor.losses,
                               sensor.losses == 1 ? "" : "s",
                               static_cast<int>(to_seconds(now - *sensor.held_back_since)),
                               sensor.lost ? "lost" : "back")});
    // Its return, when it is gone now, is news.
    sensor.said_lost = now;
    sensor.said_back = sensor.lost ? std::nullopt : std::optional(now);
    sensor.held_back_since.reset();
    sensor.losses = 0;
  }
  return out;
}

}  // namespace mien::live
