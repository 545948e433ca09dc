#include "mien/live/link_news.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace mien::live {
namespace {

/// So many sensors at once are said in one sentence.
constexpr std::size_t kMany = 3;

std::string sensor_of(const take::Event& event) {
  const auto details = nlohmann::json::parse(event.json, nullptr, false);
  return details.is_object() ? details.value("sensor", std::string()) : std::string();
}

}  // namespace

struct LinkNews::Trouble {
  std::string begins, ends;            // Kinds of events.
  std::string one_has, one_had;        // "mentalis ...".
  std::string many_have, many_had;     // "3 sensors ...".
  std::string came, now_has, now_had;  // "mentalis ... 3 more times in 10 s and ...".

  static const Trouble& of_links() {
    static const Trouble trouble{.begins = "sensor_lost",
                                 .ends = "sensor_back",
                                 .one_has = "is lost",
                                 .one_had = "is back",
                                 .many_have = "are lost",
                                 .many_had = "are back",
                                 .came = "was lost",
                                 .now_has = "is lost now",
                                 .now_had = "is back now"};
    return trouble;
  }
  static const Trouble& of_faces() {
    static const Trouble trouble{.begins = "face_lost",
                                 .ends = "face_back",
                                 .one_has = "sees no face",
                                 .one_had = "sees the face again",
                                 .many_have = "see no face",
                                 .many_had = "see the face again",
                                 .came = "lost the face",
                                 .now_has = "sees none now",
                                 .now_had = "sees it now"};
    return trouble;
  }
  [[nodiscard]] bool tells(const take::Event& event) const {
    return event.kind == begins || event.kind == ends;
  }
};

bool LinkNews::is_about_a_link(const take::Event& event) {
  return Trouble::of_links().tells(event) || Trouble::of_faces().tells(event);
}

std::string LinkNews::loss_text(std::string_view sensor) {
  return fmt::format("{} {}", sensor, Trouble::of_links().one_has);
}

void LinkNews::tell_of(const Trouble& trouble, HostTime now, std::span<const take::Event> events,
                       std::map<std::string, Sensor, std::less<>>& sensors, std::vector<Sentence>& out) {
  std::vector<std::string> lost, back;
  for (const take::Event& event : events) {
    if (!trouble.tells(event)) continue;
    const std::string name = sensor_of(event);
    Sensor& sensor = sensors[name];
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
  const auto add = [&out](const std::string& kind, const std::vector<std::string>& names,
                          const std::string& one, const std::string& many) {
    if (names.size() >= kMany)
      out.push_back({kind, fmt::format("{} sensors {}", names.size(), many)});
    else
      for (const std::string& name : names) out.push_back({kind, fmt::format("{} {}", name, one)});
  };
  add(trouble.begins, lost, trouble.one_has, trouble.many_have);
  add(trouble.ends, back, trouble.one_had, trouble.many_had);

  // What was held back, when its time is over.
  for (auto& [name, sensor] : sensors) {
    if (!sensor.held_back_since || now - *sensor.held_back_since < kQuiet) continue;
    out.push_back({sensor.lost ? trouble.begins : trouble.ends,
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

std::vector<LinkNews::Sentence> LinkNews::tell(HostTime now, std::span<const take::Event> events) {
  std::vector<Sentence> out;
  tell_of(Trouble::of_links(), now, events, links_, out);
  tell_of(Trouble::of_faces(), now, events, faces_, out);
  return out;
}

}  // namespace mien::live
