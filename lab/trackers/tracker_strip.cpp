#include "lab/trackers/tracker_strip.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "lab/moments.h"

namespace mien::lab {
namespace {

constexpr int kStripCell_px = 160;
constexpr std::array<double, 3> kStripTimes_s = {-0.33, 0, 0.33};

/// Printable ASCII, as strips are lettered.
std::string letters_of(std::string name) {
  std::ranges::replace_if(
      name, [](char c) { return c < ' ' || c > '~'; }, '?');
  return name;
}

std::size_t nearest_frame(const std::vector<double>& time_s, double sought_s) {
  const auto nearest = std::ranges::min_element(
      time_s, {}, [sought_s](double frame_s) { return std::abs(frame_s - sought_s); });
  return static_cast<std::size_t>(nearest - time_s.begin());
}

}  // namespace

Result<TrackerPicture> tracker_picture(const face::Face& face, const TrackersRow& row) {
  TrackerPicture out{.row = row.key, .strip = {}, .caption = {}};
  if (!row.moment || row.moment->time_s.empty()) return out;
  const TrackerMoment& moment = *row.moment;
  std::vector<std::size_t> frames;
  std::vector<std::string> captions;
  for (const double aside_s : kStripTimes_s) {
    frames.push_back(nearest_frame(moment.time_s, moment.worst_s + aside_s));
    captions.push_back(fmt::format("{:.2f} s", moment.time_s[frames.back()]));
  }
  std::vector<MomentRow> rows;
  MomentRow& truth = rows.emplace_back();
  truth.name = "truth";
  for (const std::size_t f : frames) truth.weights.emplace_back(moment.truth[f]);
  for (const TrackerMoment::Line& line : moment.lines) {
    MomentRow& shown = rows.emplace_back();
    shown.name = letters_of(line.name);
    for (const std::size_t f : frames)
      shown.weights.push_back(line.saw[f] ? std::optional(line.shown[f]) : std::nullopt);
  }
  MIEN_TRY_ASSIGN(out.strip, moments_strip(face, rows, captions, kStripCell_px));
  out.caption = fmt::format("{}: the worst moment. Pale: the tracker saw no face.", row.title);
  return out;
}

}  // namespace mien::lab
