#pragma once

#include <atomic>
#include <boost/lockfree/spsc_queue.hpp>
#include <cstdint>
#include <functional>
#include <mutex>
#include <thread>

#include "mien/face/output_frame.h"
#include "mien/live/byte_ring.h"
#include "mien/live/intake.h"
#include "mien/live/link_news.h"
#include "mien/live/recorder.h"
#include "mien/live/signal.h"
#include "mien/session/report.h"
#include "mien/session/session.h"

namespace mien::live {

/// A frame on its way to the sinks.
struct Answer {
  sensor::FrameTick tick;
  HostTime cause;  ///< Arrival of the entry that fired the tick, or the deadline that did.
  face::OutputFrame frame;
};

/// What the tracker's thread says beside frames.
struct OutgoingMessage {
  enum class Kind : std::uint8_t { datagram, reply, event };
  Kind kind = Kind::datagram;
  std::uint64_t to = 0;     ///< Peer of a datagram, client of a reply.
  std::int64_t number = 0;  ///< Of the command replied to.
  std::span<const std::byte> bytes;
};

/// Runs a session on a thread of its own: takes what arrived, fires the ticks that are due, hands answers and
/// words to the network's thread and the log to the recorder. Waits for nobody. What it allocates: heartbeats
/// and reports between frames, calibrations, and devices that are new.
class TrackerLoop {
 public:
  using Clock = std::function<HostTime()>;
  TrackerLoop(session::Session& session, Intake& intake, Recorder& recorder, Clock clock);
  ~TrackerLoop();  ///< As stop().

  /// Before start(): the session's first commands, logged as the page's. Errors: the session's.
  [[nodiscard]] Result<void> execute(std::string_view json_text);
  void start();
  /// Returns when the thread has ended.
  void stop();

  // Network thread.
  [[nodiscard]] Answer* front() { return answers_.read_available() > 0 ? &answers_.front() : nullptr; }
  void release() { answers_.pop(); }
  [[nodiscard]] std::optional<OutgoingMessage> front_said();
  void release_said() { said_.release(); }
  /// There is something to take.
  [[nodiscard]] Signal& signal() { return out_; }
  /// The newest report: at most a quarter of a second old, and not older than the last command that was
  /// replied to. Copies it.
  [[nodiscard]] session::Report report() const;

  /// Frames that found no room, since the network's thread stood still.
  [[nodiscard]] std::uint64_t missed() const { return missed_; }

 private:
  void run();
  void fire(HostTime now, HostTime cause);
  void take(const Arrived& arrived);
  void post(const OutgoingMessage& said);
  void hand_over_news(HostTime now);
  void post_event(std::string_view kind, std::string_view text);
  void look_around(HostTime now);
  void renew_report(HostTime now);
  void tell_of_hold();
  void tell_of_versions();

  session::Session& session_;
  Intake& intake_;
  Recorder& recorder_;
  Clock clock_;
  boost::lockfree::spsc_queue<Answer> answers_;
  ByteRing said_;
  Signal out_;
  std::atomic<bool> stopping_ = false;
  std::atomic<std::uint64_t> missed_ = 0;
  HostTime newest_;
  HostTime next_look_;
  unsigned looks_ = 0;
  std::int64_t versions_ = 0;  // Handed over.
  LinkNews link_news_;
  bool told_held_ = false;            // That frames are held.
  std::size_t unknown_versions_ = 0;  // Told.
  std::vector<sensor::Protocol::Outgoing> outgoing_;
  session::Report draft_;
  mutable std::mutex report_mutex_;
  session::Report report_;
  std::thread thread_;
};

}  // namespace mien::live
