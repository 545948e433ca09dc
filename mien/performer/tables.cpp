#include "mien/performer/tables.h"

#include "mien/core/toml.h"

namespace mien::performer {

extern const std::string_view kTablesToml;  // tables.toml.

namespace {

// The file is part of the program: what is not as expected stops the program's tests, and so never gets here.

std::string text_in(const toml::node& node) {
  return node.value<std::string>().value();
}

double number_in(const toml::node& node) {
  return node.value<double>().value();
}

Pose pose_in(const toml::node& node) {
  Pose pose;
  for (const toml::node& named : *node.as_array()) {
    const toml::array& part = *named.as_array();
    for (const PosePart& one : pose_of({{text_in(part[0]), static_cast<float>(number_in(part[1]))}}))
      pose.push_back(one);
  }
  return pose;
}

std::vector<Choice> choices_in(const toml::node& node) {
  std::vector<Choice> choices;
  for (const toml::node& choice : *node.as_array())
    choices.push_back({text_in((*choice.as_array())[0]), number_in((*choice.as_array())[1])});
  return choices;
}

float tongue_in(const toml::table& table) {
  return static_cast<float>(table["tongue_out"].value_or(0.0));
}

std::vector<Expression> expressions_in(const toml::node& node) {
  std::vector<Expression> all;
  for (const toml::node& one : *node.as_array()) {
    const toml::table& table = *one.as_table();
    all.push_back({text_in(*table.get("name")), pose_in(*table.get("pose")), tongue_in(table)});
  }
  return all;
}

Tables read_tables() {
  const toml::table root = parse_toml(kTablesToml, "mien/performer/tables.toml").value();
  Tables all{.emotions = expressions_in(*root.get("emotion")), .looks = expressions_in(*root.get("look"))};
  for (const toml::node& one : *root["couplings"].as_array()) {
    const toml::array& coupling = *one.as_array();
    all.couplings.push_back({pose_of({{text_in(coupling[0]), 1}}), pose_of({{text_in(coupling[1]), 1}}),
                             static_cast<float>(number_in(coupling[2]))});
  }
  for (const toml::node& one : *root["exercise"].as_array()) {
    const toml::table& table = *one.as_table();
    Exercise& exercise = all.exercises.emplace_back();
    exercise.name = text_in(*table.get("name"));
    for (const toml::node& pose : *table["poses"].as_array()) exercise.poses.push_back(pose_in(pose));
    exercise.tongue_out = tongue_in(table);
    if (const toml::array* axes = table["gaze_rad"].as_array())
      exercise.gaze_rad = Eigen::Vector2d(number_in((*axes)[0]), number_in((*axes)[1])).cast<float>();
  }
  for (const toml::node& one : *root["language"].as_array()) {
    const toml::table& table = *one.as_table();
    all.languages.push_back({.code = text_in(*table.get("code")),
                             .syllables_per_s = number_in(*table.get("syllables_per_s")),
                             .stress = number_in(*table.get("stress")),
                             .onset_chance = number_in(*table.get("onset_chance")),
                             .coda_chance = number_in(*table.get("coda_chance")),
                             .weak_vowel = text_in(*table.get("weak_vowel")),
                             .onsets = choices_in(*table.get("onsets")),
                             .vowels = choices_in(*table.get("vowels")),
                             .codas = choices_in(*table.get("codas"))});
  }
  return all;
}

}  // namespace

const Tables& tables() {
  static const Tables all = read_tables();
  return all;
}

}  // namespace mien::performer
