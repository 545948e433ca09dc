#include "mien/sink/vmc.h"

#include <algorithm>
#include <string>

#include "mien/sink/osc_bundles.h"

namespace mien::sink {
namespace {

const std::array<std::string, 52>& clip_names() {
  static const auto names = [] {
    std::array<std::string, 52> list;
    const auto& arkit = face::arkit52().shapes;
    for (std::size_t i = 0; i < list.size(); ++i) {
      list[i] = arkit[i];
      list[i][0] = static_cast<char>(list[i][0] - 'a' + 'A');
    }
    return list;
  }();
  return names;
}

/// Our axes have +X to the performer's left, Unity's avatar has it to the right: a mirror in the plane of the
/// other two turns the signs of the turns about them.
void add_bone(OscBundles& bundles, const char* bone, const Quat& q) {
  bundles.add("/VMC/Ext/Bone/Pos", bone, 0.0F, 0.0F, 0.0F, static_cast<float>(q.x()),
              static_cast<float>(0.0 - q.y()), static_cast<float>(0.0 - q.z()), static_cast<float>(q.w()));
}

/// Where the whole avatar stands; its heading stays.
void add_root(OscBundles& bundles, const Vec3f& position_m) {
  bundles.add("/VMC/Ext/Root/Pos", "root", 0.0F - position_m.x(), position_m.y(), position_m.z(), 0.0F, 0.0F,
              0.0F, 1.0F);
}

Quat eye_rotation(const Eigen::Vector2f& yaw_left_pitch_up) {
  return canonical(Quat(Eigen::AngleAxisd(static_cast<double>(yaw_left_pitch_up.x()), Vec3::UnitY()) *
                        Eigen::AngleAxisd(-static_cast<double>(yaw_left_pitch_up.y()), Vec3::UnitX())));
}

}  // namespace

std::array<float, kVmcPresets.size()> vmc_presets(const ArkitFrame& frame) {
  const auto weight = [&](const char* name) { return frame.weights.values[face::arkit_index(name)]; };
  const auto both = [&](const char* left, const char* right) {
    return 0.5F * (weight(left) + weight(right));
  };

  // A jaw at two thirds is a wide open vowel.
  const float open = std::min(1.0F, 1.5F * (weight("jawOpen") - weight("mouthClose")));
  const float round = std::max(weight("mouthPucker"), weight("mouthFunnel"));
  const float smile = both("mouthSmileLeft", "mouthSmileRight");
  const float wide = std::max({both("mouthStretchLeft", "mouthStretchRight"), smile,
                               both("mouthDimpleLeft", "mouthDimpleRight")}) *
                     (1 - round);
  const float lips = std::max(both("mouthLowerDownLeft", "mouthLowerDownRight"),
                              both("mouthUpperUpLeft", "mouthUpperUpRight"));
  const float frown = both("mouthFrownLeft", "mouthFrownRight");
  const float joy = smile * (1 - frown);
  return {open * (1 - round - wide),
          (1 - open) * wide * lips,
          (1 - open) * round,
          open * wide,
          open * round,
          weight("eyeBlinkLeft"),
          weight("eyeBlinkRight"),
          joy,
          both("browDownLeft", "browDownRight") * (1 - joy),
          0.5F * (frown + weight("browInnerUp")) * (1 - joy)};
}

void encode_vmc(const ArkitFrame& frame, DeviceTime time, const VmcOptions& options, Datagrams& out) {
  OscBundles bundles(out);
  bundles.add("/VMC/Ext/OK", osc::int32{1});
  bundles.add("/VMC/Ext/T", static_cast<float>(to_seconds(time.time_since_epoch())));
  if (options.bones) {
    if (frame.head_position_known) add_root(bundles, frame.head_position_m);
    add_bone(bundles, "Head", frame.head);
    add_bone(bundles, "LeftEye", eye_rotation(frame.eyes_rad[0]));
    add_bone(bundles, "RightEye", eye_rotation(frame.eyes_rad[1]));
  }
  if (options.shapes != VmcShapes::presets)
    for (std::size_t i = 0; i < clip_names().size(); ++i)
      bundles.add("/VMC/Ext/Blend/Val", clip_names()[i].c_str(), frame.weights.values[i]);
  if (options.shapes != VmcShapes::perfect_sync) {
    const auto values = vmc_presets(frame);
    for (std::size_t i = 0; i < values.size(); ++i)
      bundles.add("/VMC/Ext/Blend/Val", kVmcPresets[i].data(), values[i]);
  }
  bundles.add("/VMC/Ext/Blend/Apply");
  bundles.finish();
}

}  // namespace mien::sink
