#include "mien/take/take.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "mien/core/excerpt.h"
#include "mien/take/layout.h"
#include "mien/take/opening.h"

namespace mien::take {
namespace {

DeviceTime device_time(std::int64_t ns) {
  return DeviceTime(Duration(ns));
}
HostTime host_time(std::int64_t ns) {
  return HostTime(Duration(ns));
}

/// Reads a blob of floats that must all be finite and within +-limit. Shape: `to` has at least as many.
void read_floats(Row& row, int column, std::span<const std::byte> blob, std::span<float> to, double limit) {
  load_little(blob, to);
  for (const float value : to)
    if (!(std::abs(value) <= limit))
      return row.reject(fmt::format("a number in column {} is {}, not within +-{}", column, value, limit));
}

constexpr double kAnyFinite = std::numeric_limits<float>::max();

}  // namespace

struct Take::State {
  std::filesystem::path path;
  OpenTake open;
  Header header;
  sensor::Rig rig;
  bool finished = false;
  std::string counts;  // What finish() noted.
  std::array<std::optional<std::int64_t>, kTables.size()>
      last_row;                      // Keys beyond were added after we opened.
  std::vector<std::string> sources;  // By id - 1.

  [[nodiscard]] const std::string& where() const { return open.database.where(); }
  [[nodiscard]] std::optional<std::int64_t> last_row_of(TableId id) const {
    return last_row[static_cast<std::size_t>(id)];
  }
  [[nodiscard]] std::int64_t entry_count() const { return last_row_of(TableId::log).value_or(0); }

  /// A table in the order of its key, up to what was there when the take was opened. `columns`: those after
  /// the key. None when the table is empty.
  [[nodiscard]] Result<std::optional<Statement>> open_rows(TableId id, std::string_view columns) const {
    const Table& table = table_of(id);
    const auto last = last_row_of(id);
    if (!last) return std::nullopt;
    const std::string sql =
        fmt::format("SELECT {0},{1} FROM {2} WHERE {0}<=?1 ORDER BY {0}", table.key, columns, table.name);
    MIEN_TRY_ASSIGN(Statement statement, open.database.prepare(sql.c_str()));
    statement.bind(1, *last);
    return statement;
  }

  /// On to the next of such rows. False at their end, where there are none any more.
  [[nodiscard]] Result<bool> step(std::optional<Statement>& rows) const {
    const int rc = rows ? rows->step() : SQLITE_DONE;
    if (rc == SQLITE_ROW) return true;
    if (rc != SQLITE_DONE) return std::unexpected(open.database.error(rc));
    rows.reset();
    return false;
  }

  /// Goes through such a table: `read(row, key)` of each row, which it may reject.
  template <class Read>
  [[nodiscard]] Result<void> visit(TableId id, std::string_view columns, const Read& read) const {
    MIEN_TRY_ASSIGN(std::optional<Statement> rows, open_rows(id, columns));
    std::optional<std::int64_t> previous;
    for (;;) {
      MIEN_TRY_ASSIGN(const bool more, step(rows));
      if (!more) return {};
      Row row(*rows, table_of(id).name);
      // Also what ends the reading of a file whose pages go round in a circle.
      const std::int64_t key = sqlite3_column_int64(rows->get(), 0);
      if (previous && key <= *previous) row.reject(fmt::format("it comes after {}", *previous));
      previous = key;
      read(row, key);
      if (!row.ok()) return std::unexpected(row.error(where()));
    }
  }

  /// Reads such a table; `read` turns a row into an item, or rejects the row.
  template <class Item, class Read>
  [[nodiscard]] Result<std::vector<Item>> read_all(TableId id, std::string_view columns, Read read) const {
    std::vector<Item> items;
    MIEN_TRY(visit(id, columns, [&](Row& row, std::int64_t key) { items.push_back(read(row, key)); }));
    return items;
  }

