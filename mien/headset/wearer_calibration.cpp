#include "mien/headset/wearer_calibration.h"

#include <nlohmann/json.hpp>

namespace mien::headset {

std::string write_wearer_calibration(const WearerCalibration& calibration) {
  std::string text = write_neutral_face(calibration.neutral);
  if (!calibration.gaze) return text;
  nlohmann::json root = nlohmann::json::parse(text);
  root.update(nlohmann::json::parse(write_gaze_map(*calibration.gaze)));
  return root.dump();
}

Result<WearerCalibration> parse_wearer_calibration(std::string_view text, const std::string& where) {
  WearerCalibration calibration;
  MIEN_TRY_ASSIGN(calibration.neutral, parse_neutral_face(text, where));
  if (nlohmann::json::parse(text, nullptr, false).contains("gaze")) {
    MIEN_TRY_ASSIGN(calibration.gaze, parse_gaze_map(text, where));
  }
  return calibration;
}

}  // namespace mien::headset
