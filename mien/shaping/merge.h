#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mien/face/output_frame.h"
#include "mien/shaping/ease_out.h"
#include "mien/shaping/fallback_settings.h"
#include "mien/shaping/frame_parts.h"
#include "mien/shaping/merge_settings.h"
#include "mien/tracker/shape_confidence.h"

namespace mien::shaping {

/// Merges several trackers' frames of one time into one: each shape, the head and the eyes come from one
/// tracker, value, confidence and provenance together; the tongue from the tracker that gives jawOpen, the
/// head's position from the one that gives its rotation.
/// Selection, for each part:
///
/// 1. the first tracker in the region's order that has sensors and explains at least `sure` of the part, or
///    `unsure` for the present one (hysteresis, MergeSettings);
/// 2. else the one with sensors that explains the most; another replaces the present one where it leads by
///    more than the hysteresis, sure - unsure, or where that one explains nothing;
///    None of those is one that lost sight of the shape's region, while another sees it: one that explained a
///    shape of it by `sure` once, and none by `unsure` any more, until it explains one by `sure` again;
/// 3. else none (provenance neutral everywhere): the part is held as shown, then eased to neutral (Fading).
///
/// What a tracker explains of a shape depends on its sensors and not on the weights, so that nothing changes
/// hands within a smile. Where nobody measured that, the confidence of the shape's region stands for it,
/// where that is unknown the shape's own; of head and eyes theirs. A region's confidence is that of the
/// tracker that answers most of its shapes, of equals the first by number; where most are faded it fades.
///
/// What the modality "speech" hears is taken where nobody senses: all of a region, mouth or jaw, from it,
/// once no other tracker explained any of the region's shapes by `unsure` for kUnheard, until one explains
/// one of them by `sure` again. In silence, where it has no estimate, and with `audio` off the others are
/// asked.
///
/// A region, mouth or jaw, that was sensed, and of which nobody who was measured explains any shape by
/// `unsure` any more for kUnheard, has no tracker (rule 3), a lone one's too, until one does again for as
/// long, or by `sure`: what is left of a model's prior is no face. Not so while a tracker answers whose share
/// nobody measured, nor of sensors that never explained as much.
///
/// A tracker all of whose sensors were lost warms up for kWarmUp once they are back, and is no source until
/// then: what its filters and networks begin with after a gap are steps of their own.
///
/// Where the selection changes, the offset from what is shown decays (EaseOut), from the speed that it has
/// where the new source was there before. Both are the fallback's mechanisms and times, part by part, so a
/// tracker that loses its sensors is replaced as smoothly as the fallback returns.
///
/// A pure function of the calls, on frame time; a frame not later than the last resets it. No allocation in
/// apply. Thread: one at a time. Method: docs/method/shaping.md.
class Merge {
 public:
  /// One tracker's frame.
  struct Source {
    face::OutputFrame* frame = nullptr;  ///< Invalid values are mended (bounds.h), in place.
    std::size_t sensors_present = 0;     ///< This tracker's; 0: not selected.
    /// What its sensors explain (tracker::TickResult); null: not measured.
    const tracker::Explained* explained = nullptr;
  };

  /// `modalities`: names of the sources of every apply, in their order; at most kMostSources, and none only
  /// where nothing is applied.
  explicit Merge(std::vector<std::string> modalities, const MergeSettings& settings = {},
                 const FallbackSettings& times = {});
  static constexpr std::size_t kMostSources = 8;
  /// The modality that hears.
  static constexpr std::string_view kListening = "speech";
  /// How long a region is not sensed before it is heard. Raising: sound answers later, and for fewer gaps.
  static constexpr Duration kUnheard = std::chrono::milliseconds(100);

  /// How long a tracker runs with its sensors back before it is asked again. Raising: smoother, and later.
  static constexpr Duration kWarmUp = std::chrono::milliseconds(150);

  /// Fills `out`; `sources` as many as `modalities`. Returns the number of sensors for Shaper::apply: those
  /// of all trackers with an estimate (any provenance but neutral); 0 when none is left; before any had one,
  /// those of all. A single source passes to the bit where it senses mouth and jaw, or nobody measured it;
  /// while it warms up none of its sensors counts.
  std::size_t apply(std::span<const Source> sources, face::OutputFrame& out);

