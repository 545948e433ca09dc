#include <fcntl.h>
#include <fmt/format.h>
#include <stdio.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstring>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

#include "mien/core/bytes.h"
#include "mien/take/database.h"
#include "mien/take/layout.h"
#include "mien/take/take.h"
#include "mien/take/utf8.h"

namespace mien::take {
namespace fs = std::filesystem;
namespace {

/// A commit comes this long after the first thing that it holds, and so leaves a good half second of disk
/// time within the promised second.
constexpr std::chrono::milliseconds kCommitDelay{250};
/// Or as soon as this much has gathered, when a take is written as fast as it can be.
constexpr std::size_t kCommitBytes = std::size_t{4} << 20U;
/// The caller waits when this much is under way.
constexpr std::size_t kQueueBytes = std::size_t{16} << 20U;
/// A reader may hold the file this long before the writer gives up.
constexpr int kWriterBusyTimeoutMs = 60'000;

/// Makes a new take at `path` in one piece: it is filled under another name and then renamed, so at any
/// moment there is no take, the old one, or the new one.
class NewFile {
 public:
  explicit NewFile(fs::path path) : path_(std::move(path)), name_(path_.string() + ".XXXXXX") {}
  NewFile(const NewFile&) = delete;
  NewFile& operator=(const NewFile&) = delete;
  ~NewFile() {
    if (!made_) return;
    ::unlink(name_.c_str());
    ::unlink((name_ + "-journal").c_str());
  }

  Result<void> make() {
    const int file = ::mkstemp(name_.data());
    if (file < 0)
      return fail(ErrorCode::io, std::strerror(errno), path_.string(),
                  "check the folder and its permissions");
    made_ = true;
    // mkstemp makes it private; give it what a plain creation would have had.
    const mode_t mask = ::umask(0);
    ::umask(mask);
    const bool changed = ::fchmod(file, 0666 & ~mask) == 0;
    const int problem = errno;
    ::close(file);
    if (!changed) return fail(ErrorCode::io, std::strerror(problem), path_.string());
    return {};
  }

  Result<void> put_in_place(bool replace) {
    if (!replace && fs::exists(fs::symlink_status(path_)))
      return fail(ErrorCode::bad_usage, "a file of this name has appeared meanwhile", path_.string(),
                  "choose another name, or replace it with --force");
    // What an older take left beside itself would be rolled back into the new one; should this fail, it is
    // the older one's again.
    const std::string journal = path_.string() + "-journal", aside = name_ + "-older-journal";
    const bool set_aside = ::rename(journal.c_str(), aside.c_str()) == 0;
    int done = -1;
    if (replace) {
      done = ::rename(name_.c_str(), path_.c_str());
    } else {
      done = ::renameat2(AT_FDCWD, name_.c_str(), AT_FDCWD, path_.c_str(), RENAME_NOREPLACE);
      // Some file systems cannot; the check at the start stands for it there.
      if (done != 0 && (errno == EINVAL || errno == ENOSYS)) done = ::rename(name_.c_str(), path_.c_str());
    }
    if (done != 0) {
      const int problem = errno;
      if (set_aside) ::rename(aside.c_str(), journal.c_str());
      return fail(ErrorCode::io, std::strerror(problem), path_.string());
    }
    if (set_aside) ::unlink(aside.c_str());
    made_ = false;
    const fs::path folder = path_.has_parent_path() ? path_.parent_path() : fs::path(".");
    const int handle = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (handle >= 0) {
      ::fsync(handle);
      ::close(handle);
    }
    return {};
  }

  [[nodiscard]] const std::string& name() const { return name_; }

 private:
  fs::path path_;
  std::string name_;
  bool made_ = false;
};

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
                                    kApplicationId, kUserVersion)
                            .c_str()));
  for (const Table& table : kTables) MIEN_TRY(database.run(table.sql));
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

/// The statements and the counts of what they stored; lives in the writer thread.
class RowWriter {
 public:
  explicit RowWriter(Database& database) : database_(database) {}

