#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>

#include "mien/core/bytes.h"
#include "mien/core/error.h"
#include "mien/core/time.h"
#include "mien/take/database.h"
#include "mien/take/layout.h"
#include "mien/take/take.h"

// How a take's rows get into its file, and the records that stand for them until then. Nothing outside the
// room includes this.
namespace mien::take {

// A record in the queue: the table's number, then the columns that the caller gave, in their order; text and
// blobs with their size before them.

inline void put_bytes(ByteWriter& queue, std::span<const std::byte> bytes) {
  queue.little(static_cast<std::uint64_t>(bytes.size()));
  queue.append(bytes);
}
inline void put_text(ByteWriter& queue, std::string_view text) {
  put_bytes(queue, std::as_bytes(std::span(text)));
}
inline void put_time(ByteWriter& queue, HostTime time) {
  queue.little(time.time_since_epoch().count());
}
inline void put_time(ByteWriter& queue, DeviceTime time) {
  queue.little(time.time_since_epoch().count());
}
inline void put_floats(ByteWriter& queue, std::span<const float> values) {
  queue.little(static_cast<std::uint64_t>(values.size_bytes()));
  for (const float value : values) queue.little(value);
}

/// The take's file, made or empty, as recordings write it. `where` names it in messages. Errors: io.
[[nodiscard]] Result<Database> open_for_writing(const std::string& file, const std::string& where);
/// Makes the tables and writes the header, in one commit. Errors: io.
[[nodiscard]] Result<void> write_header(Database& database, const Header& header);

/// Turns the records of a batch into rows: the statements, and the counts of what they stored. Thread: the
/// writer's.
class RowWriter {
 public:
  /// Sources whose rows it remembers; when there are more, it begins anew, and a source that comes again has
  /// another row. So what it takes does not grow with those who sent once.
  static constexpr std::size_t kMostSources = 4096;

  explicit RowWriter(Database& database) : database_(database) {}

  /// Before the first commit. Errors: io.
  [[nodiscard]] Result<void> prepare();
  /// Stores all records of a batch in one transaction.
  [[nodiscard]] Result<void> commit(std::span<const std::byte> batch);

 private:
  Result<void> store(ByteReader& record);
  /// From the first payload on the take is of the version that has some; within the commit.
  Result<void> begin_payloads();
  Result<void> step(TableId table);
  Result<std::int64_t> source_id(std::string_view name);
  Statement& insert(TableId table) { return insert_[static_cast<std::size_t>(table)]; }
  std::int64_t next_row(TableId table) const { return rows_[static_cast<std::size_t>(table)] + 1; }

  Database& database_;
  std::int64_t version_ = kPlainVersion;  // Of the file's layout.
  std::array<Statement, kTables.size()> insert_;
  std::array<std::int64_t, kTables.size()> rows_{};
  std::map<std::string, std::int64_t, std::less<>> sources_;
};

}  // namespace mien::take
