#pragma once

#include <string>
#include <vector>

#include "lab/columns.h"
#include "lab/eyewear/minute_study.h"
#include "lab/eyewear/sensors_study.h"
#include "mien/measure/report.h"

namespace mien::lab {

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

/// The study as one page: beside the published figures, by region, wearer, set and marker. `subtitle` says
/// whose numbers these are.
[[nodiscard]] measure::Report sensors_report(const SensorsStudy& study, const MinuteStudy& minute,
                                             const std::string& subtitle);

}  // namespace mien::lab
