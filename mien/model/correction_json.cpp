#include "mien/model/correction_json.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "mien/face/profile.h"

namespace mien::model {
namespace {

using nlohmann::json;

/// What an answer of weights within 0 to 1 can be off by it is far below what anybody sees.
constexpr double kSteps = 1e4;

std::int64_t steps_of(float weight) {
  return std::llround(kSteps * double{weight});
}

}  // namespace

std::string write_correction(const Correction& correction) {
  json weights = json::array();
  for (const float weight : correction.weights) weights.push_back(steps_of(weight));
  return json({{"lags", correction.lags}, {"ten_thousandths", std::move(weights)}}).dump();
}

Correction rounded_as_written(Correction correction) {
  for (float& weight : correction.weights)
    weight = static_cast<float>(static_cast<double>(steps_of(weight)) / kSteps);
  return correction;
}

Result<Correction> parse_correction(std::string_view text, const std::string& where) {
  const json root = json::parse(text, nullptr, false);
  const auto bad = [&where](const char* what) { return fail(ErrorCode::malformed, what, where); };
  if (!root.is_object()) return bad("the correction is no JSON object");
  const auto lags = root.find("lags"), weights = root.find("ten_thousandths");
  if (lags == root.end() || !lags->is_array() || lags->empty() || lags->size() > kMostCorrectionLags)
    return bad("the correction's 'lags' are no list of frames");
  if (weights == root.end() || !weights->is_array())
    return bad("the correction's 'ten_thousandths' are no list of numbers");
  Correction correction;
  for (const json& lag : *lags) {
    if (!lag.is_number_unsigned()) return bad("a lag of the correction is no number of frames");
    const auto frames = lag.get<std::uint64_t>();
    const bool first = correction.lags.empty();
    if (frames > kLongestCorrectionLag || (first ? frames != 0 : frames <= correction.lags.back()))
      return fail(ErrorCode::out_of_range, "the correction's lags do not ascend from 0, or go too far back",
                  where);
    correction.lags.push_back(static_cast<std::size_t>(frames));
  }
  if (weights->size() != face::kShapeCount * correction.lags.size() * face::kShapeCount)
    return fail(ErrorCode::mismatch, "the correction has another size than shapes and lags", where);
  correction.weights.reserve(weights->size());
  for (const json& weight : *weights) {
    if (!weight.is_number_integer()) return bad("a weight of the correction is no whole number");
    const auto steps = weight.get<std::int64_t>();
    if (std::abs(static_cast<double>(steps)) > kSteps * double{kMostCorrection})
      return fail(ErrorCode::out_of_range, "the correction is larger than any that is learnt", where);
    correction.weights.push_back(static_cast<float>(static_cast<double>(steps) / kSteps));
  }
  return correction;
}

}  // namespace mien::model
