#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/sink/arkit_frame.h"
#include "mien/sink/datagrams.h"
#include "mien/sink/unified.h"
#include "mien/sink/vrchat_avatar.h"

namespace mien::sink {

/// Where VRChat listens unless it was started with `--osc`.
inline constexpr std::uint16_t kVrchatPort = 9000;

/// How parameters are written for VRChat.
struct VrchatOptions {
  /// Stands between "/avatar/parameters/" and "v2/JawOpen" or "EyeTrackingActive": "FT/" for avatars made
  /// with the common template. Not used with an avatar, which says its addresses itself.
  std::string prefix;
  /// Bits of a binary parameter, 0 to 7; 0: floats only. With 1 or more every float is followed by p1, p2,
  /// p4, ... and pNegative. Not used with an avatar.
  int binary_bits = 0;
  /// Send VRChat's own eyes (/tracking/eye/...). With an avatar that has eye parameters of its own they are
  /// not sent, whatever this says.
  bool native_eyes = true;
};
inline constexpr int kMaxBinaryBits = 7;

/// Does bit `bit` (0 is p1) of a binary parameter of `bits` bits stand for this value? The bits are those of
/// floor(|value| 2^bits), all of them above 0.99999; a negative value has none where there is no pNegative.
[[nodiscard]] bool binary_bit(float value, int bit, int bits, bool has_negative);

/// Writes frames for VRChat as VRCFaceTracking does: its parameters v2/..., the states of tracking, and
/// VRChat's own eyes, each when it has changed by more than 0.001 and all of them once a second. Eyes are in
/// degrees, pitch positive down and yaw positive to the right. Only while something looks at the eyes
/// (ArkitFrame::eyes_tracked) are their directions sent, as parameters or as VRChat's own: else its idle eyes
/// go on. Its own lids are sent while lids are tracked; when they no longer are, they are opened once and
/// left.
class VrchatEncoder {
 public:
  /// All parameters that there are, under one prefix. Errors: out_of_range (binary_bits), malformed (a prefix
  /// that is no part of an address).
  [[nodiscard]] static Result<VrchatEncoder> make(const VrchatOptions& options);
  /// What this avatar declares and we know, at its addresses, whatever stands before their "v2/". Errors:
  /// mismatch (it declares nothing that we know).
  [[nodiscard]] static Result<VrchatEncoder> make(const VrchatOptions& options, const VrchatAvatar& avatar);

  /// Writes what has changed since the last call: bundles of at most 1400 bytes, or nothing. Allocates only
  /// while `out` grows.
  void encode(const ArkitFrame& frame, std::int64_t frame_index, Datagrams& out);
  /// How many addresses it can send to.
  [[nodiscard]] std::size_t size() const { return channels_.size(); }

 private:
  /// Where a channel's value comes from.
  enum class Source { parameter, eye_tracking, face_tracking, eyes_direction, eyes_closed };
  enum class Form { real, truth, bit, negative, four };
  struct Channel {
    std::string address;
    Source source = Source::parameter;
    Form form = Form::real;
    std::size_t parameter = 0;  ///< Index in unified_parameters().
    int bit = 0;
    int bits = 0;
    bool has_negative = false;
    std::array<float, 4> last{};  ///< As it was last sent.
  };

  void add_native_eyes(bool directions, bool closed);

  std::vector<Channel> channels_;
  std::vector<float> values_;  ///< One a parameter, of this frame.
  std::optional<std::int64_t> last_full_;
};

}  // namespace mien::sink
