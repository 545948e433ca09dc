#include "mien/session/consent.h"

#include <fmt/format.h>

#include <algorithm>

#include "mien/core/ascii.h"
#include "mien/core/utf8.h"
#include "mien/session/json_fields.h"

namespace mien::session {
namespace {

constexpr std::size_t kMaxPerformer = 60, kMaxRecordedBy = 200, kMaxPurpose = 1000;

bool one_line_within(std::string_view text, std::size_t most) {
  const bool blank = std::ranges::all_of(text, [](char c) { return c == ' '; });
  return !blank && text.size() <= most && is_utf8(text) && !has_control(text);
}

}  // namespace

Result<void> check_consent(const Consent& consent, const std::string& where) {
  const auto wrong = [&where](std::string_view what, std::size_t most) {
    return fail(ErrorCode::out_of_range, fmt::format("{} is empty, or not one line of {} bytes", what, most),
                where, "fill in who is recorded, by whom, and what for");
  };
  if (!one_line_within(consent.performer, kMaxPerformer)) return wrong("the performer", kMaxPerformer);
  if (!one_line_within(consent.recorded_by, kMaxRecordedBy)) return wrong("who records", kMaxRecordedBy);
  if (!one_line_within(consent.purpose, kMaxPurpose)) return wrong("the purpose", kMaxPurpose);
  return {};
}

std::string consent_event_json(const Consent& consent) {
  return nlohmann::json({{"performer", consent.performer},
                         {"recorded_by", consent.recorded_by},
                         {"purpose", consent.purpose},
                         {"sound", consent.sound},
                         {"video", consent.video}})
      .dump();
}

std::optional<Consent> consent_of(std::string_view json) {
  const nlohmann::json event = nlohmann::json::parse(json, nullptr, false);
  if (!event.is_object()) return std::nullopt;
  const Consent consent{text_field(event, "performer"), text_field(event, "recorded_by"),
                        text_field(event, "purpose"), flag_field(event, "sound"), flag_field(event, "video")};
  if (!check_consent(consent, {})) return std::nullopt;
  return consent;
}

}  // namespace mien::session
