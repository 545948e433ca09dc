#pragma once

#include <span>
#include <string>
#include <string_view>

#include "mien/core/error.h"
#include "mien/model/features.h"
#include "mien/study/phone_truth.h"
#include "mien/take/take.h"

namespace mien::app {

/// What --truth names the phone that was recorded in the take by.
inline constexpr std::string_view kOwnPhone = "phone";

/// Whether a take has sensors on the skin, by which a phone's time is found. Errors: unsupported.
[[nodiscard]] Result<void> check_aligns(const take::Take& take);

/// What a phone told: the CSV `file`, or the take's own truth where that is empty. Where Live Link Face left
/// a calibrated file beside it ("NAME_cal.csv" beside "NAME.csv"), that is read instead, unless `as_named`.
/// That, and what was survived in a file, is said on stderr. `features`: what study::take_features() gave.
/// Errors: study::phone_track's.
[[nodiscard]] Result<study::PhoneTrack> open_phone_track(const take::Take& take,
                                                         std::span<const model::FeatureFrame> features,
                                                         const std::string& file, bool as_named);

}  // namespace mien::app
