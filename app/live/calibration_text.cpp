#include "app/live/calibration_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "app/command.h"
#include "mien/core/units.h"

namespace mien::app {
namespace {

using sensor::Score;
using session::CalibrationVersion;

constexpr std::size_t kNameLetters = 40;
constexpr std::size_t kSentenceLetters = 200;

std::string value_text(const Score& score) {
  return score.unit.empty() ? fmt::format("{:.2f}", score.value)
                            : fmt::format("{:.1f} {}", score.value, one_line(score.unit, 8));
}

std::size_t failed_count(const CalibrationVersion& version) {
  return static_cast<std::size_t>(std::ranges::count(version.scores, false, &Score::pass));
}

/// Scores have different units: the worst is the first that failed, as they stand in the order of the steps.
std::string worst_text(const CalibrationVersion& version) {
  if (version.scores.empty()) return "not judged";
  const std::size_t failed = failed_count(version);
  if (failed == 0) return fmt::format("all {} passed", version.scores.size());
  const auto worst = std::ranges::find(version.scores, false, &Score::pass);
  return fmt::format("{} of {} failed: {} {}", failed, version.scores.size(),
                     one_line(worst->name, kNameLetters), value_text(*worst));
}

std::string ago(double seconds) {
  const auto s = static_cast<std::int64_t>(std::max(0.0, seconds));
  if (s < 60) return fmt::format("{} s ago", s);
  if (s < 3600) return fmt::format("{} min ago", s / 60);
  return fmt::format("{} h {} min ago", s / 3600, s / 60 % 60);
}

/// "Calibrated 1 h 12 min ago, re-centred 3 min ago; rotations are known to 2.1 degrees"; empty where nothing
/// drifts.
std::string certainty_text(const session::Report::Calibration& calibration) {
  if (!calibration.sigma_rad || !calibration.age_s) return {};
  std::string text = "Calibrated " + ago(*calibration.age_s);
  if (calibration.recentred_s) text += ", re-centred " + ago(*calibration.recentred_s);
  return fmt::format("{}; rotations are known to {:.1f} degrees", text, kDegPerRad * *calibration.sigma_rad);
}

const Score* find_score(const CalibrationVersion& version, const std::string& name) {
  const auto found = std::ranges::find(version.scores, name, &Score::name);
  return found == version.scores.end() ? nullptr : &*found;
}

/// The names of both, in the order of the steps.
std::vector<std::string> names_of(const CalibrationVersion& a, const CalibrationVersion& b) {
  std::vector<std::string> names;
  for (const CalibrationVersion* version : {&a, &b})
    for (const Score& score : version->scores)
      if (std::ranges::find(names, score.name) == names.end()) names.push_back(score.name);
  return names;
}

}  // namespace

void print_scores(const CalibrationVersion& version) {
  fmt::print("Calibration {}, {}: {} of {} scores passed\n", version.id,
             one_line(version.origin, kNameLetters), version.scores.size() - failed_count(version),
             version.scores.size());
  for (const Score& score : version.scores)
    fmt::print("  {:<6}  {:<28} {:>10}  {}\n", score.pass ? "passed" : "FAILED",
               one_line(score.name, kNameLetters), value_text(score),
               one_line(score.sentence, kSentenceLetters));
}

void print_versions(const SessionStatus& status) {
  const session::Report::Calibration& calibration = status.calibration;
  if (calibration.versions.empty()) {
    fmt::print("There is no calibration yet. {}\n", one_line(calibration.prompt, kSentenceLetters));
    return;
  }
  fmt::print("  {:>4}  {:<16}  {:<10}  {:<8}  {}\n", "id", "made", "origin", "in force", "worst score");
  for (const CalibrationVersion& version : calibration.versions)
    fmt::print("  {:>4}  {:<16}  {:<10}  {:<8}  {}\n", version.id,
               ago(status.time_s - to_seconds(version.made.time_since_epoch())),
               one_line(version.origin, kNameLetters), version.id == calibration.in_force ? "yes" : "",
               worst_text(version));
  if (const std::string text = certainty_text(calibration); !text.empty()) fmt::print("{}\n", text);
}

void print_comparison(const CalibrationVersion& a, const CalibrationVersion& b) {
  const auto title = [](const CalibrationVersion& version) {
    return fmt::format("{} ({})", version.id, one_line(version.origin, kNameLetters));
  };
  const auto cell = [](const Score* score) {
    if (score == nullptr) return std::string("-");
    return value_text(*score) + (score->pass ? "       " : " FAILED");
  };
  fmt::print("  {:<28}  {:>18}  {:>18}\n", "score", title(a), title(b));
  for (const std::string& name : names_of(a, b))
    fmt::print("  {:<28}  {:>18}  {:>18}\n", one_line(name, kNameLetters), cell(find_score(a, name)),
               cell(find_score(b, name)));
}

Json version_json(const CalibrationVersion& version) {
  Json scores = Json::array();
  for (const Score& score : version.scores)
    scores.push_back({{"name", score.name},
                      {"value", score.value},
                      {"unit", score.unit},
                      {"pass", score.pass},
                      {"sentence", score.sentence}});
  return {{"version", version.id},
          {"origin", version.origin},
          {"made_s", to_seconds(version.made.time_since_epoch())},
          {"scores", std::move(scores)},
          {"passed", version.scores.empty() ? Json(nullptr) : Json(sensor::all_pass(version.scores))}};
}

Json versions_json(const SessionStatus& status) {
  const session::Report::Calibration& calibration = status.calibration;
  Json versions = Json::array();
  for (const CalibrationVersion& version : calibration.versions) {
    versions.push_back(version_json(version));
    versions.back()["in_force"] = version.id == calibration.in_force;
  }
  return {{"state", calibration.state},
          {"sigma_deg", calibration.sigma_rad ? Json(kDegPerRad * *calibration.sigma_rad) : Json(nullptr)},
          {"in_force", calibration.in_force == 0 ? Json(nullptr) : Json(calibration.in_force)},
          {"versions", std::move(versions)}};
}

Json comparison_json(const CalibrationVersion& a, const CalibrationVersion& b) {
  Json scores = Json::array();
  for (const std::string& name : names_of(a, b)) {
    Json values = Json::array();
    Json pass = Json::array();
    std::string unit;
    for (const CalibrationVersion* version : {&a, &b}) {
      const Score* score = find_score(*version, name);
      values.push_back(score == nullptr ? Json(nullptr) : Json(score->value));
      pass.push_back(score == nullptr ? Json(nullptr) : Json(score->pass));
      if (score != nullptr) unit = score->unit;
    }
    scores.push_back({{"name", name}, {"unit", unit}, {"values", values}, {"pass", pass}});
  }
  Json versions = Json::array();
  versions.push_back(version_json(a));
  versions.push_back(version_json(b));
  return {{"versions", std::move(versions)}, {"scores", std::move(scores)}};
}

}  // namespace mien::app
