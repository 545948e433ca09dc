#include "mien/take/row_writer.h"

#include <fmt/format.h>

#include <utility>

namespace mien::take {
namespace {

/// A reader may hold the file this long before the writer gives up.
constexpr int kWriterBusyTimeoutMs = 60'000;

std::span<const std::byte> get_bytes(ByteReader& record) {
  return record.take(static_cast<std::size_t>(record.little<std::uint64_t>()));
}
std::string_view get_text(ByteReader& record) {
  const auto bytes = get_bytes(record);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

Result<Database> open_for_writing(const std::string& file, const std::string& where) {
  MIEN_TRY_ASSIGN(Database database,
                  Database::open(file, SQLITE_OPEN_READWRITE | SQLITE_OPEN_PRIVATECACHE, where));
  sqlite3_busy_timeout(database.handle(), kWriterBusyTimeoutMs);
  // A rollback journal that is deleted at each commit: between commits the file alone is the whole take.
  // EXTRA waits for the disk also after the journal's deletion, so a committed row survives a power cut. The
  // cache holds a whole batch, so nothing is written to the file before its commit.
  MIEN_TRY(
      database.run("PRAGMA journal_mode=DELETE;PRAGMA synchronous=EXTRA;PRAGMA cache_size=-32768;"
                   "PRAGMA temp_store=MEMORY;PRAGMA mmap_size=0;PRAGMA trusted_schema=OFF"));
  return database;
}

Result<void> write_header(Database& database, const Header& header) {
  MIEN_TRY(database.run(fmt::format("PRAGMA application_id={};PRAGMA user_version={};BEGIN IMMEDIATE",
                                    kApplicationId, kPlainVersion)
                            .c_str()));
  for (const Table& table : kTables)
    if (table.since == kPlainVersion) MIEN_TRY(database.run(table.sql));
  const std::string profile = kProfile;
  MIEN_TRY_ASSIGN(Statement statement,
                  database.prepare("INSERT INTO header VALUES(1,?1,?2,?3,?4,?5,?6,?7,?8,?9,?10,?11)"));
  int column = 0;
  for (const std::string* text : {&header.software, &header.performer, &header.script, &header.devices,
                                  &header.face, &header.face_parameters, &header.prologue})
    statement.bind(++column, *text);
  statement.bind(++column, static_cast<std::int64_t>(header.seed));
  for (const std::string* text : {&header.rig_toml, &header.created_utc, &profile})
    statement.bind(++column, *text);
  if (const int rc = statement.step(); rc != SQLITE_DONE) return std::unexpected(database.error(rc));
  return database.run("COMMIT");
}

Result<void> RowWriter::prepare() {
  for (const auto& [table, sql] :
       {std::pair{TableId::source, "INSERT INTO source VALUES(?1,?2)"},
        std::pair{TableId::log, "INSERT INTO log VALUES(?1,?2,?3,?4)"},
        std::pair{TableId::tick, "INSERT INTO tick VALUES(?1,?2,?3,?4)"},
        std::pair{TableId::sample, "INSERT INTO sample VALUES(?1,?2,?3,?4,?5,?6,?7,?8,?9)"},
        std::pair{TableId::truth, "INSERT INTO truth VALUES(?1,?2,?3,?4,?5)"},
        std::pair{TableId::event, "INSERT INTO event VALUES(?1,?2,?3,?4,?5)"},
        std::pair{TableId::calibration, "INSERT INTO calibration VALUES(?1,?2,?3,?4)"},
        std::pair{TableId::audio, "INSERT INTO audio VALUES(?1,?2,?3,?4)"},
        std::pair{TableId::note, "INSERT INTO note VALUES(?1,?2,?3)"}}) {
    MIEN_TRY_ASSIGN(insert_[static_cast<std::size_t>(table)], database_.prepare(sql));
  }
  return {};
}

Result<void> RowWriter::begin_payloads() {
  MIEN_TRY(database_.run(table_of(TableId::payload).sql));
  MIEN_TRY(database_.run(fmt::format("PRAGMA user_version={}", kPayloadVersion).c_str()));
  MIEN_TRY_ASSIGN(insert(TableId::payload), database_.prepare("INSERT INTO payload VALUES(?1,?2,?3)"));
  version_ = kPayloadVersion;
  return {};
}

Result<void> RowWriter::commit(std::span<const std::byte> batch) {
  MIEN_TRY(database_.run("BEGIN IMMEDIATE"));
  ByteReader records(batch);
  Result<void> done;
  while (done && records.left() > 0) done = store(records);
  if (done) done = database_.run("COMMIT");
  // The error stands whatever the rollback says: the file is as the last commit left it, or its journal makes
  // it so.
  if (!done) static_cast<void>(database_.run("ROLLBACK"));
  return done;
}

Result<std::int64_t> RowWriter::source_id(std::string_view name) {
  if (const auto known = sources_.find(name); known != sources_.end()) return known->second;
  const std::int64_t id = next_row(TableId::source);
  insert(TableId::source).bind(1, id);
  insert(TableId::source).bind(2, name);
  MIEN_TRY(step(TableId::source));
  if (sources_.size() >= kMostSources) sources_.clear();
  sources_.emplace(name, id);
  return id;
}

Result<void> RowWriter::step(TableId table) {
  Statement& statement = insert(table);
  const int rc = statement.step();
  if (rc != SQLITE_DONE) {
    auto error = database_.error(rc);
    statement.reset();
    return std::unexpected(std::move(error));
  }
  statement.reset();
  ++rows_[static_cast<std::size_t>(table)];
  return {};
}

Result<void> RowWriter::store(ByteReader& record) {
  const auto table = static_cast<TableId>(record.little<std::uint8_t>());
  Statement& row = insert(table);
  const auto number = [&record] { return record.little<std::int64_t>(); };
  switch (table) {
    case TableId::log: {
      const std::int64_t arrival = number();
      MIEN_TRY_ASSIGN(const std::int64_t source, source_id(get_text(record)));
      row.bind(1, next_row(table));
      row.bind(2, arrival);
      row.bind(3, source);
      row.bind(4, get_bytes(record));
      break;
    }
    case TableId::tick:
      for (int column = 1; column <= 4; ++column) row.bind(column, number());
      break;
    case TableId::sample:
      row.bind(1, next_row(table));
      for (int column = 2; column <= 8; ++column) row.bind(column, number());
      row.bind(9, get_bytes(record));
      break;
    case TableId::truth:
      for (int column = 1; column <= 3; ++column) row.bind(column, number());
      row.bind_real(4, static_cast<double>(record.little<float>()));
      row.bind(5, get_bytes(record));
      break;
    case TableId::event:
      row.bind(1, next_row(table));
      row.bind(2, get_text(record));
      for (int column = 3; column <= 4; ++column) row.bind(column, number());
      row.bind(5, get_text(record));
      break;
    case TableId::calibration:
      for (int column = 1; column <= 2; ++column) row.bind(column, number());
      for (int column = 3; column <= 4; ++column) row.bind(column, get_text(record));
      break;
    case TableId::audio:
      row.bind(1, next_row(table));
      for (int column = 2; column <= 3; ++column) row.bind(column, number());
      row.bind(4, get_bytes(record));
      break;
    case TableId::note: {
      const std::string_view key = get_text(record);
      std::string value(get_text(record));
      if (key == kFinishedKey) {
        for (std::size_t i = 0; i < kTables.size(); ++i)
          if (i != static_cast<std::size_t>(TableId::header) &&
              i != static_cast<std::size_t>(TableId::note) && kTables[i].since <= version_)
            value += fmt::format("{}{} {}", value.empty() ? "" : ", ", kTables[i].name, rows_[i]);
      }
      row.bind(1, next_row(table));
      row.bind(2, key);
      row.bind(3, value);
      return step(table);
    }
    case TableId::payload:
      if (version_ < kPayloadVersion) MIEN_TRY(begin_payloads());
      row.bind(1, number());
      row.bind(2, get_text(record));
      row.bind(3, get_bytes(record));
      break;
    case TableId::header:
    case TableId::source:
      return fail(ErrorCode::internal, "a record of no kind is in the queue", database_.where());
  }
  return step(table);
}

}  // namespace mien::take
