#pragma once

#include <expected>
#include <string>
#include <utility>

namespace mien {

/// What kind of thing went wrong; programs branch on it, people read Error's text.
enum class ErrorCode {
  bad_usage,     ///< The caller asked for something that cannot be meant.
  not_found,     ///< A file, sensor, shape or track that is not there.
  io,            ///< The machine would not read or write.
  truncated,     ///< Input ends before what it promised.
  malformed,     ///< Input breaks its own format.
  out_of_range,  ///< A number that is not finite or outside its documented range.
  unsupported,   ///< A version, kind or feature that this program does not know.
  mismatch,      ///< Two inputs that do not belong together.
  cancelled,     ///< The user stopped it.
  internal,      ///< A promise of this program's own that did not hold.
};

/// Bad input or usage: the program ends with 2. Everything else is a failure: it ends with 1.
[[nodiscard]] constexpr bool is_bad_input(ErrorCode code) {
  return code != ErrorCode::io && code != ErrorCode::cancelled && code != ErrorCode::internal;
}

/// One failure, told once, by whoever decides. Each part is a phrase without a final full stop.
struct Error {
  ErrorCode code = ErrorCode::internal;
  std::string what;   ///< What is wrong: "the vertex count is 26718, not 26719".
  std::string where;  ///< Which file, line, packet: "jawOpen.obj, line 12".
  std::string fix;    ///< What to do; may be empty.

  /// One line: "where: what; fix".
  [[nodiscard]] std::string message() const {
    std::string line = where.empty() ? what : where + ": " + what;
    return fix.empty() ? line : line + "; " + fix;
  }
  bool operator==(const Error&) const = default;
};

/// A value or the reason why there is none.
template <class T>
using Result = std::expected<T, Error>;

/// `return fail(ErrorCode::truncated, "the header is cut short", name);`
[[nodiscard]] inline std::unexpected<Error> fail(ErrorCode code, std::string what, std::string where = {},
                                                 std::string fix = {}) {
  return std::unexpected(Error{code, std::move(what), std::move(where), std::move(fix)});
}

}  // namespace mien

/// Leaves the function with the error of a Result<void>-like expression.
#define MIEN_TRY(expression)                                      \
  do {                                                            \
    if (auto mien_try_result = (expression); !mien_try_result)    \
      return std::unexpected(std::move(mien_try_result).error()); \
  } while (false)

#define MIEN_TRY_CONCAT_(a, b) a##b
#define MIEN_TRY_NAME_(line) MIEN_TRY_CONCAT_(mien_try_result_, line)
/// `MIEN_TRY_ASSIGN(auto face, read_face(path));` takes the value or leaves with the error.
#define MIEN_TRY_ASSIGN(declaration, expression)                                                      \
  auto MIEN_TRY_NAME_(__LINE__) = (expression);                                                       \
  if (!MIEN_TRY_NAME_(__LINE__)) return std::unexpected(std::move(MIEN_TRY_NAME_(__LINE__)).error()); \
  declaration = std::move(MIEN_TRY_NAME_(__LINE__)).value()