  Result<void> prepare() {
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

  /// Stores all records of a batch in one transaction.
  Result<void> commit(std::span<const std::byte> batch);

 private:
  Result<void> store(ByteReader& record);
  Result<void> step(TableId table);
  Result<std::int64_t> source_id(std::string_view name);
  Statement& insert(TableId table) { return insert_[static_cast<std::size_t>(table)]; }
  std::int64_t next_row(TableId table) const { return rows_[static_cast<std::size_t>(table)] + 1; }

  Database& database_;
  std::array<Statement, kTables.size()> insert_;
  std::array<std::int64_t, kTables.size()> rows_{};
  std::map<std::string, std::int64_t, std::less<>> sources_;
};

// A record in the queue: the table's number, then the columns that the caller gave, in their order; text and
// blobs with their size before them.

void put_bytes(ByteWriter& queue, std::span<const std::byte> bytes) {
  queue.little(static_cast<std::uint64_t>(bytes.size()));
  queue.append(bytes);
}
void put_text(ByteWriter& queue, std::string_view text) {
  put_bytes(queue, std::as_bytes(std::span(text)));
}
void put_time(ByteWriter& queue, HostTime time) {
  queue.little(time.time_since_epoch().count());
}
void put_time(ByteWriter& queue, DeviceTime time) {
  queue.little(time.time_since_epoch().count());
}
void put_floats(ByteWriter& queue, std::span<const float> values) {
  queue.little(static_cast<std::uint64_t>(values.size_bytes()));
  for (const float value : values) queue.little(value);
}

std::span<const std::byte> get_bytes(ByteReader& record) {
  return record.take(static_cast<std::size_t>(record.little<std::uint64_t>()));
}
std::string_view get_text(ByteReader& record) {
  const auto bytes = get_bytes(record);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
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
          if (i != static_cast<std::size_t>(TableId::header) && i != static_cast<std::size_t>(TableId::note))
            value += fmt::format("{}{} {}", value.empty() ? "" : ", ", kTables[i].name, rows_[i]);
      }
      row.bind(1, next_row(table));
      row.bind(2, key);
      row.bind(3, value);
      return step(table);
    }
    case TableId::header:
    case TableId::source:
      return fail(ErrorCode::internal, "a record of no kind is in the queue", database_.where());
  }
  return step(table);
}

bool is_time(std::int64_t ns) {
  return ns >= -kMaxTimeNs && ns <= kMaxTimeNs;
}
template <class Clock>
bool is_time(std::chrono::time_point<Clock, Duration> time) {
  return is_time(time.time_since_epoch().count());
}
bool is_text(std::string_view text, std::size_t max_bytes) {
  return text.size() <= max_bytes && is_utf8(text);
}
bool all_finite(std::span<const float> values) {
  for (const float value : values)
    if (!std::isfinite(value)) return false;
  return true;
}

}  // namespace

struct TakeWriter::State {
  State(fs::path file, std::size_t sensors) : path(std::move(file)), sensor_count(sensors) {}

  // The caller's side: what has been added so far, for checking what comes.
  fs::path path;
  std::size_t sensor_count;
  std::int64_t entries = 0;
  HostTime last_arrival = HostTime::min();
  std::int64_t last_sample_entry = 0;
  std::optional<Tick> last_tick;
  std::optional<DeviceTime> last_truth;
  std::int64_t last_calibration = 0;
  int pcm_rate_hz = 0;
  DeviceTime pcm_end;
  std::optional<Result<void>> finished;

  // Shared with the writer thread, under the mutex.
  mutable std::mutex mutex;
  std::condition_variable has_work;
  std::condition_variable has_space;
  ByteWriter queue;
  bool stop = false;
  std::optional<Error> error;

  // Where the take does not appear before it is whole: goes with the writer unless finish() puts it in place.
  std::unique_ptr<NewFile> unfinished;
  bool replace = false;

  // The writer thread's.
  Database database;
  std::thread thread;

  ~State() {
    if (thread.joinable()) {
      {
        const std::lock_guard lock(mutex);
        stop = true;
      }
      has_work.notify_one();
      thread.join();
    }
  }

  void keep(Error first) {
    {
      const std::lock_guard lock(mutex);
      if (!error) error = std::move(first);
    }
    has_space.notify_all();
  }
  void refuse(std::string what) {
    keep({ErrorCode::out_of_range, std::move(what), path.string(),
          "the recording ends here; what came before is kept"});
  }

  /// Appends one record: `put` writes its columns.
  template <class Put>
  void add(TableId table, std::size_t bytes, Put put) {
    if (finished)
      return keep(
          {ErrorCode::bad_usage, "something was added after the take was finished", path.string(), ""});
    std::unique_lock lock(mutex);
    has_space.wait(
        lock, [&] { return error || queue.bytes().empty() || queue.bytes().size() + bytes <= kQueueBytes; });
    if (error) return;
    const bool was_empty = queue.bytes().empty();
    queue.little(static_cast<std::uint8_t>(table));
    put(queue);
    const bool wake = was_empty || queue.bytes().size() >= kCommitBytes;
    lock.unlock();
    if (wake) has_work.notify_one();
  }

