#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"

namespace mien::dataset {

/// The sets that a dataset is split into. Who is in one of them is in no other, with all of their takes:
/// windows of one person are too alike to try on some what was learnt from others.
enum class Split : std::uint8_t { train, validation, test };
inline constexpr std::array<std::string_view, 3> kSplitNames = {"train", "validation", "test"};

/// Who is in which set.
struct Splits {
  std::array<std::vector<std::string>, 3> people;  ///< By Split; sorted.

  [[nodiscard]] const std::vector<std::string>& of(Split split) const {
    return people[static_cast<std::size_t>(split)];
  }
  /// None: in no set.
  [[nodiscard]] std::optional<Split> where(std::string_view person) const;
  bool operator==(const Splits&) const = default;
};

/// Shares of the people; the others train.
struct SplitShares {
  double validation = 0.15;
  double test = 0.15;
};

/// Errors: out_of_range (negative, or nobody is left to train).
[[nodiscard]] Result<void> check_shares(const SplitShares& shares);

/// Draws who is in which set: of each share the nearest whole number of people, at least one where the share
/// is not 0, as long as somebody is left to train; validation comes before the test. So two people are one
/// who trains and one who validates, and one alone trains. `people`: each once. Errors: out_of_range (shares
/// that leave nobody to train).
[[nodiscard]] Result<Splits> draw_splits(std::vector<std::string> people, const SplitShares& shares,
                                         std::uint64_t seed);

/// A splits file is larger than this for nobody.
inline constexpr std::size_t kMaxSplitsBytes = std::size_t{4} << 20U;

/// TOML: a table [split] with a list of names for each set. Names that are not plain ASCII are written as
/// TOML escapes. `comment`: a line that stands above it; plain letters.
[[nodiscard]] std::string write_splits(const Splits& splits, std::string_view comment);
/// `known`: who has takes in the dataset. One of them may be in none of the sets: see
/// split_of(). Errors: malformed (with the line), not_found (somebody without a take; "did you
/// mean"), mismatch (somebody twice).
[[nodiscard]] Result<Splits> parse_splits(std::string_view toml, const std::string& where,
                                          std::span<const std::string> known);
/// The same from a file. Errors: and read_text's.
[[nodiscard]] Result<Splits> read_splits(const std::filesystem::path& path,
                                         std::span<const std::string> known);

/// The set that a person with a take that counts is in. `where`: the splits file. Errors: mismatch (in none).
[[nodiscard]] Result<Split> split_of(const Splits& splits, const std::string& person,
                                     const std::string& where);

}  // namespace mien::dataset
