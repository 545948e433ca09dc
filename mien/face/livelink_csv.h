#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/rotation.h"
#include "mien/face/motion.h"

namespace mien::face {

/// Columns of values: ARKit's 52, then the nine angles.
inline constexpr std::size_t kLiveLinkValueCount = 61;

/// HH:MM:SS:FF.sss: FF counts frames within the second, .sss is a part of one frame.
struct Timecode {
  std::int32_t hour = 0;         ///< 0 to 99: a clock that was never set may run past a day.
  std::int32_t minute = 0;       ///< 0 to 59.
  std::int32_t second = 0;       ///< 0 to 59.
  std::int32_t frame_milli = 0;  ///< 1000 FF.sss, 0 to 239,999.
  bool operator==(const Timecode&) const = default;
};
/// Errors: malformed, out_of_range. The fraction may be missing; further digits of it are dropped.
[[nodiscard]] Result<Timecode> parse_timecode(std::string_view text);
/// "00:32:09:07.867".
[[nodiscard]] std::string format_timecode(const Timecode& timecode);
/// How long after 00:00:00:00 that is, s, where so many frames are a second.
[[nodiscard]] double timecode_seconds(const Timecode& timecode, int base);
/// The time code of a moment `time_s` after 00:00:00:00.000, with base 60; rounded once, to a thousandth of a
/// frame. Before 0 is 0; after 100 hours it begins anew.
[[nodiscard]] Timecode timecode_at(double time_s);

/// One row of a recording.
struct LiveLinkRow {
  std::string timecode_text;  ///< As written.
  Timecode timecode;
  /// None while the face was lost, else kLiveLinkValueCount of them: ArkitOrder::live_link_udp, then HeadYaw,
  /// HeadPitch, HeadRoll, LeftEyeYaw, LeftEyePitch, LeftEyeRoll, RightEyeYaw, RightEyePitch, RightEyeRoll in
  /// radians. Doubles, so that ten decimals come out as they went in.
  std::vector<double> values;

  [[nodiscard]] bool has_face() const { return !values.empty(); }
};

/// A Live Link Face recording.
struct LiveLinkCsv {
  bool right_first = false;  ///< The newer header, in which right columns stand before left ones.
  std::vector<LiveLinkRow> rows;
  std::vector<std::string>
      warnings;  ///< What was survived: missing or unknown columns, a last row cut short.
};

/// Reads a recording strictly by its header's names, in any case and order, since orders differ between
/// versions of the app. Survived: a byte order mark, either line end, spaces and a final comma,
/// `BlendshapeCount`, rows of two cells (the face is lost), a last row cut short without a line end. Errors:
/// truncated (no header, no rows), malformed (no Timecode column, no shape column, a doubled column, a row of
/// another length), out_of_range (a value that is not finite or beyond +-100). `name` is what errors call it.
[[nodiscard]] Result<LiveLinkCsv> parse_livelink_csv(std::string_view text, std::string_view name);

/// The recording as text with the PascalCase header that importers expect: ten decimals, LF. What was written
/// so comes back byte for byte.
[[nodiscard]] std::string format_livelink_csv(const LiveLinkCsv& csv);
/// The same for a recording that is still going on: its header's line, then a row's. `values` as in
/// LiveLinkRow: none where the face is lost, else kLiveLinkValueCount. Allocates only while `out` grows.
void append_livelink_header(std::string& out);
void append_livelink_row(std::string_view timecode, std::span<const double> values, std::string& out);

/// The base of FF. It is not in the file: 60 when any FF exceeds 30, else the largest FF + 1 rounded to 24,
/// 25 or 30; 60 when the largest is so small that no second can have been seen whole. (Takes at 30 fps count
/// FF in steps of 2.)
[[nodiscard]] int timecode_base(const LiveLinkCsv& csv);

struct LiveLinkMotion {
  Motion motion;
  double start_s = 0;                 ///< The first row's time code, s after 00:00:00:00.
  double rate_hz = 0;                 ///< 1 / the median step; 0 with fewer than two rows.
  std::vector<std::string> warnings;  ///< The recording's own, and how many rows were dropped.
};

/// The performance in a recording, at its own times: the first row is 0 s, a dropped frame is a longer step,
/// midnight is crossed. Rows out of order or doubled are dropped, and counted in a warning: what stays is the
/// longest run of rows with rising time codes, so that one wrong row costs one row.
[[nodiscard]] LiveLinkMotion motion_from_livelink(const LiveLinkCsv& csv, std::string name);

/// The recording of a performance, time codes from 00:00:00:00.000 with base 60. Eye angles follow from the
/// eyeLook weights, kEyeTurnRadPerUnit a unit. `clamp_mouth_close` holds mouthClose to at most jawOpen.
[[nodiscard]] LiveLinkCsv livelink_from_motion(const Motion& motion, bool clamp_mouth_close = true);
/// That recording as text, of which only one row is held otherwise.
[[nodiscard]] std::string format_livelink_csv(const Motion& motion);

/// q_world_head from HeadYaw, HeadPitch, HeadRoll (rad), turned in this order. Their signs are documented
/// nowhere; they are taken as the eyes' are measured to be: yaw to the performer's right, pitch down, roll to
/// the right shoulder.
[[nodiscard]] Quat head_from_livelink(const Vec3& yaw_pitch_roll_rad);
/// The inverse: yaw and roll in [-pi, pi], pitch in [-pi/2, pi/2].
[[nodiscard]] Vec3 livelink_from_head(const Quat& q_world_head);

/// The performance in a Live Link Face CSV, named after its file. Errors: not_found, io, and those of
/// parse_livelink_csv.
[[nodiscard]] Result<LiveLinkMotion> load_livelink(const std::filesystem::path& path);
/// Its motion alone. `warnings`, where given, tells what was survived. Errors: the same.
[[nodiscard]] Result<Motion> load_motion(const std::filesystem::path& path,
                                         std::vector<std::string>* warnings = nullptr);

}  // namespace mien::face
