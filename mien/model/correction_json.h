#pragma once

#include <string>
#include <string_view>

#include "mien/core/error.h"
#include "mien/model/correction.h"

namespace mien::model {

/// A correction of the 53 shapes as text, for sessions' logs and calibrations: {"network": key,
/// "hundred_thousandths": [...]}, for each shape its weights and then its bias. 13,621 numbers take about
/// 50 KB.
[[nodiscard]] std::string write_correction(const Correction& correction);
/// Errors: malformed (another layout), out_of_range (a weight beyond kMostCorrection), mismatch (not as many
/// numbers for each of the 53 shapes). Whether it belongs to a network is check_correction()'s to say.
/// `where` names the source in messages.
[[nodiscard]] Result<Correction> parse_correction(std::string_view json, const std::string& where);
/// As it comes back from text: sessions use it so from the beginning.
[[nodiscard]] Correction rounded_as_written(Correction correction);

}  // namespace mien::model
