#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string_view>

#include "lab/trackers/mediapipe_scores.h"
#include "lab/trackers/openseeface_log.h"
#include "lab/trackers/tracker_curves.h"

namespace {

/// Ascending times, finite weights, none of what is not told.
void expect_sound(const mien::lab::TrackerCurves& curves) {
  double last_s = -1e300;
  for (const mien::lab::TrackerRow& row : curves.rows) {
    if (!std::isfinite(row.time_s) || !(row.time_s > last_s)) std::abort();
    last_s = row.time_s;
    if (!row.weights) continue;
    for (std::size_t k = 0; k < mien::face::kShapeCount; ++k) {
      const float weight = (*row.weights)[k];
      if (!std::isfinite(weight) || (!curves.told[k] && weight != 0)) std::abort();
    }
  }
}

/// A table of the curves says the same again.
void expect_round_trip(const mien::lab::TrackerCurves& curves) {
  if (curves.told.none() || curves.rows.empty()) return;
  for (const mien::lab::TrackerRow& row : curves.rows)
    if (row.weights)
      for (const float weight : row.weights->values)
        if (std::abs(weight) > mien::lab::kMostTrackerWeight) return;  // Live Link's may be larger.
  const std::string text = mien::lab::format_scores_csv(curves);
  const auto again = mien::lab::parse_scores_csv(text, "again");
  if (!again || again->told != curves.told || again->rows.size() != curves.rows.size()) std::abort();
  for (std::size_t i = 0; i < curves.rows.size(); ++i)
    if (again->rows[i].time_s != curves.rows[i].time_s || again->rows[i].weights != curves.rows[i].weights)
      std::abort();
}

/// At a row's own time the line goes through it, and no gap has a value.
void expect_line(const mien::lab::TrackerCurves& curves) {
  const mien::lab::TimeLine line(curves);
  for (const mien::lab::TrackerRow& row : curves.rows)
    if (row.weights && !line.at(row.time_s)) std::abort();
  (void)line.held_at(curves.first_s() - 1);
  if (!curves.rows.empty() && line.at(curves.first_s() - 1 - curves.period_s())) std::abort();
}

}  // namespace

// Recordings of camera trackers: whichever format the bytes begin as, and each of the formats that they do
// not.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace mien::lab;
  const auto bytes = std::as_bytes(std::span(data, size));
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  for (const auto& read : {parse_tracker_curves(bytes, "fuzz"), parse_mediapipe_lines(text, "fuzz"),
                           parse_scores_csv(text, "fuzz"), parse_openseeface_csv(text, "fuzz"),
                           parse_openseeface_blocks(bytes, "fuzz"), parse_livelink_curves(text, "fuzz")}) {
    if (!read) continue;
    expect_sound(*read);
    expect_round_trip(*read);
    expect_line(*read);
  }
  return 0;
}
