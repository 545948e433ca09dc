#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "mien/core/time.h"
#include "mien/sink/arkit_frame.h"
#include "mien/sink/datagrams.h"

namespace mien::sink {

/// Where a Marionette, the program that draws the avatar, listens. (Performers listen on 39540.)
inline constexpr std::uint16_t kVmcPort = 39539;

/// Which blendshape clips are sent. An avatar that has both kinds shows a movement twice: send it one.
enum class VmcShapes {
  both,
  perfect_sync,  ///< ARKit's 52, first letter large: "JawOpen".
  presets,       ///< VRM 0's presets, made from the 52.
};

struct VmcOptions {
  VmcShapes shapes = VmcShapes::both;
  bool bones = true;  ///< Head, eyes and root too; without them a body tracker's head stays its own.
};

/// VRM 0's presets as this room makes them; VRM 1 receivers map them to their own names. Fun is not among
/// them: no face says it apart from Joy.
inline constexpr std::array<std::string_view, 10> kVmcPresets = {
    "A", "I", "U", "E", "O", "Blink_L", "Blink_R", "Joy", "Angry", "Sorrow"};

/// Their values, 0 to 1, in that order. How far the lips are apart (jawOpen less mouthClose), how round
/// (pucker, funnel) and how wide (stretch, smile, dimple) they are is dealt out between the vowels, so that
/// these never add up to more than 1: A open, O open and round, E open and wide, U round and I wide with the
/// jaw closed and the lips apart. A rule of ours, not the protocol's.
[[nodiscard]] std::array<float, kVmcPresets.size()> vmc_presets(const ArkitFrame& frame);

/// One frame in the VMC protocol: OSC bundles with /VMC/Ext/OK, /VMC/Ext/T (seconds), /VMC/Ext/Bone/Pos of
/// Head, LeftEye and RightEye, /VMC/Ext/Blend/Val a clip, and /VMC/Ext/Blend/Apply as the last message of
/// all. Bones are turned as in Unity, which is left-handed with +X the performer's right: (w, x, -y, -z) of
/// ours. The whole turn of the head goes to the bone Head, its position is 0, as other senders of faces have
/// it: a face knows no body. Where the head's position is known it is the avatar's, /VMC/Ext/Root/Pos "root",
/// (-x, y, z) of ours in m, not turned: a bone that moved away from its neck would tear. That every receiver
/// keeps the position of the avatar's own bone, and moves its root, is UNVERIFIED. Allocates only while `out`
/// grows. Layout: docs/reference/sinks.md.
void encode_vmc(const ArkitFrame& frame, DeviceTime time, const VmcOptions& options, Datagrams& out);

}  // namespace mien::sink
