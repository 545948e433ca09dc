#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/time.h"
#include "mien/face/profile.h"
#include "mien/sensor/payload.h"
#include "mien/sensor/rig.h"
#include "mien/sensor/sample.h"

namespace mien::take {

/// Who, what and with what: written once, at the start of a take.
struct Header {
  std::string software;   ///< "mien 0.1.0".
  std::string performer;  ///< Name or "virtual:SEED".
  std::string script;     ///< What was performed: a file's name, or a script's text.
  /// For people: "live" (recorded), "device", "lab" or the name of a file of faults (performed), "none"
  /// (imported). The program reads one of it: a take of "lab" has a ridge baseline of its own.
  std::string devices;
  std::string face;  ///< "builtin", a folder or a file: what --face was. Identity parameters below.
  std::string face_parameters;  ///< JSON; empty when none.
  std::string prologue;         ///< "short", "full", "guided" or "none".
  std::uint64_t seed = 0;
  std::string rig_toml;     ///< The whole rig file.
  std::string created_utc;  ///< ISO 8601; for people only.
};

/// One thing that reached the session, in order.
struct LogEntry {
  std::int64_t id = 0;  ///< 1, 2, 3, ...; assigned by the writer.
  HostTime arrival;     ///< From the session's start.
  std::string source;   ///< "udp://127.0.0.1:5005", "virtual", "page", ...
  std::vector<std::byte> bytes;
};

/// One frame of the output grid that fired after the log entry `after_entry` (0: before all).
struct Tick {
  std::int64_t index = 0;
  std::int64_t after_entry = 0;
  HostTime fired;
  DeviceTime frame;  ///< Frame time on the reference sensor's clock.
};

/// A decoded sample, and the log entry that it came from.
struct StoredSample {
  std::int64_t entry = 0;
  HostTime arrival;
  sensor::Sample sample;
};

/// Truth at one frame time (reference sensor's clock).
struct TruthFrame {
  DeviceTime time;
  face::BlendshapeWeights weights;
  float tongue_out = 0;
  bool has_face = true;   ///< False: the truth's source lost the face.
  bool evaluated = true;  ///< False in the prologue and while easing in.
};

/// Something that happened. Kinds that are written: of a calibration "neutral", "nod", "shake", "range",
/// "prompt", "calibrated", "calibration_failed", "recentre", "recentre_failed", "rested"; of devices "bind",
/// "sensor_lost", "sensor_back", "face_lost", "face_back"; of a performed motion "ease", in which it is not
/// evaluated.
struct Event {
  std::string kind;
  DeviceTime begin;  ///< Reference sensor's clock.
  DeviceTime end;    ///< Equal to begin for an instant.
  std::string json;  ///< Details; may be empty.
};

/// A calibration as one version of many; the newest is in force. Opaque JSON here.
struct CalibrationVersion {
  std::int64_t id = 0;
  DeviceTime made;
  std::string modality;  ///< "imu".
  std::string json;
};

/// Mono PCM beside the motion.
struct Audio {
  int rate_hz = 0;
  DeviceTime start;  ///< Of the first sample, reference sensor's clock.
  std::vector<float> samples;
};

/// What ran: model, kernels, hash.
struct Note {
  std::string key;
  std::string value;
};

/// When a take that is being written can be seen under its name.
enum class Appears {
  at_once,        ///< A recording: whatever happens, what came until then is there.
  when_finished,  ///< Something made: finish() puts it in place, whole; without it nothing is left and an
                  ///< older file stands.
};

/// Writes a take while it is recorded. Append-only, and what is stored is always a prefix of what was added:
/// a writer thread commits at least every half second, so a kill loses at most that.
///
/// The first error (disk full, or something that no reader would take back: a number that is not finite, a
/// sensor that the rig lacks, time that runs backwards, a tick after an entry that was never added) is kept,
/// status() and finish() return it, and nothing is stored after it. Thread: calls from one thread. They copy
/// and return at once; where the disk is slower than the caller for long, they wait for it once 16 MiB are
/// under way.
class TakeWriter {
 public:
  /// The file appears at `path`, with its header whole, when this returns, or when finish() does; an older
  /// one is replaced then and not before. Errors: bad_usage when the file exists and not `replace`; io; a
  /// header whose rig does not parse.
  [[nodiscard]] static Result<TakeWriter> create(const std::filesystem::path& path, const Header& header,
                                                 bool replace, Appears appears = Appears::at_once);
  TakeWriter(TakeWriter&&) noexcept;
  TakeWriter& operator=(TakeWriter&&) noexcept;
  ~TakeWriter();  ///< As finish(), its error lost; one that has not appeared yet never does.

