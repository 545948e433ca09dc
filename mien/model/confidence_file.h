#pragma once

#include <optional>
#include <string>

#include "mien/core/error.h"
#include "mien/model/confidence.h"
#include "mien/model/safetensors.h"

namespace mien::model {

/// Adds the table of so many shapes to a model's file: metadata "confidence", tensors "confidence.*"
/// (docs/reference/model_file.md). `table` holds together (check()).
void add_confidence(const ConfidenceTable& table, std::size_t shapes, TensorFile& to);

/// Takes it out of a file again; none where the file has no such metadata. What is missing is left empty,
/// which check() refuses. Errors: malformed (no JSON, a key that is missing or of another type, maps of other
/// regions).
[[nodiscard]] Result<std::optional<ConfidenceTable>> take_confidence(TensorFile& from,
                                                                     const std::string& where);

}  // namespace mien::model
