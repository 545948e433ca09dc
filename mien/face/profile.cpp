#include "mien/face/profile.h"

#include <algorithm>
#include <utility>

#include "mien/core/ascii.h"
#include "mien/face/profile_map.h"

namespace mien::face {
namespace {

constexpr std::size_t arkit(std::string_view name) {
  std::size_t i = 0;
  while (i < kArkitCount && kArkitNames[i] != name) ++i;
  return i;
}
inline constexpr std::size_t kJawOpen = arkit("jawOpen");
inline constexpr std::size_t kMouthClose = arkit("mouthClose");

/// "eyeBlinkLeft" is split into "eyeBlink" and "_L". jawLeft and the like are directions, not sides of a
/// pair.
constexpr std::pair<std::string_view, std::string_view> split_side(std::string_view name) {
  if (name.starts_with("jaw") || name == "mouthLeft" || name == "mouthRight") return {name, ""};
  if (name.ends_with("Left")) return {name.substr(0, name.size() - 4), "_L"};
  if (name.ends_with("Right")) return {name.substr(0, name.size() - 5), "_R"};
  return {name, ""};
}

Profile arkit_profile(ArkitOrder order) {
  Profile p;
  p.shapes.assign(kArkitNames.begin(), kArkitNames.end());
  const auto swap = [&p](std::string_view a, std::string_view b) {
    std::swap(p.shapes[arkit(a)], p.shapes[arkit(b)]);
  };
  switch (order) {
    case ArkitOrder::live_link_udp:
      p.name = "arkit52";
      break;
    case ArkitOrder::live_link_csv:
      p.name = "arkit52-livelink-csv";
      swap("jawLeft", "jawRight");
      swap("mouthLeft", "mouthRight");
      break;
    case ArkitOrder::live_link_csv_right:
      p.name = "arkit52-livelink-csv-right";
      // Every left name changes places with its right one; jaw and mouth end up right first too.
      for (std::size_t i = 0; i < kArkitCount; ++i) {
        const std::string_view name = kArkitNames[i];
        if (!name.ends_with("Left")) continue;
        swap(name, std::string(name.substr(0, name.size() - 4)) + "Right");
      }
      break;
    case ArkitOrder::alphabetical:
      p.name = "arkit52-alphabetical";
      std::ranges::sort(p.shapes);
      break;
    case ArkitOrder::vts:
      p.name = "arkit52-vts";
      swap("jawLeft", "jawRight");
      break;
  }
  return p;
}

}  // namespace

const Profile& ict53() {
  static const Profile profile{"ict53", {kShapeNames.begin(), kShapeNames.end()}};
  return profile;
}

const Profile& arkit52(ArkitOrder order) {
  static const std::array<Profile, 5> profiles = {
      arkit_profile(ArkitOrder::live_link_udp), arkit_profile(ArkitOrder::live_link_csv),
      arkit_profile(ArkitOrder::live_link_csv_right), arkit_profile(ArkitOrder::alphabetical),
      arkit_profile(ArkitOrder::vts)};
  return profiles[static_cast<std::size_t>(order)];
}

const Profile& mediapipe52() {
  static const Profile profile = [] {
    Profile p{"mediapipe52", {"_neutral"}};
    for (const std::string& name : arkit52(ArkitOrder::alphabetical).shapes)
      if (name != "tongueOut") p.shapes.push_back(name);
    return p;
  }();
  return profile;
}

std::size_t arkit_index(std::string_view name) {
  for (std::size_t i = 0; i < kArkitCount; ++i)
    if (equal_ignoring_case(name, kArkitNames[i])) return i;
  if (name.size() < 3 || name[name.size() - 2] != '_') return kArkitCount;
  const std::string_view stem = name.substr(0, name.size() - 2);
  const char side = ascii_lower(name.back());
  if (side != 'l' && side != 'r') return kArkitCount;
  for (std::size_t i = 0; i < kArkitCount; ++i) {
    const auto [other_stem, other_side] = split_side(kArkitNames[i]);
    if (!other_side.empty() && ascii_lower(other_side.back()) == side &&
        equal_ignoring_case(stem, other_stem))
      return i;
  }
  return kArkitCount;
}

BlendshapeWeights ict_from_arkit(const ArkitWeights& arkit_weights, float* tongue_out) {
  return profile_map(OutsideProfile::arkit52).to_ict(arkit_weights.values, tongue_out);
}

ArkitWeights arkit_from_ict(const BlendshapeWeights& ict, float tongue_out, bool clamp_mouth_close) {
  ArkitWeights weights;
  profile_map(OutsideProfile::arkit52).from_ict(ict, tongue_out, weights.values);
  if (clamp_mouth_close)
    weights.values[kMouthClose] = std::min(weights.values[kMouthClose], weights.values[kJawOpen]);
  return weights;
}

}  // namespace mien::face
