#include "mien/take/opening.h"

#include <fmt/format.h>
#include <stdlib.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <span>
#include <string_view>
#include <utility>

#include "mien/core/bytes.h"
#include "mien/core/excerpt.h"
#include "mien/take/layout.h"

namespace mien::take {
namespace fs = std::filesystem;
namespace {

/// A recorder's commit holds the file for this long at most, on a slow disk.
constexpr int kReaderBusyTimeoutMs = 10'000;
/// SQLite's file header (https://www.sqlite.org/fileformat2.html, section 1.3).
constexpr std::size_t kHeaderBytes = 100;
constexpr std::string_view kMagic("SQLite format 3\0", 16);
/// The end of a journal that belongs to a transaction over several files: SQLite would then open, and delete,
/// a file that the journal names. Ours never does (same page, section 3.1).
constexpr std::array<unsigned char, 8> kJournalMagic = {0xD9, 0xD5, 0x05, 0xF9, 0x20, 0xA1, 0x63, 0xD7};

fs::path journal_of(const fs::path& path) {
  return path.string() + "-journal";
}

bool has_journal(const fs::path& path) {
  std::error_code code;
  const auto size = fs::file_size(journal_of(path), code);
  return !code && size > 0;
}

/// What the first bytes say, before SQLite is let near the file.
Result<void> check_first_bytes(const fs::path& path, const std::string& where) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return fail(ErrorCode::io, std::strerror(errno), where, "check the file's permissions");
  std::array<std::byte, kHeaderBytes> first{};
  file.read(reinterpret_cast<char*>(first.data()), first.size());
  const auto count = static_cast<std::size_t>(file.gcount());
  if (count == 0) return fail(ErrorCode::bad_usage, "the file is empty", where, "name a take");
  if (count < kMagic.size() || std::memcmp(first.data(), kMagic.data(), kMagic.size()) != 0)
    return fail(ErrorCode::malformed, "this is not a take", where,
                "takes are made by mien perform or import");
  if (count < kHeaderBytes)
    return fail(ErrorCode::truncated, "the file ends inside its header", where, kUseBackup);
  const std::span<const std::byte> bytes = first;
  ByteReader at_version{bytes.subspan(60, 4)};
  ByteReader at_application{bytes.subspan(68, 4)};
  if (at_application.big<std::uint32_t>() != kApplicationId)
    return fail(ErrorCode::malformed, "this is a SQLite file of another program, not a take", where,
                "takes are made by mien perform or import");
  if (const auto version = at_version.big<std::uint32_t>();
      version < kPlainVersion || version > kPayloadVersion)
    return fail(ErrorCode::unsupported,
                fmt::format("the take's layout is version {}, and this program knows versions {} and {}",
                            version, kPlainVersion, kPayloadVersion),
                where, version > kPayloadVersion ? "use a newer mien" : kDamagedFix);
  // Bytes 18 and 19: 1 is the rollback journal, 2 the write-ahead log.
  if (first[18] != std::byte{1} || first[19] != std::byte{1})
    return fail(ErrorCode::malformed,
                "another program put the take into WAL mode, so part of it may be elsewhere", where,
                "turn it back: sqlite3 FILE 'PRAGMA journal_mode=DELETE'");
  return {};
}

Result<void> check_journal(const fs::path& path, const std::string& where) {
  std::ifstream file(journal_of(path), std::ios::binary | std::ios::ate);
  if (!file) return {};
  std::array<unsigned char, 8> last{};
  if (file.tellg() < static_cast<std::streamoff>(2 * last.size())) return {};
  file.seekg(-static_cast<std::streamoff>(last.size()), std::ios::end);
  file.read(reinterpret_cast<char*>(last.data()), last.size());
  if (last == kJournalMagic)
    return fail(ErrorCode::malformed, "the journal beside the take is not of its recording", where,
                "move the -journal file away");
  return {};
}

/// Everything that a hostile file could make SQLite do is off or small.
Result<void> protect(Database& database) {
  sqlite3* handle = database.handle();
  for (const auto& [option, value] :
       {std::pair{SQLITE_DBCONFIG_DEFENSIVE, 1}, std::pair{SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0},
        std::pair{SQLITE_DBCONFIG_ENABLE_TRIGGER, 0}, std::pair{SQLITE_DBCONFIG_ENABLE_VIEW, 0},
        std::pair{SQLITE_DBCONFIG_ENABLE_LOAD_EXTENSION, 0}, std::pair{SQLITE_DBCONFIG_WRITABLE_SCHEMA, 0},
        std::pair{SQLITE_DBCONFIG_DQS_DDL, 0}, std::pair{SQLITE_DBCONFIG_DQS_DML, 0}})
    sqlite3_db_config(handle, option, value, static_cast<int*>(nullptr));
  for (const auto& [limit, value] :
       {std::pair{SQLITE_LIMIT_LENGTH, static_cast<int>(kMaxEntryBytes + 1024)},
        std::pair{SQLITE_LIMIT_SQL_LENGTH, 4096}, std::pair{SQLITE_LIMIT_COLUMN, 16},
        std::pair{SQLITE_LIMIT_EXPR_DEPTH, 20}, std::pair{SQLITE_LIMIT_COMPOUND_SELECT, 2},
        std::pair{SQLITE_LIMIT_VDBE_OP, 10'000}, std::pair{SQLITE_LIMIT_FUNCTION_ARG, 8},
        std::pair{SQLITE_LIMIT_ATTACHED, 0}, std::pair{SQLITE_LIMIT_LIKE_PATTERN_LENGTH, 64},
        std::pair{SQLITE_LIMIT_VARIABLE_NUMBER, 16}, std::pair{SQLITE_LIMIT_TRIGGER_DEPTH, 1},
        std::pair{SQLITE_LIMIT_WORKER_THREADS, 0}})
    sqlite3_limit(handle, limit, value);
  sqlite3_busy_timeout(handle, kReaderBusyTimeoutMs);
  return database.run(
      "PRAGMA cell_size_check=ON;PRAGMA mmap_size=0;PRAGMA temp_store=MEMORY;PRAGMA query_only=ON");
}

/// Exactly the version's tables, in our words. Until this holds nothing is read from any of them.
Result<void> check_tables(const Database& database, std::int64_t version) {
  MIEN_TRY_ASSIGN(Statement statement,
                  database.prepare("SELECT rowid,type,name,tbl_name,sql FROM sqlite_schema"));
  std::size_t known = 0;
  for (;;) {
    const int rc = statement.step();
    if (rc == SQLITE_DONE) break;
    if (rc != SQLITE_ROW) return std::unexpected(database.error(rc));
    Row row(statement, "table");
    const std::string type = row.text(1, kMaxNameBytes);
    const std::string name = row.text(2, kMaxNameBytes);
    const std::string of = row.text(3, kMaxNameBytes);
    const bool has_text = row.ok();
    const std::string sql = row.text(4, 4096);
    const auto* table =
        std::ranges::find_if(kTables, [&](const Table& t) { return name == t.name && t.since <= version; });
    if (!has_text || table == kTables.end())
      return fail(ErrorCode::malformed,
                  fmt::format("it holds a {} \"{}\", which no take has", excerpt(type), excerpt(name)),
                  database.where(), "it was changed by another program; use the original");
    if (type != "table" || of != name || sql != table->sql)
      return fail(ErrorCode::malformed, fmt::format("its table \"{}\" is not as takes have it", name),
                  database.where(), kDamagedFix);
    ++known;
  }
  if (std::cmp_not_equal(
          known, std::ranges::count_if(kTables, [&](const Table& table) { return table.since <= version; })))
    return fail(ErrorCode::malformed, "a table is missing", database.where(), kDamagedFix);
  return {};
}

/// Pages that are referred to twice, out of order or lost, before they can do harm: a page that is its own
/// ancestor would read for ever.
Result<void> check_pages(const Database& database) {
  MIEN_TRY_ASSIGN(const std::string verdict, database.read_text("PRAGMA quick_check(1)"));
  return judge_pages(verdict, database.where());
}

/// Opens without checking more than that the file can be read, which is when SQLite rolls a journal back.
Result<Database> open_readable(const fs::path& path, int flags, const std::string& where) {
  MIEN_TRY_ASSIGN(Database database, Database::open(path, flags | SQLITE_OPEN_PRIVATECACHE, where));
  MIEN_TRY(protect(database));
  MIEN_TRY(database.run("BEGIN"));
  MIEN_TRY_ASSIGN([[maybe_unused]] const std::int64_t version,
                  database.read_integer("PRAGMA schema_version"));
  return database;
}

Result<void> copy(const fs::path& from, const fs::path& to, const std::string& where) {
  std::error_code code;
  fs::copy_file(from, to, code);
  if (code)
    return fail(
        ErrorCode::io,
        fmt::format("its recording was cut off, and the copy to recover it on could not be made ({})",
                    code.message()),
        where,
        fmt::format("free space in {}, or make the take's folder writable", to.parent_path().string()));
  return {};
}

Result<OpenTake> recover_on_copy(const fs::path& path, const std::string& where) {
  OpenTake open;
  MIEN_TRY_ASSIGN(open.folder, TemporaryFolder::make());
  const fs::path twin = open.folder.path() / "take";
  MIEN_TRY(copy(path, twin, where));
  MIEN_TRY(copy(journal_of(path), journal_of(twin), where));
  // The copies bear the originals' modes, which may forbid writing.
  std::error_code code;
  fs::permissions(twin, fs::perms::owner_read | fs::perms::owner_write, code);
  fs::permissions(journal_of(twin), fs::perms::owner_read | fs::perms::owner_write, code);
  MIEN_TRY_ASSIGN(open.database, open_readable(twin, SQLITE_OPEN_READWRITE, where));
  MIEN_TRY(check_first_bytes(twin, where));
  return open;
}

Result<OpenTake> open_or_recover(const fs::path& path, const std::string& where) {
  const auto first_bytes = check_first_bytes(path, where);
  if (!first_bytes) {
    // A power cut inside a commit may have torn the first page; the journal has the old one.
    if (!has_journal(path)) return std::unexpected(first_bytes.error());
    MIEN_TRY(check_journal(path, where));
    auto recovered = recover_on_copy(path, where);
    if (!recovered) return std::unexpected(first_bytes.error());
    return recovered;
  }
  OpenTake open;
  auto readable = open_readable(path, SQLITE_OPEN_READONLY, where);
  if (!readable && has_journal(path)) {
    MIEN_TRY(check_journal(path, where));
    readable = open_readable(path, SQLITE_OPEN_READWRITE, where);
    if (!readable) return recover_on_copy(path, where);
    MIEN_TRY(check_first_bytes(path, where));
  }
  if (!readable) return std::unexpected(readable.error());
  open.database = std::move(*readable);
  return open;
}

}  // namespace

Result<void> judge_pages(std::string_view verdict, const std::string& where) {
  if (verdict == "ok") return {};
  // "*** in database main ***" stands above what is wrong, and says nothing.
  if (verdict.starts_with("***")) verdict.remove_prefix(std::min(verdict.find('\n'), verdict.size() - 1) + 1);
  const std::string why = excerpt(verdict.substr(0, verdict.find('\n')), kComplaintLetters);
  return fail(ErrorCode::malformed,
              why.empty() ? "the file is damaged" : fmt::format("the file is damaged ({})", why), where,
              kUseBackup);
}

Result<TemporaryFolder> TemporaryFolder::make() {
  std::error_code code;
  std::string name = (fs::temp_directory_path(code) / "mien-take-XXXXXX").string();
  if (code || ::mkdtemp(name.data()) == nullptr)
    return fail(ErrorCode::io, "no temporary folder can be made", name,
                "set TMPDIR to a folder that can be written");
  TemporaryFolder folder;
  folder.path_ = name;
  return folder;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code code;
  if (!path_.empty()) fs::remove_all(path_, code);
}

Result<OpenTake> open_untrusted(const fs::path& path) {
  const std::string where = path.string();
  std::error_code code;
  const fs::file_status status = fs::status(path, code);
  if (status.type() == fs::file_type::not_found)
    return fail(ErrorCode::not_found, "there is no such file", where);
  if (!fs::status_known(status))
    return fail(ErrorCode::io, code.message(), where, "check the folder and its permissions");
  if (!fs::is_regular_file(status))
    return fail(ErrorCode::bad_usage, "this is not a file", where, "name a take");
  MIEN_TRY_ASSIGN(OpenTake open, open_or_recover(path, where));
  MIEN_TRY_ASSIGN(open.version, open.database.read_integer("PRAGMA user_version"));
  MIEN_TRY(check_tables(open.database, open.version));
  MIEN_TRY(check_pages(open.database));
  return open;
}

}  // namespace mien::take
