#include "mien/model/correction_json.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "mien/face/profile.h"

namespace mien::model {
namespace {

using nlohmann::json;

/// An answer of weights within 0 to 1 is off by less than a thousandth by it.
constexpr double kSteps = 1e5;
constexpr std::size_t kKeyDigits = 16;
/// As many numbers as the widest network's.
constexpr std::size_t kMostInputs = 4096;

std::int64_t steps_of(float weight) {
  return std::llround(kSteps * double{weight});
}

float weight_of(std::int64_t steps) {
  return static_cast<float>(static_cast<double>(steps) / kSteps);
}

bool is_key(std::string_view text) {
  return text.size() == kKeyDigits && text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

}  // namespace

std::string write_correction(const Correction& correction) {
  const std::size_t outputs = correction.bias.size();
  const std::size_t inputs = outputs == 0 ? 0 : correction.weights.size() / outputs;
  json numbers = json::array();
  for (std::size_t k = 0; k < outputs; ++k) {
    for (std::size_t i = 0; i < inputs; ++i) numbers.push_back(steps_of(correction.weights[k * inputs + i]));
    numbers.push_back(steps_of(correction.bias[k]));
  }
  return json({{"network", correction.network}, {"hundred_thousandths", std::move(numbers)}}).dump();
}

Correction rounded_as_written(Correction correction) {
  for (float& weight : correction.weights) weight = weight_of(steps_of(weight));
  for (float& bias : correction.bias) bias = weight_of(steps_of(bias));
  return correction;
}

Result<Correction> parse_correction(std::string_view text, const std::string& where) {
  const json root = json::parse(text, nullptr, false);
  const auto bad = [&where](const char* what) { return fail(ErrorCode::malformed, what, where); };
  if (!root.is_object()) return bad("the correction is no JSON object");
  const auto network = root.find("network"), numbers = root.find("hundred_thousandths");
  if (network == root.end() || !network->is_string() || !is_key(network->get_ref<const std::string&>()))
    return bad("the correction's 'network' is no 16 hexadecimal digits");
  if (numbers == root.end() || !numbers->is_array())
    return bad("the correction's 'hundred_thousandths' are no list of numbers");
  const std::size_t row = numbers->size() / face::kShapeCount;
  if (row < 2 || row > kMostInputs + 1 || numbers->size() != face::kShapeCount * row)
    return fail(ErrorCode::mismatch, "the correction is not of the 53 shapes", where);
  Correction correction{.network = network->get<std::string>(), .weights = {}, .bias = {}};
  correction.weights.reserve(face::kShapeCount * (row - 1));
  correction.bias.reserve(face::kShapeCount);
  for (std::size_t i = 0; i < numbers->size(); ++i) {
    const json& number = (*numbers)[i];
    if (!number.is_number_integer()) return bad("a weight of the correction is no whole number");
    // As a double first: beyond 2^63 a whole number would come back as another one.
    const auto steps = number.get<double>();
    if (std::abs(steps) > kSteps * double{kMostCorrection})
      return fail(ErrorCode::out_of_range, "the correction is larger than any that is learnt", where);
    ((i + 1) % row == 0 ? correction.bias : correction.weights)
        .push_back(weight_of(static_cast<std::int64_t>(steps)));
  }
  return correction;
}

}  // namespace mien::model