  void write_batches() {
    RowWriter rows(database);
    if (auto ready = rows.prepare(); !ready) return keep(std::move(ready).error());
    ByteWriter batch;
    for (;;) {
      {
        std::unique_lock lock(mutex);
        has_work.wait(lock, [&] { return stop || !queue.bytes().empty(); });
        has_work.wait_for(lock, kCommitDelay, [&] { return stop || queue.bytes().size() >= kCommitBytes; });
        if (queue.bytes().empty()) return;
        batch.clear();
        std::swap(batch, queue);
      }
      has_space.notify_all();
      if (auto stored = rows.commit(batch.bytes()); !stored) return keep(std::move(stored).error());
    }
  }

  void run() {
    try {
      write_batches();
    } catch (const std::exception& exception) {
      keep({ErrorCode::io, fmt::format("storing the take failed ({})", exception.what()), path.string(), ""});
    }
  }
};

TakeWriter::TakeWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}
TakeWriter::TakeWriter(TakeWriter&&) noexcept = default;

TakeWriter& TakeWriter::operator=(TakeWriter&& other) noexcept {
  if (this != &other) {
    if (state_ && !state_->unfinished) static_cast<void>(finish());
    state_ = std::move(other.state_);
  }
  return *this;
}

TakeWriter::~TakeWriter() {
  if (state_ && !state_->unfinished) static_cast<void>(finish());
}

Result<TakeWriter> TakeWriter::create(const fs::path& path, const Header& header, bool replace,
                                      Appears appears) {
  const std::string where = path.string();
  std::error_code code;
  const fs::file_status status = fs::status(path, code);
  if (path.empty() || (fs::exists(status) && !fs::is_regular_file(status)))
    return fail(ErrorCode::bad_usage, "a take is a file, not a folder or a device", where,
                "name a file such as take.mien");
  if (path.has_parent_path() && !fs::is_directory(path.parent_path(), code))
    return fail(ErrorCode::not_found, "there is no such folder", path.parent_path().string(),
                "make it first");
  if (fs::exists(fs::symlink_status(path, code)) && !replace)
    return fail(ErrorCode::bad_usage, "the file exists already", where,
                "choose another name, or replace it with --force");
  MIEN_TRY_ASSIGN(const sensor::Rig rig, sensor::parse_rig(header.rig_toml, "the take's rig"));
  for (const std::string* text :
       {&header.software, &header.performer, &header.script, &header.devices, &header.face,
        &header.face_parameters, &header.prologue, &header.rig_toml, &header.created_utc})
    if (!is_text(*text, kMaxTextBytes))
      return fail(ErrorCode::out_of_range,
                  fmt::format("a text of the header (\"{}\") is not UTF-8, or longer than {} bytes",
                              is_utf8(*text) ? text->substr(0, 40) : "?", kMaxTextBytes),
                  where, "rename the file that it names, or shorten it");

  auto file = std::make_unique<NewFile>(path);
  MIEN_TRY(file->make());
  {
    MIEN_TRY_ASSIGN(Database fresh, open_for_writing(file->name(), where));
    MIEN_TRY(write_header(fresh, header));
    MIEN_TRY(fresh.close());
  }
  auto state = std::make_unique<State>(path, rig.sensors.size());
  if (appears == Appears::at_once) {
    MIEN_TRY(file->put_in_place(replace));
    MIEN_TRY_ASSIGN(state->database, open_for_writing(path.string(), where));
  } else {
    MIEN_TRY_ASSIGN(state->database, open_for_writing(file->name(), where));
    state->unfinished = std::move(file);
    state->replace = replace;
  }
  state->thread = std::thread([owner = state.get()] { owner->run(); });
  return TakeWriter(std::move(state));
}

