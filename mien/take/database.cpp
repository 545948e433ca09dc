#include "mien/take/database.h"

#include <fmt/format.h>

#include <cmath>
#include <cstring>

#include "mien/core/excerpt.h"
#include "mien/core/utf8.h"
#include "mien/take/layout.h"

namespace mien::take {
namespace fs = std::filesystem;

void Statement::bind(int index, std::string_view text) {
  // A null pointer would bind NULL.
  const char* data = text.empty() ? "" : text.data();
  sqlite3_bind_text64(statement_.get(), index, data, text.size(), SQLITE_STATIC, SQLITE_UTF8);
}

void Statement::bind(int index, std::span<const std::byte> blob) {
  if (blob.empty())
    sqlite3_bind_zeroblob(statement_.get(), index, 0);
  else
    sqlite3_bind_blob64(statement_.get(), index, blob.data(), blob.size(), SQLITE_STATIC);
}

Result<Database> Database::open(const fs::path& path, int flags, std::string where) {
  Database database;
  database.where_ = std::move(where);
  // An absolute path is never taken for a URI or for a special name such as ":memory:".
  std::error_code code;
  const fs::path absolute = fs::absolute(path, code);
  if (code) return fail(ErrorCode::io, code.message(), database.where_);
  sqlite3* handle = nullptr;
  const int rc = sqlite3_open_v2(absolute.c_str(), &handle, flags, nullptr);
  database.handle_.reset(handle);
  if (handle == nullptr) return fail(ErrorCode::io, "there is no memory to open it", database.where_);
  if (rc != SQLITE_OK) return std::unexpected(database.error(rc));
  sqlite3_extended_result_codes(handle, 1);
  return database;
}

Result<void> Database::run(const char* sql) {
  const int rc = sqlite3_exec(handle_.get(), sql, nullptr, nullptr, nullptr);
  if (rc != SQLITE_OK) return std::unexpected(error(rc));
  return {};
}

Result<Statement> Database::prepare(const char* sql) const {
  sqlite3_stmt* statement = nullptr;
  const int rc = sqlite3_prepare_v3(handle_.get(), sql, -1, SQLITE_PREPARE_PERSISTENT, &statement, nullptr);
  if (rc != SQLITE_OK) return std::unexpected(error(rc));
  return Statement(statement);
}

Result<std::int64_t> Database::read_integer(const char* sql) const {
  MIEN_TRY_ASSIGN(Statement statement, prepare(sql));
  const int rc = statement.step();
  if (rc == SQLITE_ROW) return sqlite3_column_int64(statement.get(), 0);
  return std::unexpected(error(rc == SQLITE_DONE ? SQLITE_CORRUPT : rc));
}

Result<std::string> Database::read_text(const char* sql) const {
  MIEN_TRY_ASSIGN(Statement statement, prepare(sql));
  const int rc = statement.step();
  if (rc != SQLITE_ROW) return std::unexpected(error(rc == SQLITE_DONE ? SQLITE_CORRUPT : rc));
  const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(statement.get(), 0));
  const int size = sqlite3_column_bytes(statement.get(), 0);
  return text == nullptr ? std::string() : std::string(text, static_cast<std::size_t>(size));
}

