#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mien/face/output_frame.h"
#include "mien/shaping/ease_out.h"
#include "mien/shaping/fallback_settings.h"
#include "mien/shaping/frame_parts.h"
#include "mien/shaping/merge_settings.h"

namespace mien::shaping {

/// Several trackers' frames of one moment, made one: each shape, the head and the eyes are answered by one of
/// the trackers, and its value, confidence and provenance go out together; the tongue comes from whoever
/// answers jawOpen. Who, by shape:
///
/// 1. the first in its region's order that is there and sure of it (MergeSettings);
/// 2. else, since nobody is sure, the most confident one that is there; who answers already stays until
///    another is more confident by sure - unsure;
/// 3. else nobody, since none that is there knows the shape (provenance neutral): it is held as it was shown,
///    then eased to neutral (Fading).
///
/// A shape that changes hands goes on from what is shown, and the difference is let go (EaseOut). Both are
/// how fallback loses all sensors and takes them up again, a shape at a time and with the same times: so a
/// tracker that loses its sensors is replaced as softly as fallback brings one back, and one that only fills
/// in (speech, from audio) needs nothing but a place at the order's end.
///
/// A pure function of the calls; on frame time, which rises: a frame that is not later than the last begins
/// anew. No allocation in apply. Thread: one at a time.
class Merge {
 public:
  /// One tracker's answer.
  struct Source {
    face::OutputFrame* frame = nullptr;  ///< What is not finite in it is mended, in place.
    std::size_t sensors_there = 0;       ///< Of this tracker's; 0: it guesses, and is not asked.
  };

  /// `modalities` names the sources of every apply, in their order: 1 to kMostSources.
  explicit Merge(std::vector<std::string> modalities, const MergeSettings& settings = {},
                 const FallbackSettings& times = {});
  static constexpr std::size_t kMostSources = 8;

  /// Fills `out` and returns how many sensors stand behind it, for whoever shapes it: those of all trackers
  /// that know anything; 0 once none is left that did; while none did yet, those of all. A lone source goes
  /// through as it is, to the bit.
  std::size_t apply(std::span<const Source> sources, face::OutputFrame& out);

  /// Takes effect at the next frame. Figures out of range are brought into it.
  void set(const MergeSettings& settings, const FallbackSettings& times);
  /// Forgets what was shown, and who answered.
  void reset();
  /// Who answered a part (frame_parts.h) at the last apply, by number; none: nobody.
  [[nodiscard]] std::optional<std::size_t> answers(std::size_t part) const {
    return answers_[part] == kNobody ? std::nullopt : std::optional<std::size_t>(answers_[part]);
  }

 private:
  static constexpr std::uint8_t kNobody = 0xFF;
  /// What one source says of one part of the frame.
  struct Vote {
    bool knows = false;
    float confidence = 0;
  };
  [[nodiscard]] static Vote vote_of(const Source& source, std::size_t part);
  [[nodiscard]] std::uint8_t choose(std::span<const Source> sources, std::size_t part) const;

  std::vector<std::string> modalities_;
  MergeSettings settings_;
  FallbackSettings times_;
  std::array<std::vector<std::uint8_t>, kMergePlaceCount> order_;  // Sources by number.
  std::vector<face::OutputFrame> last_;                            // Of each source, mended.
  std::array<std::uint8_t, kPartCount> answers_{};                 // Who, a part.
  EaseOut ease_out_;
  face::OutputFrame from_;                      // What was shown of each part when nobody knew it any more.
  std::array<DeviceTime, kPartCount> since_{};  // And when.
  face::OutputFrame shown_;
  bool begun_ = false;  // There is something shown.
  bool known_ = false;  // Somebody ever knew something.
};

}  // namespace mien::shaping