std::int64_t TakeWriter::add_entry(HostTime arrival, std::string_view source,
                                   std::span<const std::byte> bytes) {
  State& s = *state_;
  const std::int64_t id = ++s.entries;
  if (!is_time(arrival) || arrival < s.last_arrival)
    s.refuse(fmt::format("log entry {} arrives before the one that came before it, or at no time", id));
  else if (!is_text(source, kMaxNameBytes))
    s.refuse(
        fmt::format("the source of log entry {} is not UTF-8, or longer than {} bytes", id, kMaxNameBytes));
  else if (bytes.size() > kMaxEntryBytes)
    s.refuse(fmt::format("log entry {} is longer than {} bytes", id, kMaxEntryBytes));
  s.last_arrival = arrival;
  s.add(TableId::log, bytes.size(), [&](ByteWriter& queue) {
    put_time(queue, arrival);
    put_text(queue, source);
    put_bytes(queue, bytes);
  });
  return id;
}

void TakeWriter::add_sample(std::int64_t entry, HostTime arrival, const sensor::Sample& sample) {
  State& s = *state_;
  if (entry < s.last_sample_entry || entry > s.entries)
    s.refuse(fmt::format("a sample of log entry {} comes after those of entry {}, of {} entries", entry,
                         s.last_sample_entry, s.entries));
  else if (sample.sensor >= s.sensor_count)
    s.refuse(fmt::format("a sample is of sensor {}, and the rig has {}", sample.sensor, s.sensor_count));
  else if (sample.count > sensor::kMaxSampleValues || !all_finite(sample.used()))
    s.refuse(fmt::format("a sample of sensor {} has a value that is not finite, or too many", sample.sensor));
  else if (sample.kind == sensor::SampleKind{} || !is_time(sample.time) || !is_time(arrival))
    s.refuse(fmt::format("a sample of sensor {} has no kind or no time", sample.sensor));
  s.last_sample_entry = entry;
  s.add(TableId::sample, 0, [&](ByteWriter& queue) {
    queue.little(entry);
    put_time(queue, arrival);
    queue.little(static_cast<std::int64_t>(sample.sensor));
    queue.little(static_cast<std::int64_t>(sample.kind));
    queue.little(static_cast<std::int64_t>(sample.sequence));
    put_time(queue, sample.time);
    queue.little(static_cast<std::int64_t>(sample.time_estimated));
    put_floats(queue, sample.used());
  });
}

void TakeWriter::add_tick(const Tick& tick) {
  State& s = *state_;
  const std::int64_t known = s.last_tick ? s.last_tick->after_entry : 0;
  if (tick.after_entry < known || tick.after_entry > s.entries)
    s.refuse(fmt::format("tick {} fires after log entry {}, the one before it after {}, of {} entries",
                         tick.index, tick.after_entry, known, s.entries));
  else if (s.last_tick && (tick.index <= s.last_tick->index || tick.frame <= s.last_tick->frame))
    s.refuse(fmt::format("tick {} comes after tick {}: frames ascend", tick.index, s.last_tick->index));
  else if (std::abs(tick.index) > kMaxFrame || !is_time(tick.fired) || !is_time(tick.frame))
    s.refuse(fmt::format("tick {} has no time", tick.index));
  s.last_tick = tick;
  s.add(TableId::tick, 0, [&](ByteWriter& queue) {
    queue.little(tick.index);
    queue.little(tick.after_entry);
    put_time(queue, tick.fired);
    put_time(queue, tick.frame);
  });
}

void TakeWriter::add_truth(const TruthFrame& truth) {
  State& s = *state_;
  const auto in_range = [](float weight) { return std::abs(weight) <= static_cast<float>(kMaxWeight); };
  bool all_in_range = in_range(truth.tongue_out);
  for (const float weight : truth.weights.values) all_in_range = all_in_range && in_range(weight);
  if (!is_time(truth.time) || (s.last_truth && truth.time <= *s.last_truth))
    s.refuse(fmt::format("the truth at {} s does not come after the one before it",
                         to_seconds(truth.time.time_since_epoch())));
  else if (!all_in_range)
    s.refuse(fmt::format("the truth at {} s has a weight that is not within +-{}",
                         to_seconds(truth.time.time_since_epoch()), kMaxWeight));
  s.last_truth = truth.time;
  s.add(TableId::truth, 0, [&](ByteWriter& queue) {
    put_time(queue, truth.time);
    queue.little(static_cast<std::int64_t>(truth.has_face));
    queue.little(static_cast<std::int64_t>(truth.evaluated));
    queue.little(truth.tongue_out);
    put_floats(queue, truth.weights.values);
  });
}

