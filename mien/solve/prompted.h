#pragma once

#include <optional>
#include <span>
#include <vector>

#include "mien/take/take.h"
#include "mien/tracker/personalise.h"

namespace mien::solve {

/// The expressions that a take's performer was asked for: its events "prompt". One whose details cannot be
/// read, or that asks for no shape, is passed over.
[[nodiscard]] std::vector<tracker::PromptedExpression> prompted_expressions(
    std::span<const take::Event> events);

/// When the first frame is that counts in an evaluation; none where there is no truth. Errors: the take's.
[[nodiscard]] Result<std::optional<DeviceTime>> first_evaluated(const take::Take& take);

/// Learns the wearer of a model from a take with prompts (tracker::personalise), from what was before
/// `until`. `features`: what take_features() gave. Errors: the take's; not_found (too few prompts),
/// unsupported (the model), mismatch.
[[nodiscard]] Result<tracker::Personalisation> personalise_on(const take::Take& take,
                                                              std::span<const model::FeatureFrame> features,
                                                              model::ModelFile& file,
                                                              std::optional<DeviceTime> until = std::nullopt);

}  // namespace mien::solve
