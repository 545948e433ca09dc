#include "mien/mocap/marker_track.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <optional>

#include "mien/core/excerpt.h"

namespace mien::mocap {
namespace {

std::string plain(std::string_view name) {
  if (const auto colon = name.rfind(':'); colon != std::string_view::npos) name.remove_prefix(colon + 1);
  std::string lower(name);
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return lower;
}

/// Names of unlabelled points.
bool is_unlabelled(std::string_view name) {
  const std::string lower = plain(name);
  return lower.starts_with("unlabeled") || lower.starts_with("*");
}

std::optional<std::size_t> find_name(std::span<const std::string> names, std::string_view name) {
  const auto found = std::ranges::find(names, name);
  return found == names.end() ? std::nullopt : std::optional<std::size_t>(found - names.begin());
}

std::optional<std::size_t> find_marker(const builtin_face::MarkerSet& set, std::string_view name) {
  const auto found = std::ranges::find(set.markers, name, &builtin_face::Marker::name);
  return found == set.markers.end() ? std::nullopt : std::optional<std::size_t>(found - set.markers.begin());
}

std::optional<std::size_t> find_loosely(const builtin_face::MarkerSet& set, std::string_view name) {
  const std::string wanted = plain(name);
  const auto found = std::ranges::find_if(
      set.markers, [&](const builtin_face::Marker& m) { return plain(m.name) == wanted; });
  return found == set.markers.end() ? std::nullopt : std::optional<std::size_t>(found - set.markers.begin());
}

MarkerTrack pick(const MarkerTrack& track, std::vector<std::string> names,
                 std::span<const std::optional<std::size_t>> from) {
  MarkerTrack picked;
  picked.name = track.name;
  picked.markers = std::move(names);
  if (from.empty()) return picked;
  picked.time_s = track.time_s;
  picked.position_m.reserve(track.frames() * from.size());
  for (std::size_t i = 0; i < track.frames(); ++i)
    for (const auto& column : from)
      picked.position_m.push_back(column ? track.frame(i)[*column] : kLostMarker);
  return picked;
}

/// Names of a file, as a message repeats them.
std::string list_of(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + excerpt(name);
  return list;
}

}  // namespace

Result<MatchedTrack> match_markers(const MarkerTrack& track, const builtin_face::MarkerSet& set,
                                   const MarkerNames& names) {
  std::vector<std::optional<std::size_t>> face(set.markers.size());
  std::vector<std::optional<std::size_t>> head;
  std::vector<bool> used(track.count(), false);
  const auto take = [&](std::size_t theirs, std::size_t ours) -> Result<void> {
    if (face[ours])
      return fail(ErrorCode::mismatch,
                  fmt::format("'{}' and '{}' are both the marker '{}'", excerpt(track.markers[*face[ours]]),
                              excerpt(track.markers[theirs]), set.markers[ours].name),
                  track.name, "leave one out: --rename NAME=");
    face[ours] = theirs;
    return {};
  };

  for (const std::string& name : names.head) {
    const auto theirs = find_name(track.markers, name);
    if (!theirs)
      return fail(ErrorCode::not_found, fmt::format("the recording has no marker '{}'", name), track.name,
                  fmt::format("it has: {}", list_of(track.markers)));
    head.push_back(theirs);
    used[*theirs] = true;
  }
  for (const auto& [from, to] : names.renamed) {
    const auto theirs = find_name(track.markers, from);
    if (!theirs)
      return fail(ErrorCode::not_found, fmt::format("the recording has no marker '{}'", from), track.name,
                  fmt::format("it has: {}", list_of(track.markers)));
    used[*theirs] = true;
    if (to.empty()) continue;
    const auto ours = find_marker(set, to);
    if (!ours)
      return fail(ErrorCode::not_found, fmt::format("the set '{}' has no marker '{}'", set.name, to),
                  track.name);
    MIEN_TRY(take(*theirs, *ours));
  }

  MatchedTrack matched;
  std::vector<std::string> strangers;
  for (std::size_t i = 0; i < track.count(); ++i) {
    if (used[i]) continue;
    auto ours = find_marker(set, track.markers[i]);
    if (!ours) ours = find_loosely(set, track.markers[i]);
    if (ours)
      MIEN_TRY(take(i, *ours));
    else if (is_unlabelled(track.markers[i]))
      ++matched.unlabelled;
    else
      strangers.push_back(track.markers[i]);
  }
  if (!strangers.empty())
    return fail(
        ErrorCode::mismatch, fmt::format("not in the marker set '{}': {}", set.name, list_of(strangers)),
        track.name,
        "name them with --rename THEIRS=OURS, leave them out with --rename THEIRS=, or say with --head "
        "which are fixed to the head");
  if (std::ranges::none_of(face, [](const auto& column) { return column.has_value(); }))
    return fail(ErrorCode::mismatch, fmt::format("no marker of the set '{}' is in it", set.name), track.name);

  std::vector<std::string> ours;
  for (std::size_t i = 0; i < set.markers.size(); ++i) {
    ours.push_back(set.markers[i].name);
    if (!face[i]) matched.missing.push_back(set.markers[i].name);
  }
  matched.face = pick(track, std::move(ours), face);
  matched.head = pick(track, names.head, head);
  return matched;
}

}  // namespace mien::mocap