void TakeWriter::add_event(const Event& event) {
  State& s = *state_;
  if (!is_time(event.begin) || !is_time(event.end) || event.end < event.begin)
    s.refuse(fmt::format("the event \"{}\" ends before it begins, or at no time", event.kind));
  else if (!is_text(event.kind, kMaxNameBytes) || !is_text(event.json, kMaxTextBytes))
    s.refuse("an event is not UTF-8, or longer than a take holds");
  s.add(TableId::event, event.json.size(), [&](ByteWriter& queue) {
    put_text(queue, event.kind);
    put_time(queue, event.begin);
    put_time(queue, event.end);
    put_text(queue, event.json);
  });
}

void TakeWriter::add_calibration(const CalibrationVersion& calibration) {
  State& s = *state_;
  const std::int64_t id = calibration.id == 0 ? s.last_calibration + 1 : calibration.id;
  if (id <= s.last_calibration)
    s.refuse(fmt::format("calibration {} comes after calibration {}", id, s.last_calibration));
  else if (!is_time(calibration.made))
    s.refuse(fmt::format("calibration {} has no time", id));
  else if (!is_text(calibration.modality, kMaxNameBytes) || !is_text(calibration.json, kMaxTextBytes))
    s.refuse(fmt::format("calibration {} is not UTF-8, or longer than a take holds", id));
  s.last_calibration = id;
  s.add(TableId::calibration, calibration.json.size(), [&](ByteWriter& queue) {
    queue.little(id);
    put_time(queue, calibration.made);
    put_text(queue, calibration.modality);
    put_text(queue, calibration.json);
  });
}

void TakeWriter::add_audio(int rate_hz, DeviceTime start, std::span<const float> samples) {
  State& s = *state_;
  if (samples.empty()) return;
  if (rate_hz < kMinPcmRateHz || rate_hz > kMaxPcmRateHz)
    return s.refuse(fmt::format("sound of {} samples a second is not within {} to {}", rate_hz, kMinPcmRateHz,
                                kMaxPcmRateHz));
  if (!is_time(start) || !all_finite(samples))
    return s.refuse("sound has a sample that is not finite, or no time");
  if (s.pcm_rate_hz != 0) {
    if (rate_hz != s.pcm_rate_hz)
      return s.refuse(fmt::format("sound of {} Hz follows sound of {} Hz", rate_hz, s.pcm_rate_hz));
    if (std::abs((start - s.pcm_end).count()) > kPcmJoinNs)
      return s.refuse(fmt::format("sound begins {:.3f} s after the sound before it ended",
                                  to_seconds(start - s.pcm_end)));
  }
  const auto offset = [&](std::size_t count) { return from_seconds(static_cast<double>(count) / rate_hz); };
  for (std::size_t done = 0; done < samples.size();) {
    const auto piece = samples.subspan(done, std::min(kMaxPcmSamples, samples.size() - done));
    s.add(TableId::audio, piece.size_bytes(), [&](ByteWriter& queue) {
      queue.little(static_cast<std::int64_t>(rate_hz));
      put_time(queue, start + offset(done));
      put_floats(queue, piece);
    });
    done += piece.size();
  }
  s.pcm_rate_hz = rate_hz;
  s.pcm_end = start + offset(samples.size());
}

void TakeWriter::add_note(std::string_view key, std::string_view value) {
  State& s = *state_;
  if (key.empty() || !is_text(key, kMaxNameBytes) || key == kFinishedKey || !is_text(value, kMaxTextBytes))
    s.refuse("a note has no key, one that is reserved, is not UTF-8, or is longer than a take holds");
  s.add(TableId::note, value.size(), [&](ByteWriter& queue) {
    put_text(queue, key);
    put_text(queue, value);
  });
}

Result<void> TakeWriter::status() const {
  const std::lock_guard lock(state_->mutex);
  if (state_->error) return std::unexpected(*state_->error);
  return {};
}

Result<void> TakeWriter::finish() {
  State& s = *state_;
  if (s.finished) return *s.finished;
  s.add(TableId::note, 0, [](ByteWriter& queue) {
    put_text(queue, kFinishedKey);
    put_text(queue, "");
  });
  {
    const std::lock_guard lock(s.mutex);
    s.stop = true;
  }
  s.has_work.notify_one();
  s.thread.join();
  const auto closed = s.database.close();
  s.finished = s.error ? Result<void>(std::unexpected(*s.error)) : closed;
  if (s.unfinished) {
    if (*s.finished) s.finished = s.unfinished->put_in_place(s.replace);
    s.unfinished.reset();
  }
  return *s.finished;
}

}  // namespace mien::take
