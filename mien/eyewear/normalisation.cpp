#include "mien/eyewear/normalisation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "mien/core/quantile.h"
#include "mien/sensor/calibration_json.h"

namespace mien::eyewear {
namespace {

using nlohmann::json;
using sensor::read_flag;
using sensor::read_number;
using sensor::read_string;
using sensor::Score;

constexpr std::size_t kMostSensors = 256;
constexpr std::size_t kMostScores = 1024;
/// Least share of a stretch's frames in which a sensor must be present.
constexpr double kThere = 0.8;
/// Quantiles of one standard deviation either way, of a normal distribution.
constexpr double kSigmaLow = 0.16, kSigmaHigh = 0.84;
/// Quantiles that bound the range of motion.
constexpr double kRangeLow = 0.05, kRangeHigh = 0.95;
/// Frames at which a measured range weighs as much as the usual one: ten seconds.
constexpr double kRangeFrames = 600;

// Limits of the scores.
constexpr double kRestless = 0.25;     // Median sensor's unrest in the hold, log light.
constexpr double kDim = 0.01;          // Light, share of full scale: ten steps of a converter of ten bits.
constexpr double kSaturated = 0.1;     // Share of the hold's frames.
constexpr double kHardlyMoved = 0.04;  // Of the log light in the range of motion.

}  // namespace

float SensorNormalisation::feature(double log_light) const {
  return static_cast<float>(std::clamp((log_light - neutral) / range, -kLimit, kLimit));
}

void read_features(const Normalisation& normalisation, const GridLight& light, LightFrame& out) {
  const std::size_t sensors = normalisation.sensors.size();
  out.values.resize(sensors);
  out.present.resize(sensors);
  for (std::size_t s = 0; s < sensors; ++s) {
    const bool there = light.present[s] != 0 && normalisation.sensors[s].valid;
    out.present[s] = there ? 1 : 0;
    out.values[s] = there ? normalisation.sensors[s].feature(light.log_light[s]) : 0.0F;
  }
}

std::string write_normalisation(const Normalisation& normalisation) {
  json sensors = json::array();
  for (const SensorNormalisation& s : normalisation.sensors)
    sensors.push_back({{"sensor", s.sensor},
                       {"valid", s.valid},
                       {"neutral", s.neutral},
                       {"unrest", s.unrest},
                       {"range", s.range},
                       {"moved", s.moved}});
  return json({{"complete", normalisation.complete},
               {"sensors", std::move(sensors)},
               {"scores", sensor::scores_json(normalisation.scores)}})
      .dump();
}

Result<Normalisation> parse_normalisation(std::string_view text, const std::string& where) {
  const json root = json::parse(text, nullptr, false);
  const auto bad = [&where](const std::string& what) { return fail(ErrorCode::malformed, what, where); };
  if (!root.is_object()) return bad("not a JSON object");
  Normalisation out;
  if (!read_flag(root, "complete", out.complete)) return bad("'complete' is not true or false");
  const auto sensors = root.find("sensors");
  const auto scores = root.find("scores");
  if (sensors == root.end() || !sensors->is_array()) return bad("'sensors' is no list of sensors");
  if (scores == root.end() || !scores->is_array()) return bad("'scores' is no list of scores");
  if (sensors->size() > kMostSensors || scores->size() > kMostScores)
    return fail(ErrorCode::out_of_range, "more sensors or scores than a rig has", where);
  for (const json& item : *sensors) {
    SensorNormalisation s;
    if (!item.is_object() || !read_string(item, "sensor", s.sensor) || !read_flag(item, "valid", s.valid) ||
        !read_number(item, "neutral", s.neutral) || !read_number(item, "unrest", s.unrest) ||
        !read_number(item, "range", s.range) || !read_number(item, "moved", s.moved))
      return bad(fmt::format("sensor {} is not a sensor's normalisation", out.sensors.size()));
    if (!(s.range > 0) || s.unrest < 0 || s.moved < 0)
      return fail(ErrorCode::out_of_range, fmt::format("sensor {} has a range of no size", s.sensor), where);
    out.sensors.push_back(std::move(s));
  }
  MIEN_TRY_ASSIGN(out.scores, sensor::read_scores(*scores, where));
  return out;
}

NormalisationMaker::NormalisationMaker(const sensor::Rig& rig) : names_(photo_sensor_names(rig)) {}

void NormalisationMaker::Stretch::begin(std::size_t sensors) {
  begun = true;
  frames = 0;
  light.assign(sensors, {});
  saturated.assign(sensors, 0);
}

void NormalisationMaker::Stretch::add(const GridLight& seen) {
  if (!begun || frames == kMostFrames) return;
  ++frames;
  for (std::size_t i = 0; i < light.size(); ++i) {
    saturated[i] += seen.saturated[i];
    if (seen.present[i] != 0) light[i].push_back(seen.log_light[i]);
  }
}

void NormalisationMaker::reset() {
  neutral_ = {};
  range_ = {};
}

Normalisation NormalisationMaker::solve(const Normalisation& before) const {
  Normalisation made = before;
  made.sensors.resize(names_.size());
  made.scores.clear();
  const auto there = [](const Stretch& stretch, std::size_t i) {
    return stretch.frames > 0 &&
           static_cast<double>(stretch.light[i].size()) >= kThere * static_cast<double>(stretch.frames);
  };
  for (std::size_t i = 0; i < names_.size(); ++i) {
    SensorNormalisation& s = made.sensors[i];
    s.sensor = names_[i];
    if (neutral_.begun) {
      s.valid = there(neutral_, i);
      if (s.valid) {
        std::vector<double> sorted = neutral_.light[i];
        std::ranges::sort(sorted);
        s.neutral = quantile_of_sorted(sorted, 0.5);
        s.unrest = 0.5 * (quantile_of_sorted(sorted, kSigmaHigh) - quantile_of_sorted(sorted, kSigmaLow));
      }
    }
    if (range_.begun && there(range_, i)) {
      std::vector<double> sorted = range_.light[i];
      std::ranges::sort(sorted);
      s.moved = quantile_of_sorted(sorted, kRangeHigh) - quantile_of_sorted(sorted, kRangeLow);
      // Shrinkage towards the usual range by the number of frames, in the logarithm, since ranges differ by
      // factors.
      const auto frames = static_cast<double>(range_.frames);
      const double trust = frames / (frames + kRangeFrames);
      s.range =
          std::exp(trust * std::log(std::max(s.moved, kHardlyMoved)) + (1 - trust) * std::log(kUsualRange));
    }
  }
  const auto valid = std::ranges::count_if(made.sensors, &SensorNormalisation::valid);
  made.complete = valid > 0 && 2 * static_cast<std::size_t>(valid) >= names_.size();
  if (neutral_.begun) judge_neutral(made);
  if (range_.begun) judge_range(made);
  return made;
}

void NormalisationMaker::judge_neutral(Normalisation& made) const {
  std::vector<double> unrest;
  for (const SensorNormalisation& s : made.sensors)
    if (s.valid) unrest.push_back(s.unrest);
  std::ranges::sort(unrest);
  const double middle = unrest.empty() ? 0 : quantile_of_sorted(unrest, 0.5);
  const bool still = !unrest.empty() && middle <= kRestless;
  made.scores.push_back({.name = "neutral face",
                         .value = 100 * middle,
                         .unit = "%",
                         .pass = still,
                         .sentence = unrest.empty() ? "no sensor sent all through the hold; check the links"
                                     : still
                                         ? "how much the middle sensor's light wandered: the face held still"
                                         : "the face or the glasses moved; relax, hold still and calibrate "
                                           "again"});
  for (std::size_t i = 0; i < names_.size(); ++i) {
    const SensorNormalisation& s = made.sensors[i];
    const double light = s.valid ? std::exp(s.neutral) : 0;
    const bool saturated = neutral_.frames > 0 && static_cast<double>(neutral_.saturated[i]) >
                                                      kSaturated * static_cast<double>(neutral_.frames);
    Score score{.name = "light " + names_[i],
                .value = 100 * light,
                .unit = "%",
                .pass = s.valid && !saturated && light >= kDim,
                .sentence = "its light at the neutral face, of what it can read"};
    if (!s.valid)
      score.sentence = "sent too little during the hold, or was blinded by other light; it counts as missing";
    else if (saturated)
      score.sentence = "stands at the end of its range; bend it away from the skin, or shade it";
    else if (light < kDim)
      score.sentence = "hardly any light comes back; turn it to the skin, or bend it nearer";
    made.scores.push_back(std::move(score));
  }
}

void NormalisationMaker::judge_range(Normalisation& made) const {
  for (const SensorNormalisation& s : made.sensors) {
    if (!s.valid) continue;
    const bool moved = s.moved > kHardlyMoved;
    made.scores.push_back(
        {.name = "range " + s.sensor,
         .value = 100 * s.moved,
         .unit = "%",
         .pass = moved,
         .sentence = moved ? "how far its light went in the range of motion"
                           : "its light hardly changed; do the expressions more strongly, or clean it"});
  }
}

}  // namespace mien::eyewear
