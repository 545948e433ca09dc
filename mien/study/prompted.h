#pragma once

#include <span>
#include <vector>

#include "mien/take/take.h"
#include "mien/tracker/personalise.h"

namespace mien::study {

/// The expressions that a take's performer was asked for: its events "prompt". One whose details cannot be
/// read, or that asks for no shape, is passed over.
[[nodiscard]] std::vector<tracker::PromptedExpression> prompted_expressions(
    std::span<const take::Event> events);

/// Learns the wearer of a model from a take with prompts (tracker::personalise). Errors: the take's;
/// not_found (too few prompts), unsupported (the model), mismatch.
[[nodiscard]] Result<tracker::Personalisation> personalise_on(const take::Take& take, model::ModelFile& file);

}  // namespace mien::study
