#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/model/architecture.h"
#include "mien/model/safetensors.h"

// What every model file says of its network, whatever else is in it.
namespace mien::model {

/// JSON, one object; parse_architecture takes it back.
[[nodiscard]] std::string format_architecture(const Architecture& architecture);
/// Checked. Errors: malformed, unsupported (a kind that is not known), out_of_range.
[[nodiscard]] Result<Architecture> parse_architecture(std::string_view json, const std::string& where);

/// Adds the tensors behind "network.", or of a file's second network behind another prefix.
void add_network(const std::vector<Tensor>& network, TensorFile& file, std::string_view prefix = "network.");
/// Takes them out again, in network_tensors()'s order; others stay. Errors: mismatch (one is missing, or of
/// another size).
[[nodiscard]] Result<std::vector<Tensor>> take_network(const Architecture& architecture, TensorFile& file,
                                                       const std::string& where,
                                                       std::string_view prefix = "network.");

}  // namespace mien::model
