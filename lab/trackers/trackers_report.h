#pragma once

#include <optional>
#include <span>
#include <string>

#include "lab/trackers/trackers_study.h"
#include "mien/core/error.h"
#include "mien/face/face.h"
#include "mien/measure/report.h"
#include "mien/render/image.h"

namespace mien::lab {

/// A row's worst moment as pictures side by side.
struct TrackerPicture {
  std::string row;  ///< The row's key.
  std::optional<render::Image> strip;
  std::string caption;
};

/// Each condition a strong row, then its trackers: errors as told, without lag and held, each as mean and 95
/// % interval over performers; where there is a reference also by how much each is above it.
[[nodiscard]] measure::Table trackers_table(const TrackersStudy& study);
/// How late each tracker is, and how sure that is.
[[nodiscard]] measure::Table lag_table(const TrackersStudy& study);

/// "Modelled, not measured": what stands on every page of modelled trackers.
[[nodiscard]] std::string modelled_notice();

/// The whole on one page: key figures, errors and gaps by condition, the curves around the worst moment of
/// each row, lags, pictures where there are any, and of modelled trackers where each number comes from.
/// Errors: those of render::encode_png.
[[nodiscard]] Result<measure::Report> trackers_report(const TrackersStudy& study, const std::string& subtitle,
                                                      std::span<const TrackerPicture> pictures = {});

/// A row's worst moment, seen from the front: the truth and what each tracker showed, a third of a second
/// before, then, and after; where a tracker saw no face a pale cell. On `face`, whoever performed. Without a
/// strip where the row has no moment. Errors: those of moments_strip().
[[nodiscard]] Result<TrackerPicture> tracker_picture(const face::Face& face, const TrackersRow& row);

}  // namespace mien::lab
