#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/dataset/recorded_dataset.h"
#include "mien/dataset/splits.h"

namespace mien::dataset {

/// Longest window that is exported, frames; as recipes of window networks have it.
inline constexpr std::size_t kLongestWindow = 1024;

struct ExportRequest {
  std::filesystem::path folder;  ///< The dataset.
  std::filesystem::path splits;  ///< Who is in which set: a file (read_splits).
  std::filesystem::path out;     ///< A folder.
  /// Frames of a window at 60 Hz, 2 to kLongestWindow. Raising: more past and future in each, and fewer that
  /// fit between what does not count.
  std::size_t window = 120;
  /// Frames from the beginning of one window to the next's in the same stretch, 1 to kLongestWindow. Raising:
  /// fewer windows, less alike.
  std::size_t stride = 60;
  bool force = false;  ///< Replace an export that is there.
  /// Numbers of a set beyond so many bytes go into a further file. Raising: fewer files, and four times as
  /// much memory.
  std::size_t most_bytes = std::size_t{256} << 20U;
  std::string software;  ///< "mien 0.1.0", for the files' metadata.
  std::string command;   ///< As it was typed, for the datasheet.
};

/// What was written of one set.
struct ExportedSplit {
  std::size_t windows = 0;
  double seconds = 0;  ///< In them; frames that are in several count once.
  std::vector<std::string> files;
};

struct Export {
  RecordedDataset dataset;
  Splits splits;
  std::array<ExportedSplit, 3> sets;  ///< By Split.
  double too_short_s = 0;             ///< Counts, but is in no window: a stretch's end, or shorter than one.
};

/// Writes the dataset as windows: for each set that has some train.safetensors, validation.safetensors or
/// test.safetensors (further files train-2.safetensors, ... where one would be too large), and datasheet.md.
/// All are put in place when all are whole. The same takes, splits and request give the same bytes. Tensors,
/// fp32:
///
/// - `condition`, windows x frames x 9n: of n sensors 7n features (acceleration x y z, m/s^2; rotation w x y
/// z; a
///   sensor each, as model::SensorFeature), then 2n flags (rotation there, a sensor each; then acceleration).
/// - `weights`, windows x frames x 53: the truth, 0 to 1, ICT's order.
/// - `line`, windows x frames: place in the metadata's `lines` of what was read or asked for; -1: nothing.
/// - `take`, windows: place in the metadata's `takes`; `begin_s`, windows: of the window, from the take's
/// first
///   frame.
///
/// Errors: find_takes's, read_splits's, ExportFolder's; out_of_range (window, stride), not_found (no window),
/// mismatch (somebody is in no set), io; cancelled. Memory: one take, and four times most_bytes.
[[nodiscard]] Result<Export> export_windows(const ExportRequest& request, const Progress& progress);

}  // namespace mien::dataset
