#pragma once

#include <sqlite3.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "mien/core/error.h"

// SQLite as this room uses it; nothing outside the room includes this.

namespace mien::take {

/// One prepared statement. Bound bytes and text must live until the step is done.
class Statement {
 public:
  Statement() = default;
  explicit Statement(sqlite3_stmt* statement) : statement_(statement) {}

  void bind(int index, std::int64_t value) { sqlite3_bind_int64(statement_.get(), index, value); }
  void bind_real(int index, double value) { sqlite3_bind_double(statement_.get(), index, value); }
  void bind(int index, std::string_view text);
  void bind(int index, std::span<const std::byte> blob);

  /// SQLITE_ROW, SQLITE_DONE or an error.
  int step() { return sqlite3_step(statement_.get()); }
  /// Ready for the next row to write.
  void reset() { sqlite3_reset(statement_.get()); }
  [[nodiscard]] sqlite3_stmt* get() const { return statement_.get(); }

 private:
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
  };
  std::unique_ptr<sqlite3_stmt, Finalize> statement_;
};

/// One connection. `where` names the take in messages: the user's own path, even when a copy is open.
class Database {
 public:
  Database() = default;
  /// `flags` as for sqlite3_open_v2.
  [[nodiscard]] static Result<Database> open(const std::filesystem::path& path, int flags, std::string where);

  [[nodiscard]] Result<void> run(const char* sql);
  [[nodiscard]] Result<Statement> prepare(const char* sql) const;
  /// The first column of the first row. Errors: malformed when there is none.
  [[nodiscard]] Result<std::int64_t> read_integer(const char* sql) const;
  [[nodiscard]] Result<std::string> read_text(const char* sql) const;

  /// What SQLite's result code means to the user.
  [[nodiscard]] Error error(int code) const;
  [[nodiscard]] sqlite3* handle() const { return handle_.get(); }
  [[nodiscard]] const std::string& where() const { return where_; }
  /// Closes it and says whether that went well.
  [[nodiscard]] Result<void> close();

 private:
  struct Close {
    void operator()(sqlite3* handle) const { sqlite3_close_v2(handle); }
  };
  std::unique_ptr<sqlite3, Close> handle_;
  std::string where_;
};

/// Reads the columns of a row and remembers the first one that is not what it must be, so a reader takes the
/// whole row and asks once. A bad column reads as zero or empty.
class Row {
 public:
  Row(const Statement& statement, std::string_view table) : statement_(statement.get()), table_(table) {}

  std::int64_t integer(int column, std::int64_t low, std::int64_t high);
  /// Within +-kMaxTimeNs.
  std::int64_t time_ns(int column);
  bool flag(int column) { return integer(column, 0, 1) != 0; }
  /// Finite and within +-limit.
  double real(int column, double limit);
  std::string text(int column, std::size_t max_bytes);
  /// Valid until the next step.
  std::span<const std::byte> blob(int column, std::size_t max_bytes);
  /// For checks that span columns or rows.
  void reject(std::string problem);

  [[nodiscard]] bool ok() const { return problem_.empty(); }
  /// "log 17: arrival_ns is 5, not within ..."
  [[nodiscard]] Error error(const std::string& where) const;

 private:
  [[nodiscard]] std::string name(int column) const;

  sqlite3_stmt* statement_;
  std::string_view table_;
  std::string problem_;
};

}  // namespace mien::take
