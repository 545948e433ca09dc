#pragma once

#include "app/json_output.h"
#include "mien/study/takes/export_windows.h"
#include "mien/study/takes/recorded_dataset.h"
#include "mien/study/takes/splits.h"

namespace mien::app {

/// What `mien dataset FOLDER` shows.
void print_dataset(const study::RecordedDataset& dataset);
[[nodiscard]] Json json_of(const study::RecordedDataset& dataset);

/// {"train": [...], "validation": [...], "test": [...]}.
[[nodiscard]] Json json_of(const study::Splits& splits);

/// What `mien dataset export` says that it wrote.
void print_export(const study::Export& exported);
[[nodiscard]] Json json_of(const study::Export& exported);

}  // namespace mien::app