  /// Takes effect at the next frame; values are clamped to their ranges. Not `on`: the first source's frame
  /// passes as it is, whoever knows better.
  void set(const MergeSettings& settings, const FallbackSettings& times, bool on = true);
  /// Resets the state: nothing shown, no tracker selected.
  void reset();
  /// The source selected for a part (frame_parts.h) at the last apply, by number; none where it is faded.
  [[nodiscard]] std::optional<std::size_t> answers(std::size_t part) const {
    return answers_[part] == kNobody ? std::nullopt : std::optional<std::size_t>(answers_[part]);
  }

 private:
  static constexpr std::uint8_t kNobody = 0xFF;
  /// One source's claim to a part of the frame.
  struct Vote {
    bool known = false;  // It has sensors and an estimate.
    bool heard = false;  // It is the modality that listens.
    bool measured = false;
    float share = 0;  // Of the part that it explains; else its confidence.
  };
  /// How much of a region a source sees: a shape of it by `sure` at least, until none by `unsure` any more.
  enum class Sight : std::uint8_t { never, sees, lost };
  /// What is known of a source beyond its present frame.
  struct History {
    face::OutputFrame last, before, earlier;  // Mended: the present frame, and the two before.
    bool told = false;                        // The present one is an estimate.
    std::size_t frames = 0;                   // Estimates in a row before it.
    bool seen = false;                        // It had sensors once.
    bool warms_up = false;  // Its sensors were all lost, and are back for less than kWarmUp.
    std::optional<DeviceTime> back_since;
    std::array<Sight, face::kShapeRegionCount> sight{};  // What it sees of each region.
  };
  /// Mends the source's frame and takes it into its history. Returns its sensors that count.
  std::size_t follow(const Source& source, History& history);
  [[nodiscard]] Vote vote_of(std::span<const Source> sources, std::size_t which, std::size_t part) const;
  [[nodiscard]] std::uint8_t choose(std::span<const Source> sources, std::size_t part) const;
  /// Follows which regions each tracker sees.
  void look_for_sight(std::span<const Source> sources);
  /// Follows which regions no tracker senses: those that sound may answer for, and those that nobody does.
  void look_for_gaps(std::span<const Source> sources, DeviceTime time);
  /// Eases the part out from what is shown to a source that was not asked before.
  void change_hands(std::size_t part, const History& next, const face::OutputFrame& out);
  /// The source that answers most of a region's shapes; kNobody where more are faded.
  [[nodiscard]] std::uint8_t lead_of(std::size_t region) const;
  void copy_regions(std::span<const Source> sources, face::OutputFrame& out);

  std::vector<std::string> modalities_;
  std::vector<std::uint8_t> listens_;  // 1: the source is of the modality "speech".
  MergeSettings settings_;
  FallbackSettings times_;
  bool on_ = true;
  std::array<std::vector<std::uint8_t>, kMergePlaceCount> order_;  // Sources by number, by place.
  std::vector<History> history_;                                   // Of each source.
  std::array<std::uint8_t, kPartCount> answers_{};                 // Selected source by part.
  std::array<std::uint8_t, face::kShapeRegionCount> leads_{};      // Source that answers most of a region.
  std::array<bool, face::kShapeRegionCount> seen_{};               // Some source sees the region.
  std::array<std::optional<DeviceTime>, face::kShapeRegionCount> unsensed_since_;
  std::array<bool, face::kShapeRegionCount> heard_{};  // Sound may answer for the region.
  std::array<std::optional<DeviceTime>, face::kShapeRegionCount> turning_since_{};
  std::array<bool, face::kShapeRegionCount> sensed_{};  // Somebody explained a shape of it by `unsure` once.
  std::array<bool, face::kShapeRegionCount> gap_{};     // None of those who were measured senses it.
  EaseOut ease_out_;
  face::OutputFrame from_;                      // What was shown of each part when it was lost, ...
  std::array<DeviceTime, kPartCount> since_{};  // ... and when.
  std::array<DeviceTime, face::kShapeRegionCount> region_since_{};
  face::OutputFrame shown_before_, shown_;
  bool begun_ = false;  // shown_ is valid.
  bool known_ = false;  // A source has had an estimate.
};

}  // namespace mien::shaping
