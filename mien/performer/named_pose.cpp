#include "mien/performer/named_pose.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

#include "mien/core/nearest_word.h"
#include "mien/performer/expression.h"

namespace mien::performer {
namespace {

struct PlainName {
  std::string_view plain, library;
};
constexpr std::array kPlainNames = {
    PlainName{"smile", "smile_closed"}, PlainName{"grin", "smile_open"},    PlainName{"laugh", "laugh"},
    PlainName{"sad", "sadness"},        PlainName{"angry", "anger"},        PlainName{"afraid", "fear"},
    PlainName{"disgusted", "disgust"},  PlainName{"surprised", "surprise"}, PlainName{"doubtful", "doubt"},
    PlainName{"wink", "wink_L"},        PlainName{"kiss", "kiss"},          PlainName{"puffed", "puffed"},
    PlainName{"shout", "shout"},        PlainName{"pained", "pain"},        PlainName{"sleepy", "sleepy"},
};
constexpr std::string_view kNeutral = "neutral";

}  // namespace

std::vector<std::string> plain_pose_names() {
  std::vector<std::string> names = {std::string(kNeutral)};
  for (const PlainName& name : kPlainNames) names.emplace_back(name.plain);
  return names;
}

Result<StillPose> named_pose(std::string_view name) {
  StillPose pose;
  if (name == kNeutral) return pose;
  const auto plain = std::ranges::find(kPlainNames, name, &PlainName::plain);
  const std::string_view wanted = plain == kPlainNames.end() ? name : plain->library;
  const auto library = expression_library();
  const auto found = std::ranges::find(library, wanted, &Expression::name);
  if (found == library.end()) {
    std::vector<std::string> known = plain_pose_names();
    const std::string some = fmt::format("such as {}", fmt::join(known, ", "));
    for (const Expression& expression : library) known.emplace_back(expression.name);
    const std::string near = did_you_mean(name, known);
    return fail(ErrorCode::bad_usage, fmt::format("there is no pose '{}'{}", name.substr(0, 40), near), {},
                near.empty() ? some : "");
  }
  for (const PosePart& part : found->pose) pose.weights[part.shape] = part.weight;
  pose.tongue_out = found->tongue_out;
  return pose;
}

}  // namespace mien::performer
