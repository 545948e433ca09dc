#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <thread>
#include <variant>
#include <vector>

#include "mien/core/error.h"
#include "mien/live/byte_ring.h"
#include "mien/live/signal.h"
#include "mien/live/spool.h"
#include "mien/sensor/payload.h"
#include "mien/sensor/ticks.h"
#include "mien/take/take.h"

namespace mien::live {

/// Writes a session's log into takes, on a thread of its own: the tracker's thread hands over and goes on,
/// and nobody waits for the disk but who asks for a take's end. Everything goes into a temporary log first,
/// and from there into the take that is recorded: so a take begins with the session's beginning, whenever its
/// recording was asked for, and replays to what was seen. Payloads go by a queue and a file of their own, so
/// that a disk which is too slow for pictures keeps nothing else waiting; but a log that lacks one of them is
/// none, and ends as one that lacks an entry does.
class Recorder {
 public:
  /// What payloads may be behind the disk, bytes: 127 of the longest, two seconds of 60 pictures a second.
  /// The machine's memory is taken as they come.
  static constexpr std::size_t kPayloadQueueBytes = std::size_t{1} << 25U;

  /// The temporary log stands in `folder`, that of the takes (empty: the present one): where takes have room,
  /// it has; where there is no such folder, nothing can be recorded. It takes up to `log_limit` bytes, as
  /// Spool has it.
  explicit Recorder(const std::filesystem::path& folder, std::uint64_t log_limit = Spool::kDefaultLimit);
  ~Recorder();  ///< Ends the thread; a take that is recorded stays as far as it came.

  // Tracker's thread. What does not fit any more is lost to the recording, which then ends with an error.
  /// `source`: the sender's text. `payload`: what stands beside the bytes, at most sensor::kMaxPayload; empty
  /// for none.
  void entry(HostTime arrival, std::string_view source, std::span<const std::byte> bytes,
             std::span<const sensor::Sample> samples, const sensor::Payload& payload = {});
  void command(HostTime arrival, std::string_view json_text);
  void tick(const sensor::FrameTick& tick);
  void event(const take::Event& event);
  void calibration(std::int64_t id, DeviceTime made, std::string_view modality, std::string_view json_text);

  // Any thread.
  /// An event that no tracker knows of. It comes behind what was handed over when the recorder next looks.
  void note(take::Event event);

  // Another thread, always the same.
  /// Told once, on the recorder's thread: errors of start(). It hands over and throws nothing.
  using Begun = std::function<void(Result<void>)>;
  // What is asked for is done in its order.
  /// Makes the take's file in the background, since a disk may take its time; what the session was so far
  /// follows. A recorder that ends meanwhile tells nothing.
  void start(std::filesystem::path path, take::Header header, bool replace, Begun begun);
  /// The same, and waits until it has begun. Errors: bad_usage (a recording runs, the file exists and not
  /// `replace`), io (what has to come first was lost); TakeWriter's.
  [[nodiscard]] Result<void> start(std::filesystem::path path, take::Header header, bool replace);
  /// Asks for the end of the recording, with notes; state() tells when it is reached. Nothing happens when
  /// none runs.
  void end(std::vector<take::Note> notes);
  /// Waits for that. Everything is on the disk when this returns. Errors: why the recording ended early.
  [[nodiscard]] Result<void> wait();

  struct State {
    bool on = false;         ///< From when its file is there until all is on the disk.
    bool beginning = false;  ///< One is asked for that has neither begun nor been refused.
    std::filesystem::path path;
    double seconds = 0;  ///< Since the recording was asked for; what the session was before comes on top.
    std::string error;   ///< Why the recording ended early; empty when it did not.
    std::string unable;  ///< Why nothing can be recorded any more in this session; empty when it can.
    Spool::Usage log;    ///< What the temporary log takes and may take, a tenth of a second old.
  };
  [[nodiscard]] State state() const;

  /// A recording that is over.
  struct Ended {
    std::filesystem::path path;
    std::string error;  ///< Why it ended early; empty when it did not.
  };
  /// Those since the last call, in their order.
  [[nodiscard]] std::vector<Ended> take_ended();

 private:
  struct Writing;
  /// A recording that is asked for.
  struct Wish {
    std::filesystem::path path;
    take::Header header;
    bool replace = false;
    Begun begun;
  };
  /// The end of the one that runs; nothing where none does.
  struct End {
    std::vector<take::Note> notes;
  };
  using Request = std::variant<Wish, End>;
  struct Opening;
  enum class Kind : std::uint8_t { entry, command, tick, event, calibration };
  std::span<std::byte> claim(std::size_t size);
  void run();
  void turn();
  void take_over();
  void open(Wish wish);
  [[nodiscard]] Result<void> check_can_begin(const Wish& wish) const;
  [[nodiscard]] bool settle();
  void tell(const Wish& wish, Result<void> begun);
  void done(std::size_t wishes);
  void ask(Request request);
  [[nodiscard]] static std::size_t record_size(const take::Event& event);
  static void put_record(const take::Event& event, std::span<std::byte> room);
  void keep(const take::Event& event);
  void drain_queues();
  std::size_t drain();
  std::size_t drain_payload();
  void note_moment(std::span<const std::byte> record);
  bool feed();
  void write(std::span<const std::byte> record);
  [[nodiscard]] bool read_payload(std::size_t size);
  void conclude(const End& end);
  void give_up(const std::string& why);
  void is_over(const std::string& error);

  ByteRing ring_;
  ByteRing payload_ring_;  // A payload is there before its entry is.
  Signal signal_;
  std::atomic<bool> overrun_ = false;
  std::atomic<bool> payload_overrun_ = false;
  std::atomic<bool> stopping_ = false;

  // The recorder's thread alone.
  std::unique_ptr<Writing> writing_;
  std::unique_ptr<Opening> opening_;
  Spool spool_;
  HostTime newest_;               // Of all that was drained.
  std::size_t payloads_due_ = 0;  // Of entries that were drained, and are in the other queue.
  std::vector<std::byte> slice_;
  std::vector<std::byte> payload_;

  mutable std::mutex mutex_;  // Held for moments only.
  std::condition_variable ended_;
  std::deque<Request> requests_;
  // Requests that are not done yet, and how many of them are wishes; one is not in the queue any more.
  std::size_t pending_ = 0, wishes_ = 0;
  std::vector<take::Event> noted_;
  std::vector<Ended> over_;
  State state_;
  std::string spool_error_;  // Why no recording can begin any more.
  std::jthread thread_;
};

}  // namespace mien::live
