#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "mien/face/output_frame.h"
#include "mien/shaping/blinks.h"
#include "mien/shaping/fallback.h"
#include "mien/shaping/head_position.h"
#include "mien/shaping/lids.h"
#include "mien/shaping/merge.h"
#include "mien/shaping/recentre.h"
#include "mien/shaping/resting.h"
#include "mien/shaping/settings.h"
#include "mien/shaping/smoothing.h"

namespace mien::shaping {

/// Post-processing of trackers' frames before the sinks, in a fixed order: merge (of the trackers' estimates,
/// a lone one's too: Merge), mend (invalid values), fallback, resting face (off unless asked for),
/// re-centring, the head's position, blinks (of lids that no sensor observes), gains and limits, smoothing,
/// constraints (off unless asked for), bounds (no step above kStepAtMost), gaze (lids from eye directions:
/// the eyes' own step), again bounds ([0, 1]) and the constraints that always hold (mouthClose <= jawOpen),
/// eye directions from lids. Output is finite and within bounds for any input, unless settings.off names mend
/// or bounds. With default settings and no change of sensors a valid frame keeps the bits of its weights (but
/// of lids that blink, and unless mouthClose is above jawOpen; without rules even then) and of its head; with
/// every step off it keeps all of them.
///
/// A pure function of the calls, on frame time; a frame not later than the last (a replay wound back) resets
/// the state but for settings, centre and resting face. No allocation. Thread: one at a time. Method and
/// cost: docs/method/shaping.md.
class Shaper {
 public:
  /// `modalities`: names of the trackers whose estimates every apply() gets, in their order.
  explicit Shaper(const ShaperSettings& settings = {}, std::vector<std::string> modalities = {"lone"});

  /// Merges the trackers' estimates of a frame, and shapes it. `sources`: one a modality, of one time;
  /// invalid values are mended in place. A source's `sensors_present`: how many of its sensors are present,
  /// received in the last 100 ms or unchanged (docs/reference/links.md); 0 of all starts the fallback, a
  /// change is eased out. Where only "any" is known, 0 or 1. Returns how many stand behind the frame
  /// (Merge::apply()).
  std::size_t apply(std::span<const Merge::Source> sources, face::OutputFrame& frame);
  /// The same of a lone tracker's frame, in place. `explained`: what its sensors explain; null: not measured.
  void apply(face::OutputFrame& frame, std::size_t sensors_present,
             const tracker::Explained* explained = nullptr);

  /// Begins re-centring (Recentre), done after 1.5 s.
  void recentre() { recentre_.begin(); }
  /// Puts an earlier centre in force, eased in.
  void use_centre(const Centre& centre) { recentre_.use(centre); }
  /// State and centre, for the page and for calibration versions.
  [[nodiscard]] const Recentre& recentring() const { return recentre_; }

  /// Puts an earlier resting face in force, eased in; seen once settings.resting is on.
  void use_resting(const RestingFace& face) { resting_.use(face); }
  /// What the streaming calibration has learnt, for the page and for calibration versions.
  [[nodiscard]] const Resting& resting() const { return resting_; }

  /// Takes effect at the next frame. Settings must be in range: parse_settings checks them.
  void set(const ShaperSettings& settings);
  [[nodiscard]] const ShaperSettings& settings() const { return settings_; }

  /// Resets the state but for settings, centre and resting face: for another take.
  void reset();

 private:
  /// Merges into `frame`; returns how many sensors count.
  std::size_t merge(std::span<const Merge::Source> sources, face::OutputFrame& frame);

  ShaperSettings settings_;
  bool limited_ = false;  // Some gain or limit differs from the default.
  bool begun_ = false;
  face::OutputFrame last_;   // The last input, mended.
  face::OutputFrame shown_;  // The last output.
  Merge merge_;
  Fallback fallback_;
  Resting resting_;
  Recentre recentre_;
  HeadPosition position_;
  Blinks blinks_;
  Lids lids_;
  Smoothing smoothing_;
};

}  // namespace mien::shaping
