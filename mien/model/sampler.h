#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/model/denoiser.h"
#include "mien/model/schedule.h"

namespace mien::model {

/// Long takes are solved in windows, each of which shares this half of itself with the one before.
[[nodiscard]] constexpr std::size_t overlap_frames(std::size_t window) {
  return window / 2;
}

/// First frames of the windows that cover `frames`: half a window apart, the last one moved back to end with
/// the take. A take shorter than a window is one short window.
[[nodiscard]] std::vector<std::size_t> window_starts(std::size_t frames, std::size_t window);

/// Draws the weights of a whole take: [frames x condition] in, [frames x outputs] in [0, 1] out.
///
/// Window by window, the frames shared with the one before are held at its result while the new ones are
/// denoised (settings.hold); then the result passes from the old window's to the new one's over the shared
/// frames, so that no seam stands at a join. The first noise belongs to the frame, not to the window: both
/// windows of a frame start alike.
///
/// The same input and settings give the same bits on one CPU family and build. Errors: bad_usage (sizes, no
/// frames, steps outside the schedule), out_of_range (a condition that is not finite), cancelled. Cost:
/// settings.steps network calls for each half window of frames.
[[nodiscard]] Result<std::vector<float>> solve_windows(const Denoiser& denoiser,
                                                       const ScheduleSettings& schedule,
                                                       std::span<const float> condition,
                                                       const SamplerSettings& settings,
                                                       const Progress& progress);

}  // namespace mien::model
