#pragma once

#include <filesystem>
#include <limits>
#include <optional>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/core/wav.h"
#include "mien/face/corrective.h"
#include "mien/face/face.h"
#include "mien/face/motion.h"
#include "mien/face/skin_marks.h"
#include "mien/render/camera.h"
#include "mien/render/renderer.h"

namespace mien::app {

struct FilmOptions {
  int width = 480;   ///< Of one view, pixels, even.
  int height = 480;  ///< The same.
  double rate_hz = 30;
  double from_s = 0;
  double until_s = std::numeric_limits<double>::infinity();  ///< The motion's end at the latest.
  float view_rad = render::kFrontView_rad;
  float closeness = 1;
  render::Look look = render::Look::dark();
  render::Quality quality = render::Quality::video;
  float full_scale_m = 5e-3F;                 ///< Where the error's colours end.
  std::optional<Sound> sound;                 ///< From the motion's start.
  face::SkinFolds folds;                      ///< Of the face.
  face::SkinMarks marks;                      ///< The same.
  std::vector<face::Corrective> correctives;  ///< Of the face; a comparison, which measures, leaves them out.
};

struct FilmMade {
  int frames = 0;
  double duration_s = 0;
  double seconds = 0;  ///< How long it took.
};

/// A motion on a face, head movement included (the shoulders stay). Errors: the helper's, bad_usage (no
/// frames in the span), cancelled.
[[nodiscard]] Result<FilmMade> film_motion(const face::Face& face, const face::Motion& motion,
                                           const FilmOptions& options, const std::filesystem::path& out,
                                           const Progress& progress = no_progress);

/// Truth, capture and the capture's error as colour, side by side; head still. `capture_delay_s` is where the
/// capture's time 0 lies on the truth's. The film spans where both are. Errors: as film_motion.
[[nodiscard]] Result<FilmMade> film_comparison(const face::Face& face, const face::Motion& truth,
                                               const face::Motion& capture, double capture_delay_s,
                                               const FilmOptions& options, const std::filesystem::path& out,
                                               const Progress& progress = no_progress);

}  // namespace mien::app
