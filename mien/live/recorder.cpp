#include "mien/live/recorder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>
#include <vector>

#include "mien/core/bytes.h"
#include "mien/session/command.h"

namespace mien::live {
namespace {

/// What the disk may be behind: about twenty seconds of twelve sensors.
constexpr std::size_t kRingBytes = std::size_t{1} << 23U;
/// What is kept of a session, so that a take can begin with its beginning: about three hours of twelve
/// sensors.
constexpr std::uint64_t kMaxSpoolBytes = std::uint64_t{4} << 30U;
constexpr std::size_t kSliceBytes = std::size_t{1} << 22U;
constexpr Duration kPollInterval = std::chrono::milliseconds(100);

template <class T>
void put(std::span<std::byte>& to, const T& value) {
  std::memcpy(to.data(), &value, sizeof(T));
  to = to.subspan(sizeof(T));
}
void put(std::span<std::byte>& to, std::span<const std::byte> bytes) {
  if (!bytes.empty()) std::memcpy(to.data(), bytes.data(), bytes.size());
  to = to.subspan(bytes.size());
}
template <class T>
T get(std::span<const std::byte>& from) {
  T value{};
  std::memcpy(&value, from.data(), sizeof(T));
  from = from.subspan(sizeof(T));
  return value;
}
struct EntryHead {
  HostTime arrival;
  sensor::Peer peer;
  std::uint32_t bytes;
  std::uint32_t samples;
};
struct EventHead {
  DeviceTime begin, end;
  std::uint32_t kind_bytes;
};

struct CalibrationHead {
  std::int64_t id;
  DeviceTime made;
  std::uint32_t modality_bytes;
};

/// A file without a name, which goes when it is closed; null with errno when the folder takes none.
std::FILE* open_spool(const std::filesystem::path& folder) {
  int file = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (file < 0) {  // Not every file system has such files: a name for a moment, then.
    std::string name = (folder / ".mien-session-XXXXXX").string();
    file = ::mkostemp(name.data(), O_CLOEXEC);
    if (file < 0) return nullptr;
    ::unlink(name.c_str());
  }
  std::FILE* const spool = ::fdopen(file, "w+b");
  if (spool == nullptr) {
    const int why = errno;
    ::close(file);
    errno = why;
  }
  return spool;
}

}  // namespace

/// A take that is being written.
struct Recorder::Writing {
  take::TakeWriter writer;
  std::uint64_t at = 0;    // How much of the temporary file is in it, bytes.
  std::int64_t entry = 0;  // Id of the newest.
  HostTime newest;
  std::optional<HostTime> asked_for;  // The session's newest moment when the recording was asked for.
  std::vector<std::string> names;     // Of peers; empty: not asked for yet.
};

Recorder::Recorder(const std::filesystem::path& folder, std::function<std::string(sensor::Peer)> peer_name)
    : peer_name_(std::move(peer_name)), ring_(kRingBytes), spool_(open_spool(folder)) {
  if (spool_ == nullptr)
    spool_error_ = fmt::format("the folder of takes, {}, does not take the session ({})", folder.string(),
                               std::generic_category().message(errno));
  thread_ = std::jthread([this] { run(); });
}

Recorder::~Recorder() {
  stopping_ = true;
  signal_.give();
  thread_.join();
  if (spool_ != nullptr) std::fclose(spool_);
}

std::span<std::byte> Recorder::claim(std::size_t size) {
  const std::span<std::byte> room = ring_.claim(size);
  if (room.empty()) overrun_ = true;
  return room;
}

void Recorder::entry(HostTime arrival, sensor::Peer peer, std::span<const std::byte> bytes,
                     std::span<const sensor::Sample> samples) {
  std::span<std::byte> room = claim(1 + sizeof(EntryHead) + bytes.size() + samples.size_bytes());
  if (room.empty()) return;
  put(room, Kind::entry);
  put(room, EntryHead{arrival, peer, static_cast<std::uint32_t>(bytes.size()),
                      static_cast<std::uint32_t>(samples.size())});
  put(room, bytes);
  put(room, std::as_bytes(samples));
  ring_.publish();
  signal_.give();
}

void Recorder::command(HostTime arrival, std::string_view json) {
  std::span<std::byte> room = claim(1 + sizeof(arrival) + json.size());
  if (room.empty()) return;
  put(room, Kind::command);
  put(room, arrival);
  put(room, std::as_bytes(std::span(json)));
  ring_.publish();
}

void Recorder::tick(const sensor::FrameTick& tick) {
  std::span<std::byte> room = claim(1 + sizeof(tick));
  if (room.empty()) return;
  put(room, Kind::tick);
  put(room, tick);
  ring_.publish();
}

void Recorder::event(const take::Event& event) {
  std::span<std::byte> room = claim(1 + sizeof(EventHead) + event.kind.size() + event.json.size());
  if (room.empty()) return;
  put(room, Kind::event);
  put(room, EventHead{event.begin, event.end, static_cast<std::uint32_t>(event.kind.size())});
  put(room, std::as_bytes(std::span(event.kind)));
  put(room, std::as_bytes(std::span(event.json)));
  ring_.publish();
}

void Recorder::calibration(std::int64_t id, DeviceTime made, std::string_view modality,
                           std::string_view json) {
  std::span<std::byte> room = claim(1 + sizeof(CalibrationHead) + modality.size() + json.size());
  if (room.empty()) return;
  put(room, Kind::calibration);
  put(room, CalibrationHead{id, made, static_cast<std::uint32_t>(modality.size())});
  put(room, std::as_bytes(std::span(modality)));
  put(room, std::as_bytes(std::span(json)));
  ring_.publish();
}

void Recorder::run() {
  while (!stopping_) {
    signal_.wait(kPollInterval);
    try {
      turn();
    } catch (const std::exception& error) {
      give_up(error.what());
    }
  }
}

void Recorder::turn() {
  bool ending = false;  // What was handed over before that was asked for is still to be taken.
  {
    const std::lock_guard lock(mutex_);
    if (wanted_) {
      writing_ = std::move(wanted_);
      writing_->asked_for = newest_;
    }
    ending = end_notes_.has_value();
  }
  bool behind = false;
  do {
    while (drain()) {
    }
    if (overrun_.exchange(false)) give_up("the disk is too slow; record to another one");
    behind = feed();
    if (writing_)
      if (const auto status = writing_->writer.status(); !status) {
        const std::string why = status.error().message();
        [[maybe_unused]] const auto kept = writing_->writer.finish();  // What was written stays.
        writing_.reset();
        const std::lock_guard lock(mutex_);
        state_.on = false;
        state_.error = why;
        ended_.notify_all();
      }
  } while (behind && !stopping_);

  const std::lock_guard lock(mutex_);
  if (writing_) state_.seconds = std::max(0.0, to_seconds(writing_->newest - *writing_->asked_for));
  if (writing_ && ending && end_notes_) conclude();
}

/// Keeps the moment of a record that has one.
void Recorder::note_moment(std::span<const std::byte> record) {
  const Kind kind = get<Kind>(record);
  if (kind == Kind::entry) newest_ = get<EntryHead>(record).arrival;
  if (kind == Kind::tick) newest_ = get<sensor::FrameTick>(record).fired;
}

/// One record of the ring into the temporary file; false when there is none.
bool Recorder::drain() {
  const std::span<const std::byte> record = ring_.front();
  if (record.empty()) return false;
  note_moment(record);
  if (spool_ != nullptr) {
    const auto size = static_cast<std::uint32_t>(record.size());
    const bool kept = spooled_ < kMaxSpoolBytes && std::fwrite(&size, sizeof(size), 1, spool_) == 1 &&
                      std::fwrite(record.data(), 1, record.size(), spool_) == record.size();
    spooled_ += sizeof(size) + record.size();
    if (!kept)
      give_up(spooled_ >= kMaxSpoolBytes
                  ? "the session has run for too long to be recorded from its beginning"
                  : fmt::format("the folder of takes does not take the session ({})",
                                std::generic_category().message(errno)));
  }
  ring_.release();
  return true;
}

/// A slice of the temporary file into the take; true when there is more.
bool Recorder::feed() {
  if (!writing_ || spool_ == nullptr || writing_->at >= spooled_) return false;
  if (std::fflush(spool_) != 0) {
    give_up(fmt::format("the folder of takes does not take the session ({})",
                        std::generic_category().message(errno)));
    return false;
  }
  slice_.resize(kSliceBytes);
  const auto got = ::pread(::fileno(spool_), slice_.data(), slice_.size(), static_cast<off_t>(writing_->at));
  std::span<const std::byte> left(slice_.data(), got > 0 ? static_cast<std::size_t>(got) : 0);
  bool any = false;
  while (left.size() >= sizeof(std::uint32_t)) {
    std::span<const std::byte> rest = left;
    const auto size = get<std::uint32_t>(rest);
    if (rest.size() < size) break;
    write(rest.first(size));
    left = rest.subspan(size);
    writing_->at += sizeof(size) + size;
    any = true;
  }
  if (!any) give_up("the temporary file of the session cannot be read back");
  return writing_ && writing_->at < spooled_;
}

/// Ends the take; mutex_ is held.
void Recorder::conclude() {
  for (const take::Note& note : *end_notes_) writing_->writer.add_note(note.key, note.value);
  end_notes_.reset();
  if (const auto finished = writing_->writer.finish(); !finished) state_.error = finished.error().message();
  writing_.reset();
  state_.on = false;
  ended_.notify_all();
}

/// The temporary file has a hole from here on: what is recorded ends, and nothing can be recorded any more.
void Recorder::give_up(const std::string& why) {
  if (writing_) [[maybe_unused]]
    const auto kept = writing_->writer.finish();
  const std::lock_guard lock(mutex_);
  if (spool_error_.empty()) spool_error_ = why;
  // A file with a hole is good for nothing, and the disk may be full.
  if (spool_ != nullptr) std::fclose(std::exchange(spool_, nullptr));
  if (writing_ || wanted_) state_.error = why;
  writing_.reset();
  wanted_.reset();
  state_.on = false;
  ended_.notify_all();
}

void Recorder::write(std::span<const std::byte> record) {
  Writing& w = *writing_;
  switch (get<Kind>(record)) {
    case Kind::entry: {
      const auto head = get<EntryHead>(record);
      // Only of peers that are in the log: others may be forgotten, and their numbers given to the next.
      if (w.names.size() <= head.peer) w.names.resize(head.peer + std::size_t{1});
      if (w.names[head.peer].empty()) w.names[head.peer] = peer_name_(head.peer);
      w.newest = head.arrival;
      w.entry = w.writer.add_entry(head.arrival, w.names[head.peer], record.first(head.bytes));
      record = record.subspan(head.bytes);
      for (std::uint32_t i = 0; i < head.samples; ++i)
        w.writer.add_sample(w.entry, head.arrival, get<sensor::Sample>(record));
      return;
    }
    case Kind::command: {
      const auto arrival = get<HostTime>(record);
      w.entry = w.writer.add_entry(arrival, session::kPageSource, record);
      return;
    }
    case Kind::tick: {
      const auto tick = get<sensor::FrameTick>(record);
      w.writer.add_tick({tick.index, w.entry, tick.fired, tick.frame});
      w.newest = tick.fired;
      return;
    }
    case Kind::event: {
      const auto head = get<EventHead>(record);
      w.writer.add_event({std::string(as_text(record.first(head.kind_bytes))), head.begin, head.end,
                          std::string(as_text(record.subspan(head.kind_bytes)))});
      return;
    }
    case Kind::calibration: {
      const auto head = get<CalibrationHead>(record);
      w.writer.add_calibration({head.id, head.made, std::string(as_text(record.first(head.modality_bytes))),
                                std::string(as_text(record.subspan(head.modality_bytes)))});
      return;
    }
  }
}

Result<void> Recorder::start(const std::filesystem::path& path, const take::Header& header, bool replace) {
  {
    const std::lock_guard lock(mutex_);
    if (state_.on)
      return fail(ErrorCode::bad_usage, "a recording runs already", state_.path.string(), "end it first");
    if (!spool_error_.empty())
      return fail(ErrorCode::io, spool_error_, path.string(), "start the session again to record");
  }
  MIEN_TRY_ASSIGN(take::TakeWriter writer, take::TakeWriter::create(path, header, replace));
  const std::lock_guard lock(mutex_);
  wanted_ = std::make_unique<Writing>(Writing{std::move(writer), 0, 0, {}, {}, {}});
  end_notes_.reset();
  state_ = {true, path, 0, {}};
  signal_.give();
  return {};
}

void Recorder::end(std::vector<take::Note> notes) {
  const std::lock_guard lock(mutex_);
  if (state_.on) end_notes_ = std::move(notes);
  signal_.give();
}

Result<void> Recorder::wait() {
  std::unique_lock lock(mutex_);
  ended_.wait(lock, [this] { return !state_.on; });
  if (state_.error.empty()) return {};
  return fail(ErrorCode::io, state_.error, state_.path.string(), "what was recorded until then is kept");
}

Recorder::State Recorder::state() const {
  const std::lock_guard lock(mutex_);
  State state = state_;
  state.unable = spool_error_;
  return state;
}

}  // namespace mien::live