Error Database::error(int code) const {
  const int system_error = handle_ == nullptr ? 0 : sqlite3_system_errno(handle_.get());
  // It may repeat what the file says.
  const std::string said =
      excerpt(handle_ == nullptr ? sqlite3_errstr(code) : sqlite3_errmsg(handle_.get()), kComplaintLetters);
  const std::string detail = system_error != 0 ? std::strerror(system_error) : said;
  if (code == SQLITE_READONLY_DBMOVED)
    return {ErrorCode::io, "the file was moved, replaced or deleted while it was in use", where_, ""};
  switch (code & 0xFF) {
    case SQLITE_FULL:
      return {ErrorCode::io, "the disk is full", where_, "free some space"};
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return {ErrorCode::io, "another program is using the take", where_, "close it there and try again"};
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      // SQLite's plain words for this code ("database disk image is malformed") say no more than ours.
      return {ErrorCode::malformed,
              said == sqlite3_errstr(code & 0xFF) ? "the file is damaged"
                                                  : fmt::format("the file is damaged ({})", said),
              where_, kUseBackup};
    case SQLITE_TOOBIG:
      return {ErrorCode::out_of_range, "a value in it is larger than any that a take holds", where_,
              kDamagedFix};
    case SQLITE_READONLY:
    case SQLITE_PERM:
    case SQLITE_CANTOPEN:
      return {ErrorCode::io, fmt::format("it cannot be opened ({})", detail), where_,
              "check the folder and its permissions"};
    case SQLITE_IOERR:
      return {ErrorCode::io, fmt::format("the disk would not read or write ({})", detail), where_, ""};
    case SQLITE_NOMEM:
      return {ErrorCode::io, "there is not enough memory", where_, ""};
    default:
      return {ErrorCode::malformed, fmt::format("it cannot be read as a take ({})", said), where_,
              kDamagedFix};
  }
}

Result<void> Database::close() {
  sqlite3* handle = handle_.release();
  const int rc = sqlite3_close(handle);
  if (rc != SQLITE_OK) {
    handle_.reset(handle);
    return std::unexpected(error(rc));
  }
  return {};
}

std::string Row::name(int column) const {
  const char* text = sqlite3_column_name(statement_, column);
  return text == nullptr ? std::to_string(column) : text;
}

std::int64_t Row::integer(int column, std::int64_t low, std::int64_t high) {
  if (sqlite3_column_type(statement_, column) != SQLITE_INTEGER) {
    reject(name(column) + " is not a whole number");
    return 0;
  }
  const std::int64_t value = sqlite3_column_int64(statement_, column);
  if (value < low || value > high) {
    reject(fmt::format("{} is {}, not within {} to {}", name(column), value, low, high));
    return 0;
  }
  return value;
}

std::int64_t Row::time_ns(int column) {
  return integer(column, -kMaxTimeNs, kMaxTimeNs);
}

double Row::real(int column, double limit) {
  const int type = sqlite3_column_type(statement_, column);
  const double value = sqlite3_column_double(statement_, column);
  // SQLite stores NaN as NULL.
  if ((type != SQLITE_FLOAT && type != SQLITE_INTEGER) || !(std::abs(value) <= limit)) {
    reject(fmt::format("{} is not a number within +-{}", name(column), limit));
    return 0;
  }
  return value;
}

std::string Row::text(int column, std::size_t max_bytes) {
  if (sqlite3_column_type(statement_, column) != SQLITE_TEXT) {
    reject(name(column) + " is not text");
    return {};
  }
  const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(statement_, column));
  const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement_, column));
  if (text == nullptr || size > max_bytes) {
    reject(fmt::format("{} is {} bytes of text, more than {}", name(column), size, max_bytes));
    return {};
  }
  if (!is_utf8({text, size})) {
    reject(name(column) + " is not UTF-8 text");
    return {};
  }
  return {text, size};
}

std::span<const std::byte> Row::blob(int column, std::size_t max_bytes) {
  if (sqlite3_column_type(statement_, column) != SQLITE_BLOB) {
    reject(name(column) + " is not a blob");
    return {};
  }
  const void* bytes = sqlite3_column_blob(statement_, column);
  const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement_, column));
  if (size > max_bytes || (size > 0 && bytes == nullptr)) {
    reject(fmt::format("{} is {} bytes, more than {}", name(column), size, max_bytes));
    return {};
  }
  return {static_cast<const std::byte*>(bytes), size};
}

void Row::reject(std::string problem) {
  if (problem_.empty()) problem_ = std::move(problem);
}

Error Row::error(const std::string& where) const {
  // The first column of every query of ours is the row's own number.
  return {ErrorCode::out_of_range,
          fmt::format("{} {}: {}", table_, sqlite3_column_int64(statement_, 0), problem_), where,
          kDamagedFix};
}

}  // namespace mien::take
