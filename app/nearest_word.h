#pragma once

#include <span>
#include <string>
#include <string_view>

namespace mien::app {

/// For "did you mean": the known word that is nearest, by letters added, taken away, changed or swapped with
/// their neighbour (optimal string alignment distance), a third of the word's letters at most; empty where
/// none is.
[[nodiscard]] std::string nearest_word(std::string_view word, std::span<const std::string> known);

}  // namespace mien::app
