#pragma once

#include "app/json_output.h"
#include "mien/dataset/export_windows.h"
#include "mien/dataset/recorded_dataset.h"
#include "mien/dataset/splits.h"

namespace mien::app {

/// What `mien dataset FOLDER` shows.
void print_dataset(const dataset::RecordedDataset& dataset);
[[nodiscard]] Json json_of(const dataset::RecordedDataset& dataset);

/// {"train": [...], "validation": [...], "test": [...]}.
[[nodiscard]] Json json_of(const dataset::Splits& splits);

/// What `mien dataset export` says that it wrote.
void print_export(const dataset::Export& exported);
[[nodiscard]] Json json_of(const dataset::Export& exported);

}  // namespace mien::app
