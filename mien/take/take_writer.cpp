#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>

#include "mien/core/bytes.h"
#include "mien/core/excerpt.h"
#include "mien/core/utf8.h"
#include "mien/take/layout.h"
#include "mien/take/new_file.h"
#include "mien/take/row_writer.h"
#include "mien/take/take.h"

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
  /// Keeps why the take ends here, and what becomes of it.
  void end(Error first) {
    first.fix += first.fix.empty() ? "" : "; ";
    first.fix += unfinished ? "nothing of it is kept" : "what was committed before is kept";
    keep(std::move(first));
  }
  void refuse(std::string what) {
    end({ErrorCode::out_of_range, std::move(what), path.string(), "the recording ends here"});
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
    if (auto ready = rows.prepare(); !ready) return end(std::move(ready).error());
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
      if (auto stored = rows.commit(batch.bytes()); !stored) return end(std::move(stored).error());
    }
  }

  void run() {
    try {
      write_batches();
    } catch (const std::exception& exception) {
      end({ErrorCode::io, fmt::format("storing the take failed ({})", exception.what()), path.string(), ""});
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
                              excerpt(*text), kMaxTextBytes),
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
                                   std::span<const std::byte> bytes, const sensor::Payload& payload) {
  State& s = *state_;
  const std::int64_t id = ++s.entries;
  if (!is_time(arrival) || arrival < s.last_arrival)
    s.refuse(fmt::format("log entry {} arrives before the one that came before it, or at no time", id));
  else if (!is_text(source, kMaxNameBytes))
    s.refuse(
        fmt::format("the source of log entry {} is not UTF-8, or longer than {} bytes", id, kMaxNameBytes));
  else if (bytes.size() > kMaxEntryBytes)
    s.refuse(fmt::format("log entry {} is longer than {} bytes", id, kMaxEntryBytes));
  else if (payload.bytes.size() > sensor::kMaxPayload)
    s.refuse(fmt::format("the payload of log entry {} is longer than {} bytes", id, sensor::kMaxPayload));
  else if (!payload.reducer.empty() && (payload.bytes.empty() || !sensor::is_reducer_hash(payload.reducer)))
    s.refuse(fmt::format("the payload of log entry {} has no bytes, or a reducer that is no SHA-256", id));
  s.last_arrival = arrival;
  s.add(TableId::log, bytes.size() + payload.bytes.size(), [&](ByteWriter& queue) {
    put_time(queue, arrival);
    put_text(queue, source);
    put_bytes(queue, bytes);
    if (payload.bytes.empty()) return;
    queue.little(static_cast<std::uint8_t>(TableId::payload));  // In one commit with its entry.
    queue.little(id);
    put_text(queue, payload.reducer);
    put_bytes(queue, payload.bytes);
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
    s.refuse(fmt::format("the event \"{}\" ends before it begins, or at no time", excerpt(event.kind)));
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
