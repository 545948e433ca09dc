#include "mien/live/link_news.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace mien::live {
namespace {

/// So many sensors at once are said in one sentence.
constexpr std::size_t kMany = 3;

std::string sensor_of(const take::Event& event) {
  const auto details = nlohmann::json::parse(event.json, nullptr, false);
  return details.is_object() ? details.value("sensor", std::string()) : std::string();
}

/// What ends with a return, in words.
struct Trouble {
  std::string_view begins, ends;            // Kinds of events.
  std::string_view one_has, one_had;        // "mentalis ...".
  std::string_view many_have, many_had;     // "3 sensors ...".
  std::string_view came, now_has, now_had;  // "mentalis ... 3 more times in 10 s and ...".

  [[nodiscard]] bool tells(const take::Event& event) const {
    return event.kind == begins || event.kind == ends;
  }
};
constexpr std::array kTroubles = {Trouble{.begins = "sensor_lost",
                                          .ends = "sensor_back",
                                          .one_has = "is lost",
                                          .one_had = "is back",
                                          .many_have = "are lost",
                                          .many_had = "are back",
                                          .came = "was lost",
                                          .now_has = "is lost now",
                                          .now_had = "is back now"},
                                  Trouble{.begins = "face_lost",
                                          .ends = "face_back",
                                          .one_has = "sees no face",
                                          .one_had = "sees the face again",
                                          .many_have = "see no face",
                                          .many_had = "see the face again",
                                          .came = "lost the face",
                                          .now_has = "sees none now",
                                          .now_had = "sees it now"}};

}  // namespace

bool LinkNews::is_about_a_link(const take::Event& event) {
  return std::ranges::any_of(kTroubles, [&event](const Trouble& trouble) { return trouble.tells(event); });
}

std::string LinkNews::loss_text(std::string_view sensor) {
  return fmt::format("{} {}", sensor, kTroubles.front().one_has);
}

std::vector<Sentence> LinkNews::tell(HostTime now, std::span<const take::Event> events) {
  std::vector<Sentence> out;
  const auto add = [&out](std::string_view kind, const std::vector<std::string>& names, std::string_view one,
                          std::string_view many) {
    if (names.size() >= kMany)
      out.push_back({std::string(kind), fmt::format("{} sensors {}", names.size(), many)});
    else
      for (const std::string& name : names)
        out.push_back({std::string(kind), fmt::format("{} {}", name, one)});
  };
  for (std::size_t i = 0; i < kTroubles.size(); ++i) {
    const Trouble& trouble = kTroubles[i];
    std::vector<std::string> lost, back;
    for (const take::Event& event : events) {
      if (!trouble.tells(event)) continue;
      const std::string name = sensor_of(event);
      Sensor& sensor = sensors_[i][name];
      sensor.lost = event.kind == trouble.begins;
      std::optional<HostTime>& said = sensor.lost ? sensor.said_lost : sensor.said_back;
      if (!sensor.held_back_since && (!said || now - *said >= kQuiet)) {
        said = now;
        (sensor.lost ? lost : back).push_back(name);
      } else {
        if (!sensor.held_back_since) sensor.held_back_since = now;
        sensor.losses += sensor.lost ? 1 : 0;
      }
    }
    add(trouble.begins, lost, trouble.one_has, trouble.many_have);
    add(trouble.ends, back, trouble.one_had, trouble.many_had);

    // What was held back, when its time is over.
    for (auto& [name, sensor] : sensors_[i]) {
      if (!sensor.held_back_since || now - *sensor.held_back_since < kQuiet) continue;
      out.push_back({std::string(sensor.lost ? trouble.begins : trouble.ends),
                     fmt::format("{} {} {} more time{} in {} s and {}", name, trouble.came, sensor.losses,
                                 sensor.losses == 1 ? "" : "s",
                                 static_cast<int>(to_seconds(now - *sensor.held_back_since)),
                                 sensor.lost ? trouble.now_has : trouble.now_had)});
      // Its return, when it is gone now, is news.
      sensor.said_lost = now;
      sensor.said_back = sensor.lost ? std::nullopt : std::optional(now);
      sensor.held_back_since.reset();
      sensor.losses = 0;
    }
  }
  return out;
}

}  // namespace mien::live