  [[nodiscard]] Result<void> read_header();
  [[nodiscard]] Result<void> read_bounds();
};

Result<void> Take::State::read_bounds() {
  for (std::size_t i = 0; i < kTables.size(); ++i) {
    if (kTables[i].since > open.version) continue;
    MIEN_TRY_ASSIGN(Statement statement,
                    open.database.prepare(
                        fmt::format("SELECT max({}) FROM {}", kTables[i].key, kTables[i].name).c_str()));
    if (const int rc = statement.step(); rc != SQLITE_ROW) return std::unexpected(open.database.error(rc));
    if (sqlite3_column_type(statement.get(), 0) == SQLITE_INTEGER)
      last_row[i] = sqlite3_column_int64(statement.get(), 0);
  }
  return {};
}

Result<void> Take::State::read_header() {
  MIEN_TRY_ASSIGN(
      auto headers,
      read_all<Header>(
          TableId::header,
          "software,performer,script,devices,face,face_parameters,prologue,seed,rig_toml,created_utc,profile",
          [](Row& row, std::int64_t) {
            Header read;
            int column = 0;
            for (std::string* text : {&read.software, &read.performer, &read.script, &read.devices,
                                      &read.face, &read.face_parameters, &read.prologue})
              *text = row.text(++column, kMaxTextBytes);
            read.seed =
                static_cast<std::uint64_t>(row.integer(++column, std::numeric_limits<std::int64_t>::min(),
                                                       std::numeric_limits<std::int64_t>::max()));
            for (std::string* text : {&read.rig_toml, &read.created_utc})
              *text = row.text(++column, kMaxTextBytes);
            if (row.text(++column, kMaxNameBytes) != kProfile)
              row.reject("its weights are of a profile that this program does not know");
            return read;
          }));
  if (headers.size() != 1)
    return fail(ErrorCode::malformed, fmt::format("it has {} headers, not one", headers.size()), where(),
                kDamagedFix);
  header = std::move(headers.front());
  MIEN_TRY_ASSIGN(rig, sensor::parse_rig(header.rig_toml, where() + ": rig"));
  MIEN_TRY_ASSIGN(sources, read_all<std::string>(TableId::source, "name", [](Row& row, std::int64_t) {
                    return row.text(1, kMaxNameBytes);
                  }));
  if (last_row_of(TableId::source).value_or(0) != std::ssize(sources))
    return fail(ErrorCode::malformed, "the sources are not numbered from 1", where(), kDamagedFix);
  return {};
}

Take::Take(std::unique_ptr<State> state) : state_(std::move(state)) {}
Take::Take(Take&&) noexcept = default;
Take& Take::operator=(Take&&) noexcept = default;
Take::~Take() = default;

Result<Take> Take::open(const std::filesystem::path& path) {
  auto take = open_and_check(path);
  if (take) return take;
  // What a foreign file calls its tables or writes into its rig is told, but it does not get to break the
  // line or to command the terminal.
  Error error = std::move(take).error();
  error.what = without_controls(error.what);
  return std::unexpected(std::move(error));
}

Result<Take> Take::open_and_check(const std::filesystem::path& path) {
  auto state = std::make_unique<State>();
  state->path = path;
  MIEN_TRY_ASSIGN(state->open, open_untrusted(path));
  // All within the transaction that open_untrusted() began: one moment of the file.
  MIEN_TRY(state->read_bounds());
  MIEN_TRY(state->read_header());
  Take take(std::move(state));
  MIEN_TRY_ASSIGN(const auto notes, take.notes());
  for (const Note& note : notes) {
    if (note.key != kFinishedKey) continue;
    take.state_->finished = true;
    take.state_->counts = note.value;
  }
  MIEN_TRY(take.state_->open.database.run("COMMIT"));
  return take;
}

const std::filesystem::path& Take::path() const {
  return state_->path;
}
const Header& Take::header() const {
  return state_->header;
}
const sensor::Rig& Take::rig() const {
  return state_->rig;
}
bool Take::finished() const {
  return state_->finished;
}

struct EntryReader::State {
  const Take::State* take = nullptr;
  std::optional<Statement> rows;  // None: the end.
  LogEntry entry;

