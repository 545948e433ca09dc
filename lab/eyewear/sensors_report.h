#pragma once

#include <span>
#include <string>
#include <vector>

#include "lab/columns.h"
#include "lab/eyewear/minute_study.h"
#include "lab/eyewear/sensors_study.h"
#include "mien/builtin_face/markers.h"
#include "mien/core/error.h"
#include "mien/measure/report.h"
#include "mien/render/image.h"

namespace mien::lab {

/// Markers' errors as colour on the built-in face, a face each method beside the other: between markers what
/// lies between, pale where no marker is near. The ramp ends at `full_scale_mm`. Errors: mismatch (a method
/// of other markers); those of render::Lettering::load(). Cost: some seconds.
[[nodiscard]] Result<render::Image> error_picture(const builtin_face::MarkerSet& markers,
                                                  std::span<const SensorsMethod* const> methods,
                                                  double full_scale_mm, int height = 480);

/// What Asano et al. 2017 (section 5.2) published, mm: averages over three participants.
struct PublishedSensors {
  double mean_mm;
  double eyes_mm;
  double mouth_mm;
};
inline constexpr PublishedSensors kPublished20{3.19, 1.81, 5.21};
inline constexpr PublishedSensors kPublished16{3.95, 1.89, 6.97};

/// The figures of a row.
[[nodiscard]] const Columns<SensorsRow>& sensors_columns();

/// The learned method alone, over all tests and in each of `motions`, which are the scene's.
[[nodiscard]] measure::Report minute_report(const MinuteStudy& minute,
                                            const std::vector<std::string>& motions,
                                            const std::string& subtitle);

/// The study as one page: beside the published figures, by region, wearer, set and marker, as colour on the
/// face, and the error as it goes on through the tests. `subtitle` says whose numbers these are, `picture` is
/// error_picture()'s; one without pixels is left out. Errors: the picture's encoder.
[[nodiscard]] Result<measure::Report> sensors_report(const SensorsStudy& study, const MinuteStudy& minute,
                                                     const std::string& subtitle,
                                                     const render::Image& picture);

}  // namespace mien::lab
