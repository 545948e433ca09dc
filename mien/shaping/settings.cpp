#include "mien/shaping/settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "mien/core/excerpt.h"
#include "mien/core/nearest_word.h"
#include "mien/shaping/blinks.h"

namespace mien::shaping {
namespace {

using nlohmann::json;

/// Where an object or list may hold only these names. `what`: "'merge' has no".
template <class Names>
std::unexpected<Error> unknown_name(std::string_view what, std::string_view name, const Names& known,
                                    const std::string& where, std::string hint = {}) {
  const std::vector<std::string> names(known.begin(), known.end());
  return fail(ErrorCode::malformed, fmt::format("{} '{}'{}", what, excerpt(name), did_you_mean(name, names)),
              where, std::move(hint));
}

using Name = std::string_view;
constexpr std::array<Name, 12> kKeys = {
    "smoothing",        "smooth_head", "resting", "blinks_per_min", "constraints", "rules",
    "lids_follow_eyes", "gains",       "limits",  "fallback",       "merge",       "off"};
constexpr std::array<Name, 3> kFallbackKeys = {"hold_s", "neutral_s", "return_s"};
constexpr std::array<Name, 4> kMergeKeys = {"sure", "unsure", "order", "audio"};

/// A number of the object within low to high. Errors: malformed, out_of_range.
template <class T>
Result<void> read_within(const json& value, const std::string& name, T low, T high, const std::string& where,
                         T& out) {
  if (!value.is_number()) return fail(ErrorCode::malformed, fmt::format("{} is not a number", name), where);
  const double number = value.get<double>();
  if (!(number >= static_cast<double>(low) && number <= static_cast<double>(high)))
    return fail(ErrorCode::out_of_range, fmt::format("{} is {}", name, number), where,
                fmt::format("give {} to {}", low, high));
  out = static_cast<T>(number);
  return {};
}

Result<std::size_t> read_shape(const std::string& name, const std::string& where) {
  const std::size_t i = face::shape_index(name);
  if (i == face::kShapeCount)
    return unknown_name("no shape is called", name, face::kShapeNames, where,
                        "names are those of the 53, as eyeBlink_L");
  return i;
}

Result<void> read_gains(const json& gains, const std::string& where, Limits& limits) {
  if (!gains.is_object()) return fail(ErrorCode::malformed, "'gains' is no table of shapes", where);
  for (const auto& [name, value] : gains.items()) {
    MIEN_TRY_ASSIGN(const std::size_t i, read_shape(name, where));
    MIEN_TRY(read_within(value, "the gain of " + name, 0.0f, ShapeLimits::kGainAtMost, where,
                         limits.shapes[i].gain));
  }
  return {};
}

Result<void> read_limits(const json& table, const std::string& where, Limits& limits) {
  if (!table.is_object()) return fail(ErrorCode::malformed, "'limits' is no table of shapes", where);
  for (const auto& [name, value] : table.items()) {
    MIEN_TRY_ASSIGN(const std::size_t i, read_shape(name, where));
    if (!value.is_array() || value.size() != 2)
      return fail(ErrorCode::malformed, "the limits of " + name + " are no two numbers", where,
                  "give [low, high]");
    ShapeLimits& shape = limits.shapes[i];
    MIEN_TRY(read_within(value[0], "the lower limit of " + name, 0.0f, 1.0f, where, shape.low));
    MIEN_TRY(read_within(value[1], "the upper limit of " + name, shape.low, 1.0f, where, shape.high));
  }
  return {};
}

Result<void> read_fallback(const json& table, const std::string& where, FallbackSettings& fallback) {
  if (!table.is_object()) return fail(ErrorCode::malformed, "'fallback' is no table", where);
  constexpr double kShortest_s = FallbackSettings::kShortest_s;
  constexpr double kLongest_s = FallbackSettings::kLongest_s;
  for (const auto& [key, value] : table.items()) {
    if (key == "hold_s") {
      MIEN_TRY(read_within(value, "'hold_s'", 0.0, kLongest_s, where, fallback.hold_s));
    } else if (key == "neutral_s") {
      MIEN_TRY(read_within(value, "'neutral_s'", kShortest_s, kLongest_s, where, fallback.neutral_s));
    } else if (key == "return_s") {
      MIEN_TRY(read_within(value, "'return_s'", kShortest_s, kLongest_s, where, fallback.return_s));
    } else {
      return unknown_name("'fallback' has no", key, kFallbackKeys, where);
    }
  }
  return {};
}

/// The tracker order of one place.
Result<void> read_order(const std::string& place, const json& names, const std::string& where,
                        MergeSettings& merge) {
  const auto found = std::ranges::find(kMergePlaceNames, place);
  if (found == kMergePlaceNames.end())
    return unknown_name("'order' has no", place, kMergePlaceNames, where,
                        fmt::format("places are {}", fmt::join(kMergePlaceNames, ", ")));
  if (!names.is_array())
    return fail(ErrorCode::malformed, fmt::format("the order of {} is no list", place), where,
                R"(give names of trackers, as ["eyewear", "imu"])");
  if (names.size() > MergeSettings::kMostNames)
    return fail(ErrorCode::out_of_range,
                fmt::format("the order of {} has more than {} names", place, MergeSettings::kMostNames),
                where);
  MergeSettings::Order order;
  for (const json& entry : names) {
    if (!entry.is_string())
      return fail(ErrorCode::malformed, fmt::format("the order of {} holds what is no name", place), where);
    std::string name = entry.get<std::string>();
    if (name.empty() || name.size() > MergeSettings::kLongestName ||
        !std::ranges::all_of(name, [](char c) { return c >= 'a' && c <= 'z'; }))
      return fail(ErrorCode::malformed, fmt::format("the order of {} holds what is no tracker's name", place),
                  where, "names are of small letters, as imu");
    if (std::ranges::find(order, name) != order.end())
      return fail(ErrorCode::malformed, fmt::format("the order of {} names {} twice", place, name), where);
    order.push_back(std::move(name));
  }
  merge.order[static_cast<std::size_t>(found - kMergePlaceNames.begin())] = std::move(order);
  return {};
}

Result<void> read_merge(const json& table, const std::string& where, MergeSettings& merge) {
  if (!table.is_object()) return fail(ErrorCode::malformed, "'merge' is no table", where);
  for (const auto& [key, value] : table.items()) {
    if (key == "sure") {
      MIEN_TRY(read_within(value, "'sure'", 0.0F, 1.0F, where, merge.sure));
    } else if (key == "unsure") {
      MIEN_TRY(read_within(value, "'unsure'", 0.0F, 1.0F, where, merge.unsure));
    } else if (key == "audio") {
      if (!value.is_boolean()) return fail(ErrorCode::malformed, "'audio' is neither true nor false", where);
      merge.audio = value.get<bool>();
    } else if (key == "order") {
      if (!value.is_object()) return fail(ErrorCode::malformed, "'order' is no table of places", where);
      for (const auto& [place, names] : value.items()) MIEN_TRY(read_order(place, names, where, merge));
    } else {
      return unknown_name("'merge' has no", key, kMergeKeys, where);
    }
  }
  if (merge.unsure > merge.sure)
    return fail(ErrorCode::out_of_range, "'unsure' is above 'sure'", where, "give it at most as much");
  return {};
}

/// Errors: malformed (no text, a file's name instead of its text), as face::RigConstraints::parse.
Result<face::RigConstraints> read_rules(const json& value, const std::string& where) {
  if (!value.is_string()) return fail(ErrorCode::malformed, "'rules' is not the text of a file", where);
  const auto& text = value.get_ref<const std::string&>();
  if (text.ends_with(".toml") && text.find_first_of("\n[=") == std::string::npos)
    return fail(ErrorCode::malformed, "'rules' is a file's name, not its text", where,
                "give the text; mien live takes the file with --constraints");
  return face::RigConstraints::parse(text, where + ", 'rules'");
}

/// Errors: malformed (no list, a name that is no step's).
Result<void> read_off(const json& names, const std::string& where, ChainSteps& off) {
  if (!names.is_array())
    return fail(ErrorCode::malformed, "'off' is no list", where, R"(give names of steps, as ["smoothing"])");
  ChainSteps read;
  for (const json& name : names) {
    const std::string step = name.is_string() ? name.get<std::string>() : std::string("(no text)");
    const auto found = std::ranges::find(kChainStepNames, step);
    if (found == kChainStepNames.end())
      return unknown_name("'off' holds what is no step:", step, kChainStepNames, where,
                          fmt::format("steps are {}", fmt::join(kChainStepNames, ", ")));
    read.set(static_cast<std::size_t>(found - kChainStepNames.begin()));
  }
  off = read;
  return {};
}

json write_off(const ChainSteps& off) {
  json names = json::array();
  for (std::size_t step = 0; step < kChainStepCount; ++step)
    if (off.test(step)) names.push_back(kChainStepNames[step]);
  return names;
}

json write_merge(const MergeSettings& merge) {
  json order = json::object();
  for (std::size_t place = 0; place < kMergePlaceCount; ++place)
    order[std::string(kMergePlaceNames[place])] = merge.order[place];
  return {
      {"sure", merge.sure}, {"unsure", merge.unsure}, {"order", std::move(order)}, {"audio", merge.audio}};
}

}  // namespace

std::string write_settings(const ShaperSettings& settings) {
  json gains = json::object();
  json limits = json::object();
  for (std::size_t i = 0; i < face::kShapeCount; ++i) {
    const ShapeLimits& shape = settings.limits.shapes[i];
    const std::string name(face::kShapeNames[i]);
    if (shape.gain != 1) gains[name] = shape.gain;
    if (shape.low != 0 || shape.high != 1) limits[name] = json::array({shape.low, shape.high});
  }
  json out = {{"smoothing", settings.smoothing},
              {"smooth_head", settings.smooth_head},
              {"resting", settings.resting},
              {"blinks_per_min", settings.blinks_per_min},
              {"lids_follow_eyes", settings.lids_follow_eyes},
              {"gains", std::move(gains)},
              {"limits", std::move(limits)},
              {"fallback",
               {{"hold_s", settings.fallback.hold_s},
                {"neutral_s", settings.fallback.neutral_s},
                {"return_s", settings.fallback.return_s}}}};
  if (settings.constraints) out["constraints"] = true;
  if (settings.rules != face::natural_constraints()) out["rules"] = settings.rules.text();
  if (settings.merge != MergeSettings{}) out["merge"] = write_merge(settings.merge);
  if (settings.off.any()) out["off"] = write_off(settings.off);
  return out.dump();
}

Result<ShaperSettings> parse_settings(std::string_view text, const std::string& where,
                                      const ShaperSettings& base) {
  const json root = json::parse(text, nullptr, false);
  if (!root.is_object()) return fail(ErrorCode::malformed, "not a JSON object", where);
  ShaperSettings settings = base;
  for (const auto& [key, value] : root.items()) {
    if (key == "smoothing") {
      MIEN_TRY(read_within(value, "'smoothing'", 0.0, 1.0, where, settings.smoothing));
    } else if (key == "smooth_head") {
      if (!value.is_boolean()) return fail(ErrorCode::malformed, "'smooth_head' is not true or false", where);
      settings.smooth_head = value.get<bool>();
    } else if (key == "resting") {
      if (!value.is_boolean()) return fail(ErrorCode::malformed, "'resting' is not true or false", where);
      settings.resting = value.get<bool>();
    } else if (key == "blinks_per_min") {
      MIEN_TRY(
          read_within(value, "'blinks_per_min'", 0.0, Blinks::kRateAtMost, where, settings.blinks_per_min));
    } else if (key == "constraints") {
      if (!value.is_boolean()) return fail(ErrorCode::malformed, "'constraints' is not true or false", where);
      settings.constraints = value.get<bool>();
    } else if (key == "rules") {
      MIEN_TRY_ASSIGN(settings.rules, read_rules(value, where));
    } else if (key == "lids_follow_eyes") {
      if (!value.is_boolean())
        return fail(ErrorCode::malformed, "'lids_follow_eyes' is not true or false", where);
      settings.lids_follow_eyes = value.get<bool>();
    } else if (key == "gains") {
      MIEN_TRY(read_gains(value, where, settings.limits));
    } else if (key == "limits") {
      MIEN_TRY(read_limits(value, where, settings.limits));
    } else if (key == "fallback") {
      MIEN_TRY(read_fallback(value, where, settings.fallback));
    } else if (key == "merge") {
      MIEN_TRY(read_merge(value, where, settings.merge));
    } else if (key == "off") {
      MIEN_TRY(read_off(value, where, settings.off));
    } else {
      return unknown_name("shaping has no", key, kKeys, where);
    }
  }
  return settings;
}

}  // namespace mien::shaping
