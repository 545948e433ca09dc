#include "app/live/session_message.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "mien/core/units.h"

namespace mien::app {
namespace {

const char* const kWhere = "the session's answer";
/// Thirty years of a device's clock; what is beyond is no time.
constexpr double kMostSeconds = 1e9;

std::unexpected<Error> wrong(const char* key, const char* type) {
  return fail(ErrorCode::malformed, fmt::format("\"{}\" is missing or no {}", key, type), kWhere);
}

const nlohmann::json* find(const nlohmann::json& object, const char* key) {
  const auto found = object.find(key);
  return found == object.end() ? nullptr : &*found;
}

Result<std::string> text_in(const nlohmann::json& object, const char* key) {
  const nlohmann::json* value = find(object, key);
  if (value == nullptr || !value->is_string()) return wrong(key, "text");
  return value->get<std::string>();
}

Result<bool> flag_in(const nlohmann::json& object, const char* key) {
  const nlohmann::json* value = find(object, key);
  if (value == nullptr || !value->is_boolean()) return wrong(key, "true or false");
  return value->get<bool>();
}

Result<double> number_in(const nlohmann::json& object, const char* key) {
  const nlohmann::json* value = find(object, key);
  if (value == nullptr || !value->is_number()) return wrong(key, "number");
  const auto number = value->get<double>();
  if (!std::isfinite(number))
    return fail(ErrorCode::out_of_range, fmt::format("\"{}\" is not finite", key), kWhere);
  return number;
}

Result<double> seconds_in(const nlohmann::json& object, const char* key) {
  MIEN_TRY_ASSIGN(const double seconds, number_in(object, key));
  if (std::abs(seconds) > kMostSeconds)
    return fail(ErrorCode::out_of_range, fmt::format("\"{}\" is no time", key), kWhere);
  return seconds;
}

Result<std::int64_t> whole_in(const nlohmann::json& object, const char* key) {
  const nlohmann::json* value = find(object, key);
  if (value == nullptr || !value->is_number_integer()) return wrong(key, "whole number");
  if (value->is_number_unsigned() && value->get<std::uint64_t>() > std::numeric_limits<std::int64_t>::max())
    return fail(ErrorCode::out_of_range, fmt::format("\"{}\" is too large", key), kWhere);
  return value->get<std::int64_t>();
}

/// What `read` reads; none where it is null or missing: sessions of before did not tell it.
Result<std::optional<double>> optional_in(const nlohmann::json& object, const char* key,
                                          Result<double> (*read)(const nlohmann::json&, const char*)) {
  const nlohmann::json* value = find(object, key);
  if (value == nullptr || value->is_null()) return std::optional<double>();
  MIEN_TRY_ASSIGN(const double number, read(object, key));
  return std::optional(number);
}

/// The objects of a list.
Result<const nlohmann::json*> objects_in(const nlohmann::json& object, const char* key) {
  const nlohmann::json* list = find(object, key);
  if (list == nullptr || !list->is_array()) return wrong(key, "list");
  for (const nlohmann::json& item : *list)
    if (!item.is_object()) return wrong(key, "list of objects");
  return list;
}

Result<sensor::Score> read_score(const nlohmann::json& object) {
  sensor::Score score;
  MIEN_TRY_ASSIGN(score.name, text_in(object, "name"));
  MIEN_TRY_ASSIGN(score.value, number_in(object, "value"));
  MIEN_TRY_ASSIGN(score.unit, text_in(object, "unit"));
  MIEN_TRY_ASSIGN(score.pass, flag_in(object, "pass"));
  MIEN_TRY_ASSIGN(score.sentence, text_in(object, "sentence"));
  return score;
}

Result<session::Report::Calibration> read_calibration(const nlohmann::json& object) {
  session::Report::Calibration out;
  MIEN_TRY_ASSIGN(out.state, text_in(object, "state"));
  MIEN_TRY_ASSIGN(out.step, text_in(object, "step"));
  MIEN_TRY_ASSIGN(out.prompt, text_in(object, "prompt"));
  MIEN_TRY_ASSIGN(out.progress, number_in(object, "progress"));
  MIEN_TRY_ASSIGN(out.remaining_s, seconds_in(object, "remaining_s"));
  MIEN_TRY_ASSIGN(out.age_s, optional_in(object, "age_s", seconds_in));
  MIEN_TRY_ASSIGN(out.recentred_s, optional_in(object, "recentred_s", seconds_in));
  MIEN_TRY_ASSIGN(const std::optional<double> sigma_deg, optional_in(object, "sigma_deg", number_in));
  if (sigma_deg) out.sigma_rad = kRadPerDeg * *sigma_deg;
  MIEN_TRY_ASSIGN(const nlohmann::json* versions, objects_in(object, "versions"));
  for (const nlohmann::json& item : *versions) {
    session::CalibrationVersion& version = out.versions.emplace_back();
    MIEN_TRY_ASSIGN(version.id, whole_in(item, "id"));
    MIEN_TRY_ASSIGN(const double made_s, seconds_in(item, "time"));
    version.made = DeviceTime(from_seconds(made_s));
    MIEN_TRY_ASSIGN(version.origin, text_in(item, "origin"));
    MIEN_TRY_ASSIGN(const bool in_force, flag_in(item, "in_force"));
    if (in_force) out.in_force = version.id;
    MIEN_TRY_ASSIGN(const nlohmann::json* scores, objects_in(item, "scores"));
    for (const nlohmann::json& score : *scores) {
      MIEN_TRY_ASSIGN(version.scores.emplace_back(), read_score(score));
    }
  }
  return out;
}

/// What is asked for and recorded: sessions of before had neither.
Result<void> read_prompts(const nlohmann::json& object, SessionStatus& status) {
  const nlohmann::json* prompts = find(object, "prompts");
  if (prompts == nullptr || !prompts->is_object()) return {};
  MIEN_TRY_ASSIGN(status.prompts, text_in(*prompts, "state"));
  return {};
}

Result<std::optional<SessionStatus::Dataset>> read_dataset(const nlohmann::json& object) {
  const nlohmann::json* dataset = find(object, "dataset");
  if (dataset == nullptr || !dataset->is_object()) return std::optional<SessionStatus::Dataset>();
  SessionStatus::Dataset out;
  MIEN_TRY_ASSIGN(out.take, text_in(*dataset, "take"));
  MIEN_TRY_ASSIGN(out.over, flag_in(*dataset, "over"));
  if (const nlohmann::json* error = find(*dataset, "error"); error != nullptr && !error->is_null()) {
    MIEN_TRY_ASSIGN(out.error, text_in(*dataset, "error"));
  }
  return std::optional(std::move(out));
}

Result<SessionMessage> read_status(const nlohmann::json& object) {
  SessionStatus status;
  MIEN_TRY_ASSIGN(status.time_s, seconds_in(object, "time"));
  MIEN_TRY_ASSIGN(const nlohmann::json* links, objects_in(object, "links"));
  for (const nlohmann::json& item : *links) {
    SessionStatus::Link& link = status.links.emplace_back();
    MIEN_TRY_ASSIGN(link.sensor, text_in(item, "sensor"));
    MIEN_TRY_ASSIGN(link.state, text_in(item, "state"));
  }
  const nlohmann::json* calibration = find(object, "calibration");
  if (calibration == nullptr || !calibration->is_object()) return wrong("calibration", "object");
  MIEN_TRY_ASSIGN(status.calibration, read_calibration(*calibration));
  MIEN_TRY(read_prompts(object, status));
  MIEN_TRY_ASSIGN(status.dataset, read_dataset(object));
  return status;
}

Result<SessionMessage> read_reply(const nlohmann::json& object) {
  SessionReply reply;
  MIEN_TRY_ASSIGN(reply.id, whole_in(object, "id"));
  MIEN_TRY_ASSIGN(const bool ok, flag_in(object, "ok"));
  MIEN_TRY_ASSIGN(reply.error, text_in(object, "error"));
  if (ok != reply.error.empty())
    return fail(ErrorCode::malformed, "a reply that says both yes and no", kWhere);
  return reply;
}

Result<SessionMessage> read_event(const nlohmann::json& object) {
  SessionEvent event;
  MIEN_TRY_ASSIGN(event.kind, text_in(object, "kind"));
  MIEN_TRY_ASSIGN(event.text, text_in(object, "text"));
  return event;
}

}  // namespace

bool SessionStatus::Link::received() const {
  return state != "unbound" && state != "silent" && state != "lost" && state != "no_face";
}

Result<SessionMessage> parse_session_message(std::string_view text) {
  if (text.size() > kMaxSessionMessageBytes)
    return fail(ErrorCode::out_of_range, "a message too long", kWhere);
  const nlohmann::json object = nlohmann::json::parse(text, nullptr, false);
  if (!object.is_object()) return fail(ErrorCode::malformed, "no JSON object", kWhere);
  MIEN_TRY_ASSIGN(const std::string type, text_in(object, "type"));
  if (type == "status") return read_status(object);
  if (type == "reply") return read_reply(object);
  if (type == "event") return read_event(object);
  return SessionMessage();
}

}  // namespace mien::app
