#pragma once

// toml++ as this project uses it: within headers and without exceptions. Include it only from sources, and
// only through this file: two configurations in one program would be two definitions of the same things.
//
// Its release build tells the compiler to assume what its debug build asserts, and some of that does not hold
// for hostile input ("[#" where a table begins): neither is wanted, since its own checks behind them give a
// proper error.
#ifdef NDEBUG
#define MIEN_NDEBUG
#undef NDEBUG
#endif
#define TOML_HEADER_ONLY 1
#define TOML_EXCEPTIONS 0
// Numbers are written as short as they read back the same: 0.005, not 0.0050000000000000001. (Off by default
// since no compiler had it in 2020.)
#define TOML_FLOAT_CHARCONV 1
#define TOML_ASSERT(expression) static_assert(true)
#include <toml++/toml.h>
#ifdef MIEN_NDEBUG
#undef MIEN_NDEBUG
#define NDEBUG
#endif

#include <initializer_list>
#include <string>
#include <string_view>

#include "mien/core/error.h"

namespace mien {

/// Parses TOML that nobody vouches for. Plain ASCII but for comments: the library's search for exotic blanks
/// runs off its own table. Errors: malformed, with the line. `where` names the source in messages.
[[nodiscard]] Result<toml::table> parse_toml(std::string_view text, const std::string& where);

/// Where a node of parse_toml(text, where) stands: "rigs/default.toml, line 12".
[[nodiscard]] std::string place(const std::string& where, const toml::node& node);

/// Errors: malformed, with the line and the known keys, where the table has another key than the known ones.
[[nodiscard]] Result<void> only_keys(const toml::table& table, std::initializer_list<std::string_view> known,
                                     const std::string& where);

}  // namespace mien
