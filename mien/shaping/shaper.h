#pragma once

#include <cstddef>

#include "mien/face/output_frame.h"
#include "mien/shaping/fallback.h"
#include "mien/shaping/recentre.h"
#include "mien/shaping/settings.h"
#include "mien/shaping/smoothing.h"

namespace mien::shaping {

/// What is done to a tracker's frames before they leave, in a fixed order: mend (not finite values),
/// fallback, re-centring, gains and limits, smoothing, bounds ([0, 1], no step above kStepAtMost, mouthClose
/// <= jawOpen), eyes. Whatever comes in, what goes out is finite and within bounds. With default settings a
/// frame that is well, followed without a change, keeps the bits of its weights (but for mouthClose above
/// jawOpen) and of its head.
///
/// A pure function of the calls; on frame time, which rises: a frame that is not later than the last begins
/// anew (a replay that was wound back), with settings and centre kept. No allocation. Thread: one at a time.
/// Cost: docs/method/shaping.md.
class Shaper {
 public:
  explicit Shaper(const ShaperSettings& settings = {});

  /// Shapes the frame in place. `sensors_there`: how many of the rig's sensors are there, heard in the last
  /// 100 ms or unchanged (docs/reference/links.md); 0 begins the fallback, a change is eased over. Where only
  /// "any" is known, 0 or 1.
  void apply(face::OutputFrame& frame, std::size_t sensors_there);

  /// The present face becomes neutral, the present heading ahead: within 1.5 s.
  void recentre() { recentre_.begin(); }
  /// Puts an earlier centre in force, eased in.
  void use_centre(const Centre& centre) { recentre_.use(centre); }
  /// Its state and centre, for the page and for calibration versions.
  [[nodiscard]] const Recentre& recentring() const { return recentre_; }

  /// Takes effect at the next frame. Settings out of range are the caller's fault: parse_settings refuses
  /// them.
  void set(const ShaperSettings& settings);
  [[nodiscard]] const ShaperSettings& settings() const { return settings_; }

  /// Forgets what was shown, keeps settings and centre: for another take.
  void reset();

 private:
  ShaperSettings settings_;
  bool limited_ = false;  // Some gain or limit is not the default.
  bool begun_ = false;
  face::OutputFrame last_;   // As it came in, mended.
  face::OutputFrame shown_;  // As it left.
  Fallback fallback_;
  Recentre recentre_;
  Smoothing smoothing_;
};

}  // namespace mien::shaping
