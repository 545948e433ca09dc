#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

// The take file's layout and limits, shared by its writer and its reader. Described for people in
// docs/reference/take.md; a change of either is a new version.

namespace mien::take {

/// "Mien", big-endian, at byte 68 of the file.
inline constexpr std::int64_t kApplicationId = 0x4D69656E;
/// At byte 60: the layout's version. A take becomes of version 2 with its first payload, so that programs
/// which know no payloads read all others, and none of those with holes.
inline constexpr std::int64_t kPlainVersion = 1;
inline constexpr std::int64_t kPayloadVersion = 2;

struct Table {
  const char* name;
  const char* key;  ///< The integer primary key; rows are written with ascending keys.
  const char* sql;  ///< Exactly as it stands in a take: a file whose tables differ by a letter is not one.
  std::int64_t since = kPlainVersion;  ///< Takes of this version or later have it, and no earlier ones.
};

inline constexpr std::array<Table, 11> kTables = {{
    {"header", "id",
     "CREATE TABLE header(id INTEGER PRIMARY KEY,software TEXT NOT NULL,performer TEXT NOT NULL,script TEXT "
     "NOT NULL,"
     "devices TEXT NOT NULL,face TEXT NOT NULL,face_parameters TEXT NOT NULL,prologue TEXT NOT NULL,"
     "seed INTEGER NOT NULL,rig_toml TEXT NOT NULL,created_utc TEXT NOT NULL,profile TEXT NOT NULL)STRICT"},
    {"source", "id", "CREATE TABLE source(id INTEGER PRIMARY KEY,name TEXT NOT NULL)STRICT"},
    {"log", "id",
     "CREATE TABLE log(id INTEGER PRIMARY KEY,arrival_ns INTEGER NOT NULL,source INTEGER NOT NULL,"
     "bytes BLOB NOT NULL)STRICT"},
    {"tick", "frame",
     "CREATE TABLE tick(frame INTEGER PRIMARY KEY,after_entry INTEGER NOT NULL,fired_ns INTEGER NOT NULL,"
     "time_ns INTEGER NOT NULL)STRICT"},
    {"sample", "id",
     "CREATE TABLE sample(id INTEGER PRIMARY KEY,entry INTEGER NOT NULL,arrival_ns INTEGER NOT NULL,"
     "sensor INTEGER NOT NULL,kind INTEGER NOT NULL,sequence INTEGER NOT NULL,time_ns INTEGER NOT NULL,"
     "time_estimated INTEGER NOT NULL,reading BLOB NOT NULL)STRICT"},
    {"truth", "time_ns",
     "CREATE TABLE truth(time_ns INTEGER PRIMARY KEY,has_face INTEGER NOT NULL,evaluated INTEGER NOT NULL,"
     "tongue_out REAL NOT NULL,weights BLOB NOT NULL)STRICT"},
    {"event", "id",
     "CREATE TABLE event(id INTEGER PRIMARY KEY,kind TEXT NOT NULL,begin_ns INTEGER NOT NULL,"
     "end_ns INTEGER NOT NULL,json TEXT NOT NULL)STRICT"},
    {"calibration", "id",
     "CREATE TABLE calibration(id INTEGER PRIMARY KEY,made_ns INTEGER NOT NULL,modality TEXT NOT NULL,"
     "json TEXT NOT NULL)STRICT"},
    {"audio", "id",
     "CREATE TABLE audio(id INTEGER PRIMARY KEY,rate_hz INTEGER NOT NULL,start_ns INTEGER NOT NULL,"
     "pcm BLOB NOT NULL)STRICT"},
    {"note", "id", "CREATE TABLE note(id INTEGER PRIMARY KEY,key TEXT NOT NULL,value TEXT NOT NULL)STRICT"},
    {"payload", "entry",
     "CREATE TABLE payload(entry INTEGER PRIMARY KEY,reducer TEXT NOT NULL,bytes BLOB NOT NULL)STRICT",
     kPayloadVersion},
}};

/// The tables by name, for indexing kTables and what goes beside it.
enum class TableId : std::uint8_t {
  header,
  source,
  log,
  tick,
  sample,
  truth,
  event,
  calibration,
  audio,
  note,
  payload
};

[[nodiscard]] constexpr const Table& table_of(TableId id) {
  return kTables[static_cast<std::size_t>(id)];
}

/// Times lie within nine years of zero, so that the difference of any two fits and frame_offset() cannot
/// overflow.
inline constexpr std::int64_t kMaxTimeNs = std::int64_t{1} << 58U;
inline constexpr std::int64_t kMaxFrame = std::int64_t{1} << 32U;
/// Real performances go a little beyond 0 to 1; beyond this the number is no weight. As the Live Link CSV
/// reader has it.
inline constexpr double kMaxWeight = 100.0;
/// A UDP packet has at most 64 KiB.
inline constexpr std::size_t kMaxEntryBytes = std::size_t{1} << 24U;
/// Rig files, scripts, calibrations, events' details.
inline constexpr std::size_t kMaxTextBytes = std::size_t{1} << 22U;
/// Names: sources, kinds of events, keys of notes.
inline constexpr std::size_t kMaxNameBytes = 256;
/// Sound is stored in pieces, so that a kill loses little of it.
inline constexpr std::size_t kMaxPcmSamples = std::size_t{1} << 16U;
inline constexpr int kMinPcmRateHz = 1000;
inline constexpr int kMaxPcmRateHz = 768000;
/// A piece of sound begins where the last ended, give or take this much of clock correction.
inline constexpr std::int64_t kPcmJoinNs = 10'000'000;

/// The note that finish() writes last. Its value counts the rows of every table but header and note.
inline constexpr const char* kFinishedKey = "mien.finished";
inline constexpr const char* kUseBackup = "use a copy that was made before it was damaged";
inline constexpr const char* kDamagedFix =
    "use a copy from before it was damaged or changed by another program";

/// The profile of the weights in `truth`: face::kShapeNames in their order.
inline constexpr const char* kProfile = "ict53";

/// Numbers in blobs are little-endian. Shape: `to` has as many values as `bytes` has room for.
template <class T>
void load_little(std::span<const std::byte> bytes, std::span<T> to) {
  for (std::size_t i = 0; i < to.size(); ++i) {
    std::array<std::byte, sizeof(T)> raw;
    std::memcpy(raw.data(), bytes.data() + i * sizeof(T), sizeof(T));
    if constexpr (std::endian::native == std::endian::big) std::reverse(raw.begin(), raw.end());
    to[i] = std::bit_cast<T>(raw);
  }
}

}  // namespace mien::take