  /// Returns the entry's id. `arrival` never runs backwards; up to 16 MiB an entry, beside which its payload
  /// stands where it has one. An entry and its payload are in the file together or not at all.
  std::int64_t add_entry(HostTime arrival, std::string_view source, std::span<const std::byte> bytes,
                         const sensor::Payload& payload = {});
  /// In the order of their entries. `entry` 0: it came with none.
  void add_sample(std::int64_t entry, HostTime arrival, const sensor::Sample& sample);
  /// Index and frame time ascend; after_entry never runs backwards and names an entry that was added.
  void add_tick(const Tick& tick);
  /// Time ascends.
  void add_truth(const TruthFrame& truth);
  void add_event(const Event& event);
  /// Id 0: the next one. Else ids ascend.
  void add_calibration(const CalibrationVersion& calibration);
  /// May be called again and again: each piece begins where the last ended, to 10 ms. 1 to 768 kHz.
  void add_audio(int rate_hz, DeviceTime start, std::span<const float> samples);
  /// What ran: model, kernels, hash; key and value. A later value of a key hides the earlier.
  void add_note(std::string_view key, std::string_view value);
  /// The first error so far, so that a recorder can stop. Cheap.
  [[nodiscard]] Result<void> status() const;
  /// Everything is on the disk when this returns. Nothing may be added afterwards.
  [[nodiscard]] Result<void> finish();

 private:
  struct State;
  explicit TakeWriter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// A take's log, read one entry at a time: a session of hours has millions. The take outlives its reader.
/// Thread: the take's.
class EntryReader {
 public:
  EntryReader(EntryReader&&) noexcept;
  EntryReader& operator=(EntryReader&&) noexcept;
  ~EntryReader();
  /// The next one; null after the last. Valid until the next call. Errors: malformed, io.
  [[nodiscard]] Result<const LogEntry*> next();

 private:
  friend class Take;
  struct State;
  explicit EntryReader(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// The payloads of a take's log, read one at a time as its entries are gone through: they may be many
/// gigabytes. The take outlives its reader. Thread: the take's.
class PayloadReader {
 public:
  PayloadReader(PayloadReader&&) noexcept;
  PayloadReader& operator=(PayloadReader&&) noexcept;
  ~PayloadReader();
  /// That of the entry with this id; without bytes where it has none. Entries are asked for in ascending
  /// order, any may be left out. Valid until the next call. Errors: malformed, io.
  [[nodiscard]] Result<sensor::Payload> of(std::int64_t entry);

 private:
  friend class Take;
  struct State;
  explicit PayloadReader(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// Reads a take; one killed while being written opens again, with everything up to its last commit. What it
/// reads is what stood in the file when it was opened, also while the take is still being recorded. A
/// foreign, broken or doctored file is refused with one line; no number leaves here unchecked
/// (docs/reference/take.md lists the ranges), and entries come by their ids, samples by their entries, and
/// ticks by the entry after which they fired.
///
/// Where the recording was cut off inside a commit, its `-journal` beside it is rolled back; where this
/// program may not write there, that is done on a copy in the temporary folder. Thread: one at a time.
class Take {
 public:
  /// Errors: not_found; bad_usage (no file, empty); malformed; unsupported (another version); out_of_range;
  /// io. Cost: reads the file once (under a second for 100 MB from the cache).
  [[nodiscard]] static Result<Take> open(const std::filesystem::path& path);
  Take(Take&&) noexcept;
  Take& operator=(Take&&) noexcept;
  ~Take();

  [[nodiscard]] const std::filesystem::path& path() const;
  [[nodiscard]] const Header& header() const;
  [[nodiscard]] const sensor::Rig& rig() const;
  [[nodiscard]] bool finished() const;  ///< False when the recording was cut off, or is still running.
  [[nodiscard]] Result<std::vector<LogEntry>> entries() const;
  /// The same from the first on, one at a time.
  [[nodiscard]] Result<EntryReader> log() const;
  /// What the entries carry beside their bytes, from the first on. A take of before there were payloads has
  /// none.
  [[nodiscard]] Result<PayloadReader> payloads() const;
  [[nodiscard]] Result<std::vector<StoredSample>> samples() const;
  /// The same, one at a time.
  [[nodiscard]] Result<void> visit_samples(const std::function<void(const StoredSample&)>& visit) const;
  [[nodiscard]] Result<std::vector<Tick>> ticks() const;
  [[nodiscard]] Result<std::vector<TruthFrame>> truth() const;
  [[nodiscard]] Result<std::vector<Event>> events() const;
  [[nodiscard]] Result<std::vector<CalibrationVersion>> calibrations() const;
  [[nodiscard]] Result<std::optional<Audio>> audio() const;
  [[nodiscard]] Result<std::string> note(std::string_view key) const;  ///< Empty when absent.
  [[nodiscard]] Result<std::vector<Note>> notes() const;               ///< All, in the order written.

  /// Reads everything and compares the counts with what finish() noted. `mien take check`.
  [[nodiscard]] Result<void> check() const;

 private:
  friend class EntryReader;
  friend class PayloadReader;
  struct State;
  static Result<Take> open_and_check(const std::filesystem::path& path);
  explicit Take(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace mien::take
