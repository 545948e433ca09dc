#pragma once

#include <exception>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/model/architecture.h"
#include "mien/model/safetensors.h"

// What every model file says of itself and its network, whatever else is in it.
namespace mien::model {

/// The error of a description that nlohmann::json threw at.
[[nodiscard]] std::unexpected<Error> wrong_description(const std::exception& error, const std::string& where);

/// Takes a tensor's numbers out of the file; nothing where it is missing.
[[nodiscard]] std::optional<std::vector<float>> take_tensor(std::string_view name, TensorFile& file);
/// Whether all tensors were taken out. Errors: mismatch.
[[nodiscard]] Result<void> check_all_taken(const TensorFile& file, const std::string& where);

/// JSON, one object; parse_architecture takes it back.
[[nodiscard]] std::string format_architecture(const Architecture& architecture);
/// Checked. Errors: malformed, unsupported (a kind that is not known), out_of_range.
[[nodiscard]] Result<Architecture> parse_architecture(std::string_view json, const std::string& where);

/// Of a file's network, if the file is of this format and version. `kind`: what such a file is, "a model of
/// speech". Errors: unsupported (another format or version), parse_architecture's.
[[nodiscard]] Result<Architecture> architecture_of(TensorFile& file, std::string_view format,
                                                   std::string_view version, std::string_view kind,
                                                   const std::string& where);

/// Adds the tensors behind "network.", or of a file's second network behind another prefix.
void add_network(const std::vector<Tensor>& network, TensorFile& file, std::string_view prefix = "network.");
/// Takes them out again, in network_tensors()'s order; others stay. Errors: mismatch (one is missing, or of
/// another size).
[[nodiscard]] Result<std::vector<Tensor>> take_network(const Architecture& architecture, TensorFile& file,
                                                       const std::string& where,
                                                       std::string_view prefix = "network.");

}  // namespace mien::model
