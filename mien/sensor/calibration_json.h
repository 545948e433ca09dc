#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/sensor/calibration.h"

// What the calibrations of all modalities have alike as JSON.
namespace mien::sensor {

/// The object's entry of this name, where it is a finite number (true or false, text); else false, and `out`
/// is of no meaning.
[[nodiscard]] bool read_number(const nlohmann::json& object, const char* key, double& out);
[[nodiscard]] bool read_flag(const nlohmann::json& object, const char* key, bool& out);
[[nodiscard]] bool read_string(const nlohmann::json& object, const char* key, std::string& out);

/// A list of objects; read_scores takes it back to equal ones.
[[nodiscard]] nlohmann::json scores_json(const std::vector<Score>& scores);
/// `list` is an array. Errors: malformed, which tells the first that is none.
[[nodiscard]] Result<std::vector<Score>> read_scores(const nlohmann::json& list, const std::string& where);

}  // namespace mien::sensor
