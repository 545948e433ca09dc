#pragma once

#include <span>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/model/architecture.h"
#include "mien/model/correction.h"
#include "mien/model/safetensors.h"

namespace mien::model {

/// Names a causal network by its output layer, which no two trainings end with alike: the first 16
/// hexadecimal digits of its SHA-256. `network`: as network_tensors() lists them.
[[nodiscard]] std::string correction_key(std::span<const Tensor> network);

/// Whether a correction belongs to this network. Errors: unsupported (a network that is not causal), mismatch
/// (it was learnt for another one, or has another size), out_of_range (a weight beyond kMostCorrection, or
/// not finite). `where` names the source in messages.
[[nodiscard]] Result<void> check_correction(const Correction& correction, const Architecture& architecture,
                                            std::span<const Tensor> network, const std::string& where);

/// The network with the correction in its output layer, for whoever runs it by other means. What
/// check_correction() allows.
[[nodiscard]] std::vector<Tensor> corrected_network(std::span<const Tensor> network,
                                                    const Correction& correction);

}  // namespace mien::model
