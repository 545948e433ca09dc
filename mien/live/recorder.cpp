#include "mien/live/recorder.h"

#include <algorithm>
#include <cstring>
#include <future>
#include <utility>
#include <vector>

#include "mien/core/bytes.h"
#include "mien/session/command.h"

namespace mien::live {
namespace {

/// What the disk may be behind: about twenty seconds of twelve sensors.
constexpr std::size_t kRecorderRingBytes = std::size_t{1} << 23U;
/// Records that are taken between looks at the payloads.
constexpr std::size_t kBatchBytes = std::size_t{1} << 20U;
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
  std::uint32_t source_bytes;
  std::uint32_t bytes;
  std::uint32_t samples;
  std::uint32_t payload_bytes;  // They stand in the file of payloads, in the order of their entries.
  std::uint32_t
      reducer_bytes;  // Of the hash, which comes after the source; then the bytes, then the samples.
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

}  // namespace

/// A take that is being written.
struct Recorder::Writing {
  take::TakeWriter writer;
  std::uint64_t at = 0;          // How much of the temporary log is in it, bytes, ...
  std::uint64_t payload_at = 0;  // ... and of its payloads.
  std::int64_t entry = 0;        // Id of the newest.
  HostTime newest;
  HostTime asked_for;  // The session's newest moment when the recording was asked for.
};

/// A take whose file is being made.
struct Recorder::Opening {
  Wish wish;
  HostTime asked_for;
  // The thread's until `over`.
  Result<take::TakeWriter> made = fail(ErrorCode::internal, "it is not made yet");
  std::atomic<bool> over = false;
  std::jthread thread;  // Last: it ends before what it uses.
};

Recorder::Recorder(const std::filesystem::path& folder, std::uint64_t log_limit)
    : ring_(kRecorderRingBytes),
      payload_ring_(kPayloadQueueBytes),
      spool_(folder, log_limit),
      spool_error_(spool_.problem()) {
  state_.log = spool_.usage({});
  thread_ = std::jthread([this] { run(); });
}

Recorder::~Recorder() {
  stopping_ = true;
  signal_.give();
  thread_.join();
}

std::span<std::byte> Recorder::claim(std::size_t size) {
  const std::span<std::byte> room = ring_.claim(size);
  if (room.empty()) overrun_ = true;
  return room;
}

void Recorder::entry(HostTime arrival, std::string_view source, std::span<const std::byte> bytes,
                     std::span<const sensor::Sample> samples, const sensor::Payload& payload) {
  std::span<std::byte> room = claim(1 + sizeof(EntryHead) + source.size() + payload.reducer.size() +
                                    bytes.size() + samples.size_bytes());
  if (room.empty()) return;
  if (!payload.bytes.empty()) {
    std::span<std::byte> beside = payload_ring_.claim(payload.bytes.size());
    if (beside.empty()) {
      payload_overrun_ = true;
      return;
    }
    put(beside, payload.bytes);
    payload_ring_.publish();
  }
  put(room, Kind::entry);
  put(room,
      EntryHead{arrival, static_cast<std::uint32_t>(source.size()), static_cast<std::uint32_t>(bytes.size()),
                static_cast<std::uint32_t>(samples.size()), static_cast<std::uint32_t>(payload.bytes.size()),
                static_cast<std::uint32_t>(payload.reducer.size())});
  put(room, std::as_bytes(std::span(source)));
  put(room, std::as_bytes(std::span(payload.reducer)));
  put(room, bytes);
  put(room, std::as_bytes(samples));
  ring_.publish();
  signal_.give();
}

void Recorder::command(HostTime arrival, std::string_view json_text) {
  std::span<std::byte> room = claim(1 + sizeof(arrival) + json_text.size());
  if (room.empty()) return;
  put(room, Kind::command);
  put(room, arrival);
  put(room, std::as_bytes(std::span(json_text)));
  ring_.publish();
}

void Recorder::tick(const sensor::FrameTick& tick) {
  std::span<std::byte> room = claim(1 + sizeof(tick));
  if (room.empty()) return;
  put(room, Kind::tick);
  put(room, tick);
  ring_.publish();
}

std::size_t Recorder::record_size(const take::Event& event) {
  return 1 + sizeof(EventHead) + event.kind.size() + event.json.size();
}

void Recorder::put_record(const take::Event& event, std::span<std::byte> room) {
  put(room, Kind::event);
  put(room, EventHead{event.begin, event.end, static_cast<std::uint32_t>(event.kind.size())});
  put(room, std::as_bytes(std::span(event.kind)));
  put(room, std::as_bytes(std::span(event.json)));
}

void Recorder::event(const take::Event& event) {
  const std::span<std::byte> room = claim(record_size(event));
  if (room.empty()) return;
  put_record(event, room);
  ring_.publish();
}

void Recorder::note(take::Event event) {
  {
    const std::lock_guard lock(mutex_);
    noted_.push_back(std::move(event));
  }
  signal_.give();
}

void Recorder::calibration(std::int64_t id, DeviceTime made, std::string_view modality,
                           std::string_view json_text) {
  std::span<std::byte> room = claim(1 + sizeof(CalibrationHead) + modality.size() + json_text.size());
  if (room.empty()) return;
  put(room, Kind::calibration);
  put(room, CalibrationHead{id, made, static_cast<std::uint32_t>(modality.size())});
  put(room, std::as_bytes(std::span(modality)));
  put(room, std::as_bytes(std::span(json_text)));
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
  take_over();
  while (opening_ == nullptr || settle()) {
    std::optional<Request> next;
    {
      const std::lock_guard lock(mutex_);
      if (requests_.empty()) return;
      next = std::move(requests_.front());
      requests_.pop_front();
    }
    if (auto* wish = std::get_if<Wish>(&*next)) {
      open(*std::move(wish));
    } else {
      take_over();  // What was handed over before the end was asked for belongs to the take.
      try {
        if (writing_) conclude(std::get<End>(*next));
      } catch (const std::exception& error) {
        give_up(error.what());
      }
      done(0);
    }
  }
}

/// What was handed over into the temporary log, and from there into the take.
void Recorder::take_over() {
  bool behind = false;
  do {
    std::vector<take::Event> noted;
    {
      const std::lock_guard lock(mutex_);
      noted = std::exchange(noted_, {});
    }
    drain_queues();
    for (const take::Event& event : noted) keep(event);
    if (overrun_.exchange(false)) give_up("the disk is too slow; record to another one");
    if (payload_overrun_.exchange(false))
      give_up("the disk is too slow for the session's pictures and sound; record to another one");
    behind = feed();
    if (writing_)
      if (const auto status = writing_->writer.status(); !status) {
        const std::string why = status.error().message();
        [[maybe_unused]] const auto kept = writing_->writer.finish();  // What was written stays.
        writing_.reset();
        const std::lock_guard lock(mutex_);
        is_over(why);
      }
    const std::lock_guard lock(mutex_);
    state_.log = spool_.usage(newest_);
    if (writing_) state_.seconds = std::max(0.0, to_seconds(writing_->newest - writing_->asked_for));
  } while (behind && !stopping_);
}

/// Begins to make the take's file, on a thread of its own: what is handed over meanwhile is taken.
void Recorder::open(Wish wish) {
  if (Result<void> can = check_can_begin(wish); !can) return tell(wish, std::move(can));
  auto opening = std::make_unique<Opening>();
  opening->wish = std::move(wish);
  opening->asked_for = newest_;
  const auto make = [this, to = opening.get()] {
    try {
      to->made = take::TakeWriter::create(to->wish.path, to->wish.header, to->wish.replace);
    } catch (const std::exception& error) {
      to->made = fail(ErrorCode::internal, error.what(), to->wish.path.string());
    }
    to->over = true;
    signal_.give();
  };
  try {
    opening->thread = std::jthread(make);
  } catch (const std::exception& error) {
    return tell(opening->wish, fail(ErrorCode::internal, error.what(), opening->wish.path.string()));
  }
  opening_ = std::move(opening);
}

Result<void> Recorder::check_can_begin(const Wish& wish) const {
  const std::lock_guard lock(mutex_);
  if (state_.on)
    return fail(ErrorCode::bad_usage, "a recording runs already", state_.path.string(), "end it first");
  if (!spool_error_.empty())
    return fail(ErrorCode::io, spool_error_, wish.path.string(), "start the session again to record");
  return {};
}

/// The file that is being made, once it is; false while it is not.
bool Recorder::settle() {
  if (!opening_->over) return false;
  const std::unique_ptr<Opening> opening = std::move(opening_);
  opening->thread.join();
  if (!opening->made) {
    tell(opening->wish, std::unexpected(opening->made.error()));
    return true;
  }
  // What has to come first may have been lost meanwhile.
  Result<void> begun = check_can_begin(opening->wish);
  if (begun) {
    writing_ = std::make_unique<Writing>(
        Writing{.writer = *std::move(opening->made), .asked_for = opening->asked_for});
    const std::lock_guard lock(mutex_);
    state_ = {.on = true, .path = opening->wish.path, .log = state_.log};
  }
  tell(opening->wish, std::move(begun));
  return true;
}

/// Tells who asked.
void Recorder::tell(const Wish& wish, Result<void> begun) {
  done(1);
  try {
    wish.begun(std::move(begun));
  } catch (const std::exception&) {
    // Who cannot be told for want of memory sees it by state(): the log goes on.
  }
}

/// One request less, which was a wish or none.
void Recorder::done(std::size_t wishes) {
  const std::lock_guard lock(mutex_);
  --pending_;
  wishes_ -= wishes;
  ended_.notify_all();
}

/// An event of another thread into the temporary log.
void Recorder::keep(const take::Event& event) {
  std::vector<std::byte> record(record_size(event));
  put_record(event, record);
  if (spool_.is_open())
    if (const auto kept = spool_.append(record); !kept) give_up(kept.error().what);
}

/// Keeps the moment of a record that has one.
void Recorder::note_moment(std::span<const std::byte> record) {
  const Kind kind = get<Kind>(record);
  if (kind == Kind::entry) newest_ = get<EntryHead>(record).arrival;
  if (kind == Kind::tick) newest_ = get<sensor::FrameTick>(record).fired;
}

/// All that stands in the queues into the temporary log; no more, however fast more comes. What is small goes
/// first. A payload is handed over before its entry: those of all entries that were taken have been taken
/// too.
void Recorder::drain_queues() {
  std::size_t left = kRecorderRingBytes + kPayloadQueueBytes;
  while (left > 0 && !overrun_ && !payload_overrun_) {
    std::size_t batch = 0;
    while (batch < kBatchBytes) {
      const std::size_t bytes = drain();
      if (bytes == 0) break;
      batch += bytes;
    }
    if (batch == 0) return;
    while (payloads_due_ > 0) batch += drain_payload();
    left -= std::min(left, batch);
  }
}

/// One record of the ring into the temporary log. Returns its size, 0 when there is none.
std::size_t Recorder::drain() {
  const std::span<const std::byte> record = ring_.front();
  if (record.empty()) return 0;
  const std::size_t size = record.size();
  note_moment(record);
  if (std::span<const std::byte> rest = record; get<Kind>(rest) == Kind::entry)
    payloads_due_ += get<EntryHead>(rest).payload_bytes > 0 ? 1 : 0;
  if (spool_.is_open())
    if (const auto kept = spool_.append(record); !kept) give_up(kept.error().what);
  ring_.release();
  return size;
}

/// The same of a payload that is there.
std::size_t Recorder::drain_payload() {
  const std::span<const std::byte> payload = payload_ring_.front();
  const std::size_t size = payload.size();
  if (spool_.is_open())
    if (const auto kept = spool_.append_payload(payload); !kept) give_up(kept.error().what);
  payload_ring_.release();
  --payloads_due_;
  return size;
}

/// A slice of the temporary log into the take; true when there is more.
bool Recorder::feed() {
  if (!writing_ || !spool_.is_open() || writing_->at >= spool_.bytes()) return false;
  slice_.resize(kSliceBytes);
  const auto got = spool_.read(writing_->at, slice_);
  if (!got) {
    give_up(got.error().what);
    return false;
  }
  std::span<const std::byte> left(slice_.data(), *got);
  // Payloads count too: whoever asks for a take late has all of them to copy, and the queues do not wait.
  const auto fed = [this] { return writing_->at + writing_->payload_at; };
  const std::uint64_t before = fed();
  bool any = false;
  while (left.size() >= sizeof(std::uint32_t) && fed() - before < kSliceBytes) {
    std::span<const std::byte> rest = left;
    const auto size = get<std::uint32_t>(rest);
    if (rest.size() < size) break;
    write(rest.first(size));
    if (!writing_) return false;
    left = rest.subspan(size);
    writing_->at += sizeof(size) + size;
    any = true;
  }
  if (!any) give_up("the temporary log of the session cannot be read back");
  return writing_ && writing_->at < spool_.bytes();
}

/// The next payload of the temporary log into payload_; false where it cannot be read, which ends the
/// recording.
bool Recorder::read_payload(std::size_t size) {
  payload_.resize(size);
  if (size == 0) return true;
  const auto got = spool_.read_payloads(writing_->payload_at, payload_);
  if (!got || *got != size) {
    give_up(got ? "the temporary log of the session cannot be read back" : got.error().what);
    return false;
  }
  writing_->payload_at += size;
  return true;
}

/// Ends the take, which may take as long as a slow disk does: nobody who asks for the state waits for it.
void Recorder::conclude(const End& end) {
  for (const take::Note& note : end.notes) writing_->writer.add_note(note.key, note.value);
  const auto finished = writing_->writer.finish();
  writing_.reset();
  const std::lock_guard lock(mutex_);
  is_over(finished ? std::string() : finished.error().message());
}

/// With the lock.
void Recorder::is_over(const std::string& error) {
  state_.on = false;
  state_.error = error;
  over_.push_back({state_.path, error});
  ended_.notify_all();
}

/// The temporary log has a hole from here on: what is recorded ends, and nothing can be recorded any more.
void Recorder::give_up(const std::string& why) {
  if (writing_) [[maybe_unused]]
    const auto kept = writing_->writer.finish();
  const std::lock_guard lock(mutex_);
  if (spool_error_.empty()) spool_error_ = why;
  spool_.close();
  if (writing_) is_over(why);
  writing_.reset();
}

void Recorder::write(std::span<const std::byte> record) {
  Writing& w = *writing_;
  switch (get<Kind>(record)) {
    case Kind::entry: {
      const auto head = get<EntryHead>(record);
      if (!read_payload(head.payload_bytes)) return;
      const std::string_view source = as_text(record.first(head.source_bytes));
      record = record.subspan(head.source_bytes);
      const std::string_view reducer = as_text(record.first(head.reducer_bytes));
      record = record.subspan(head.reducer_bytes);
      w.newest = head.arrival;
      w.entry = w.writer.add_entry(head.arrival, source, record.first(head.bytes), {payload_, reducer});
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

void Recorder::ask(Request request) {
  {
    const std::lock_guard lock(mutex_);
    ++pending_;
    if (std::holds_alternative<Wish>(request)) ++wishes_;
    requests_.push_back(std::move(request));
  }
  signal_.give();
}

void Recorder::start(std::filesystem::path path, take::Header header, bool replace, Begun begun) {
  ask(Wish{std::move(path), std::move(header), replace, std::move(begun)});
}

Result<void> Recorder::start(std::filesystem::path path, take::Header header, bool replace) {
  // Shared: who sets it may still be at it when the result is there.
  const auto begun = std::make_shared<std::promise<Result<void>>>();
  start(std::move(path), std::move(header), replace,
        [begun](Result<void> result) { begun->set_value(std::move(result)); });
  return begun->get_future().get();
}

void Recorder::end(std::vector<take::Note> notes) {
  ask(End{std::move(notes)});
}

Result<void> Recorder::wait() {
  std::unique_lock lock(mutex_);
  ended_.wait(lock, [this] { return !state_.on && pending_ == 0; });
  if (state_.error.empty()) return {};
  return fail(ErrorCode::io, state_.error, state_.path.string(), "what was recorded until then is kept");
}

std::vector<Recorder::Ended> Recorder::take_ended() {
  const std::lock_guard lock(mutex_);
  return std::exchange(over_, {});
}

Recorder::State Recorder::state() const {
  const std::lock_guard lock(mutex_);
  State state = state_;
  state.beginning = wishes_ > 0;
  state.unable = spool_error_;
  return state;
}

}  // namespace mien::live
