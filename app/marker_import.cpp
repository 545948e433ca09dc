#include "app/marker_import.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <iterator>

#include "app/chosen_face.h"
#include "app/command.h"

namespace mien::app {
namespace {

/// A face whose markers are farther off than this on average is another person's, or in another expression.
constexpr double kFarMm = 5;

}  // namespace

void MarkerImport::add_to(Command command) {
  const Command group = command.add_group("Markers", "For recordings of 3-D markers");
  group
      .add_option("--face", face,
                  "Whose weights: builtin, a folder with generic_neutral_mesh.obj, a .glb or .vrm")
      .show_default();
  group.add_option("--markers", set, "The marker set (default: rigs/markers.toml)");
  group.add_option("--rename", renamed,
                   "THEIRS=OURS: what the recording calls a marker; THEIRS= leaves it out");
  group.add_option("--head", head, "Markers of the recording that are fixed to the head and on no skin");
  group.add_option("--neutral", neutral_s, "When the face was neutral: BEGIN END, seconds from the start")
      .expected(2);
  group.add_flag("--still-head", still_head,
                 "Positions are in the head's frame already, as mien export writes them");
}

Result<ImportedMarkers> import_markers(const mocap::MarkerTrack& track, const MarkerImport& options) {
  MIEN_TRY_ASSIGN(const std::filesystem::path path, path_or(options.set, "rigs/markers.toml"));
  ImportedMarkers imported;
  MIEN_TRY_ASSIGN(imported.set, builtin_face::read_markers(path));
  mocap::MarkerNames names;
  names.head = options.head;
  for (const std::string& text : options.renamed) {
    const auto equals = text.rfind('=');
    if (equals == std::string::npos || equals == 0)
      return fail(ErrorCode::bad_usage, fmt::format("'{}' renames nothing", text), "--rename",
                  "write it as THEIRS=OURS, or THEIRS= to leave it out");
    names.renamed.emplace_back(text.substr(0, equals), text.substr(equals + 1));
  }
  MIEN_TRY_ASSIGN(mocap::MatchedTrack matched, mocap::match_markers(track, imported.set, names));
  imported.missing = std::move(matched.missing);
  imported.unlabelled = matched.unlabelled;

  MIEN_TRY_ASSIGN(const face::Face face, chosen_face(options.face));
  MIEN_TRY_ASSIGN(const builtin_face::PlacedMarkers placed,
                  builtin_face::PlacedMarkers::place(face, imported.set));
  mocap::CleaningSettings settings;
  settings.remove_head = !options.still_head;
  if (options.neutral_s.size() == 2) settings.neutral_s = {options.neutral_s[0], options.neutral_s[1]};
  MIEN_TRY_ASSIGN(const mocap::CleanMarkers clean, mocap::clean_markers(matched, placed, settings));
  imported.cleaning = clean.report;
  MIEN_TRY_ASSIGN(imported.retargeted, mocap::retarget_markers(clean, placed));
  return imported;
}

std::string markers_text(const ImportedMarkers& imported) {
  const mocap::CleaningReport& c = imported.cleaning;
  std::string text;
  auto end = std::back_inserter(text);
  fmt::format_to(end, "markers: {} of {}", imported.set.markers.size() - imported.missing.size(),
                 imported.set.markers.size());
  if (!imported.missing.empty()) fmt::format_to(end, ", without {}", fmt::join(imported.missing, ", "));
  if (imported.unlabelled > 0) fmt::format_to(end, "; {} without a name left out", imported.unlabelled);
  fmt::format_to(end,
                 "\n{} samples: {} lost, {} swapped and mended, {} swapped and not, {} found elsewhere, "
                 "{} outliers\n",
                 c.samples, c.lost, c.mended, c.not_mended, c.strayed, c.outliers);
  if (c.without_head > 0) fmt::format_to(end, "{} frames without a head\n", c.without_head);
  fmt::format_to(end, "residual {:.2f} mm\n", imported.retargeted.residual_mm);
  if (imported.retargeted.residual_mm > kFarMm)
    text += "the face does not reach the markers: say when the performer was neutral, --neutral BEGIN END\n";
  return text;
}

nlohmann::json markers_json(const ImportedMarkers& imported) {
  const mocap::CleaningReport& c = imported.cleaning;
  nlohmann::json residuals = nlohmann::json::object();
  for (std::size_t m = 0; m < imported.set.markers.size(); ++m)
    residuals[imported.set.markers[m].name] = imported.retargeted.residual_of_mm[m];
  return {{"missing", imported.missing},
          {"unlabelled", imported.unlabelled},
          {"samples", c.samples},
          {"lost", c.lost},
          {"without_head", c.without_head},
          {"swaps", c.swaps},
          {"mended", c.mended},
          {"not_mended", c.not_mended},
          {"strays", c.strays},
          {"strayed", c.strayed},
          {"outliers", c.outliers},
          {"scale", c.scale},
          {"residual_mm", imported.retargeted.residual_mm},
          {"residual_of_mm", residuals}};
}

}  // namespace mien::app
