#pragma once

#include <string>
#include <string_view>

#include "mien/core/error.h"
#include "mien/model/correction.h"

namespace mien::model {

/// A correction as text, for sessions' logs and calibrations: {"lags": [...], "ten_thousandths": [...]}, W
/// row by row. 8427 numbers take 15 to 45 KB.
[[nodiscard]] std::string write_correction(const Correction& correction);
/// Errors: malformed (another layout), out_of_range (lags that do not ascend from 0, or go too far back; a
/// weight beyond kMostCorrection), mismatch (another size than the 53 shapes and the lags have). `where`
/// names the source in messages.
[[nodiscard]] Result<Correction> parse_correction(std::string_view json, const std::string& where);
/// As it comes back from text: sessions use it so from the beginning.
[[nodiscard]] Correction rounded_as_written(Correction correction);

}  // namespace mien::model
