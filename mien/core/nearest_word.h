#pragma once

#include <span>
#include <string>
#include <string_view>

namespace mien {

/// For "did you mean": the known word that is nearest, by letters added, taken away, changed or swapped with
/// their neighbour (optimal string alignment distance), a third of the word's letters at most; empty where
/// none is.
[[nodiscard]] std::string nearest_word(std::string_view word, std::span<const std::string> known);

/// The end of a message about an unknown word: "; did you mean jawOpen?", or empty where no word is near.
[[nodiscard]] std::string did_you_mean(std::string_view word, std::span<const std::string> known);

}  // namespace mien
