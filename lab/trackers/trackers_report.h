#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "lab/columns.h"
#include "lab/trackers/compare_curves.h"
#include "mien/core/error.h"
#include "mien/face/face.h"
#include "mien/measure/report.h"
#include "mien/render/image.h"

// What is shown of recordings of trackers that were compared.
namespace mien::lab {

/// What is measured of a tracker (docs/reference/tracker_curves.md, "Errors"). Errors over all frames are
/// unknown where they have an unknown offset in them.
[[nodiscard]] const Columns<CurveScore>& tracker_columns();

/// A few seconds around the second in which a tracker does worst, gaps held.
struct WorstMoment {
  std::string tracker;
  double time_s = 0;               ///< Its middle, on the truth's time.
  double pve_mm = 0;               ///< Over that second.
  std::size_t begin = 0, end = 0;  ///< Frames of the comparison: two and a half seconds each way.
};
/// Trackers of unknown offset are never the worst; nothing where there are no others.
[[nodiscard]] std::optional<WorstMoment> worst_moment(const CurveComparison& comparison);

/// The whole on one page: key figures, errors and gaps, lags, the curves around the worst moment, and its
/// picture where there is one. `title`: what the truth is called. Errors: those of render::encode_png.
[[nodiscard]] Result<measure::Report> trackers_report(const CurveComparison& comparison,
                                                      const std::string& title, const std::string& subtitle,
                                                      const std::optional<render::Image>& strip = {});

/// The worst moment, seen from the front: the truth and what each tracker showed, a third of a second before,
/// then, and after; where a tracker saw no face a pale cell. On `face`, whoever performed. Errors: those of
/// moments_strip().
[[nodiscard]] Result<render::Image> moment_strip(const face::Face& face, const CurveComparison& comparison,
                                                 const WorstMoment& moment);

}  // namespace mien::lab