  /// On to the next entry, or to the end.
  [[nodiscard]] Result<void> advance() {
    MIEN_TRY_ASSIGN(const bool more, take->step(rows));
    if (!more) return {};
    Row row(*rows, table_of(TableId::log).name);
    // Also what ends the reading of a file whose pages go round in a circle.
    if (sqlite3_column_int64(rows->get(), 0) != ++entry.id)
      row.reject(fmt::format("entry {} is missing", entry.id));
    entry.arrival = host_time(row.integer(1, entry.arrival.time_since_epoch().count(), kMaxTimeNs));
    const std::int64_t source = row.integer(2, 1, static_cast<std::int64_t>(take->sources.size()));
    if (row.ok()) entry.source = take->sources[static_cast<std::size_t>(source - 1)];
    const auto bytes = row.blob(3, kMaxEntryBytes);
    entry.bytes.assign(bytes.begin(), bytes.end());
    if (!row.ok()) return std::unexpected(row.error(take->where()));
    return {};
  }
};

EntryReader::EntryReader(std::unique_ptr<State> state) : state_(std::move(state)) {}
EntryReader::EntryReader(EntryReader&&) noexcept = default;
EntryReader& EntryReader::operator=(EntryReader&&) noexcept = default;
EntryReader::~EntryReader() = default;

Result<const LogEntry*> EntryReader::next() {
  MIEN_TRY(state_->advance());
  return state_->rows ? &state_->entry : nullptr;
}

Result<EntryReader> Take::log() const {
  auto reader = std::make_unique<EntryReader::State>();
  reader->take = state_.get();
  reader->entry.arrival = host_time(-kMaxTimeNs);
  MIEN_TRY_ASSIGN(reader->rows, state_->open_rows(TableId::log, "arrival_ns,source,bytes"));
  return EntryReader(std::move(reader));
}

Result<std::vector<LogEntry>> Take::entries() const {
  std::vector<LogEntry> entries;
  MIEN_TRY_ASSIGN(EntryReader reader, log());
  for (;;) {
    MIEN_TRY_ASSIGN(const LogEntry* const entry, reader.next());
    if (entry == nullptr) return entries;
    entries.push_back(*entry);
  }
}

struct PayloadReader::State {
  const Take::State* take = nullptr;
  std::optional<Statement> rows;  // None: the end.
  std::int64_t entry = 0;         // Of the row that stands; 0 before the first.
  std::string reducer;
  std::span<const std::byte> bytes;

  /// On to the next row, or to the end.
  [[nodiscard]] Result<void> advance() {
    MIEN_TRY_ASSIGN(const bool more, take->step(rows));
    if (!more) return {};
    Row row(*rows, table_of(TableId::payload).name);
    entry = row.integer(0, entry + 1, take->entry_count());
    reducer = row.text(1, sensor::kReducerHashDigits);
    if (!reducer.empty() && !sensor::is_reducer_hash(reducer)) row.reject("its reducer is no SHA-256");
    bytes = row.blob(2, sensor::kMaxPayload);
    if (bytes.empty()) row.reject("it has no bytes");
    if (!row.ok()) return std::unexpected(row.error(take->where()));
    return {};
  }
};

PayloadReader::PayloadReader(std::unique_ptr<State> state) : state_(std::move(state)) {}
PayloadReader::PayloadReader(PayloadReader&&) noexcept = default;
PayloadReader& PayloadReader::operator=(PayloadReader&&) noexcept = default;
PayloadReader::~PayloadReader() = default;

Result<sensor::Payload> PayloadReader::of(std::int64_t entry) {
  State& s = *state_;
  while (s.rows && s.entry < entry) MIEN_TRY(s.advance());
  if (!s.rows || s.entry != entry) return sensor::Payload();
  return sensor::Payload{s.bytes, s.reducer};
}

Result<PayloadReader> Take::payloads() const {
  auto reader = std::make_unique<PayloadReader::State>();
  reader->take = state_.get();
  MIEN_TRY_ASSIGN(reader->rows, state_->open_rows(TableId::payload, "reducer,bytes"));
  return PayloadReader(std::move(reader));
}

Result<void> Take::visit_samples(const std::function<void(const StoredSample&)>& visit) const {
  const State& s = *state_;
  const auto last_sensor = static_cast<std::int64_t>(s.rig.sensors.size()) - 1;
  std::int64_t entry = 0;
  return s.visit(
      TableId::sample, "entry,arrival_ns,sensor,kind,sequence,time_ns,time_estimated,reading",
      [&](Row& row, std::int64_t) {
        StoredSample stored;
        entry = row.integer(1, entry, s.entry_count());
        stored.entry = entry;
        stored.arrival = host_time(row.time_ns(2));
        stored.sample.sensor = static_cast<std::uint16_t>(row.integer(3, 0, last_sensor));
        // A kind that this program does not know passes: who needs it will say so.
        stored.sample.kind = static_cast<sensor::SampleKind>(row.integer(4, 1, 255));
        stored.sample.sequence =
            static_cast<std::uint32_t>(row.integer(5, 0, std::numeric_limits<std::uint32_t>::max()));
        stored.sample.time = device_time(row.time_ns(6));
        stored.sample.time_estimated = row.flag(7);
        const auto blob = row.blob(8, sensor::kMaxSampleValues * sizeof(float));
        if (blob.size() % sizeof(float) != 0)
          row.reject(fmt::format("reading is {} bytes, not whole floats", blob.size()));
        stored.sample.count = static_cast<std::uint8_t>(blob.size() / sizeof(float));
        read_floats(row, 8, blob, std::span(stored.sample.values).first(stored.sample.count), kAnyFinite);
        if (row.ok()) visit(stored);
      });
}

Result<std::vector<StoredSample>> Take::samples() const {
  std::vector<StoredSample> samples;
  MIEN_TRY(visit_samples([&](const StoredSample& sample) { samples.push_back(sample); }));
  return samples;
}

Result<std::vector<Tick>> Take::ticks() const {
  const State& s = *state_;
  std::int64_t after = 0;
  std::int64_t frame = -kMaxTimeNs - 1;
  return s.read_all<Tick>(TableId::tick, "after_entry,fired_ns,time_ns", [&](Row& row, std::int64_t) {
    Tick tick;
    tick.index = row.integer(0, -kMaxFrame, kMaxFrame);
    after = row.integer(1, after, s.entry_count());
    tick.after_entry = after;
    tick.fired = host_time(row.time_ns(2));
    frame = row.integer(3, frame + 1, kMaxTimeNs);
    tick.frame = device_time(frame);
    return tick;
  });
}

Result<std::vector<TruthFrame>> Take::truth() const {
  return state_->read_all<TruthFrame>(
      TableId::truth, "has_face,evaluated,tongue_out,weights", [&](Row& row, std::int64_t) {
        TruthFrame truth;
        truth.time = device_time(row.time_ns(0));
        truth.has_face = row.flag(1);
        truth.evaluated = row.flag(2);
        truth.tongue_out = static_cast<float>(row.real(3, kMaxWeight));
        const auto blob = row.blob(4, sizeof(truth.weights.values));
        if (blob.size() != sizeof(truth.weights.values))
          row.reject(fmt::format("weights are {} bytes, not {}", blob.size(), sizeof(truth.weights.values)));
        else
          read_floats(row, 4, blob, truth.weights.values, kMaxWeight);
        return truth;
      });
}

Result<std::vector<Event>> Take::events() const {
  return state_->read_all<Event>(TableId::event, "kind,begin_ns,end_ns,json", [&](Row& row, std::int64_t) {
    Event event;
    event.kind = row.text(1, kMaxNameBytes);
    const std::int64_t begin = row.time_ns(2);
    event.begin = device_time(begin);
    event.end = device_time(row.integer(3, begin, kMaxTimeNs));
    event.json = row.text(4, kMaxTextBytes);
    return event;
  });
}

Result<std::vector<CalibrationVersion>> Take::calibrations() const {
  return state_->read_all<CalibrationVersion>(TableId::calibration, "made_ns,modality,json",
                                              [&](Row& row, std::int64_t id) {
                                                CalibrationVersion calibration;
                                                calibration.id = id;
                                                calibration.made = device_time(row.time_ns(1));
                                                calibration.modality = row.text(2, kMaxNameBytes);
                                                calibration.json = row.text(3, kMaxTextBytes);
                                                return calibration;
                                              });
}

Result<std::optional<Audio>> Take::audio() const {
  // The pieces are joined while they are read, so that the sound is in memory once.
  std::optional<Audio> audio;
  std::int64_t end = 0;
  MIEN_TRY(state_->visit(TableId::audio, "rate_hz,start_ns,pcm", [&](Row& row, std::int64_t) {
    const auto rate = static_cast<int>(row.integer(1, kMinPcmRateHz, kMaxPcmRateHz));
    const std::int64_t start = row.time_ns(2);
    const auto blob = row.blob(3, kMaxPcmSamples * sizeof(float));
    if (!audio) {
      audio = Audio{.rate_hz = rate, .start = device_time(start), .samples = {}};
    } else if (rate != audio->rate_hz || std::abs(start - end) > kPcmJoinNs) {
      row.reject("it does not begin where the sound before it ended, or has another rate");
    }
    if (blob.empty() || blob.size() % sizeof(float) != 0)
      row.reject(fmt::format("pcm is {} bytes, not whole floats", blob.size()));
    if (!row.ok()) return;
    const std::size_t before = audio->samples.size();
    audio->samples.resize(before + blob.size() / sizeof(float));
    const auto piece = std::span(audio->samples).subspan(before);
    read_floats(row, 3, blob, piece, kAnyFinite);
    end = start + from_seconds(static_cast<double>(piece.size()) / rate).count();
  }));
  return audio;
}

Result<std::vector<Note>> Take::notes() const {
  return state_->read_all<Note>(TableId::note, "key,value", [&](Row& row, std::int64_t) {
    Note note;
    note.key = row.text(1, kMaxNameBytes);
    note.value = row.text(2, kMaxTextBytes);
    return note;
  });
}

Result<std::string> Take::note(std::string_view key) const {
  MIEN_TRY_ASSIGN(const auto all, notes());
  std::string value;
  for (const Note& note : all)
    if (note.key == key) value = note.value;
  return value;
}

Result<void> Take::check() const {
  const State& s = *state_;
  MIEN_TRY_ASSIGN(const std::string verdict, s.open.database.read_text("PRAGMA integrity_check(1)"));
  MIEN_TRY(judge_pages(verdict, s.where()));
  {
    MIEN_TRY_ASSIGN(EntryReader reader, log());
    const LogEntry* entry = nullptr;
    do {
      MIEN_TRY_ASSIGN(entry, reader.next());
    } while (entry != nullptr);
  }
  {
    MIEN_TRY_ASSIGN(PayloadReader reader, payloads());
    MIEN_TRY(reader.of(s.entry_count()));  // Passes over, and so checks, all that come before.
  }
  MIEN_TRY(visit_samples([](const StoredSample&) {}));
  MIEN_TRY(ticks());
  MIEN_TRY(truth());
  MIEN_TRY(events());
  MIEN_TRY(calibrations());
  MIEN_TRY(audio());
  if (!s.finished) return {};
  std::string counts;
  for (std::size_t i = 0; i < kTables.size(); ++i) {
    if (i == static_cast<std::size_t>(TableId::header) || i == static_cast<std::size_t>(TableId::note) ||
        kTables[i].since > s.open.version)
      continue;
    MIEN_TRY_ASSIGN(
        const std::int64_t rows,
        s.open.database.read_integer(fmt::format("SELECT count(*) FROM {}", kTables[i].name).c_str()));
    counts += fmt::format("{}{} {}", counts.empty() ? "" : ", ", kTables[i].name, rows);
  }
  if (counts != s.counts)
    return fail(ErrorCode::mismatch,
                fmt::format("it holds {}, and when it was finished it held {}", counts, s.counts), s.where(),
                kDamagedFix);
  return {};
}

}  // namespace mien::take
