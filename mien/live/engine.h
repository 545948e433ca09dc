#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/live/dataset_shelf.h"
#include "mien/live/feeds.h"
#include "mien/live/latency.h"
#include "mien/live/page_messages.h"
#include "mien/live/page_server.h"
#include "mien/live/phone_lesson.h"
#include "mien/live/player.h"
#include "mien/live/serial_port.h"
#include "mien/live/spool.h"
#include "mien/session/command.h"
#include "mien/session/prompt.h"
#include "mien/session/session.h"
#include "mien/sink/sink.h"
#include "mien/take/take.h"

namespace mien::live {

/// How a board becomes one that the session receives when it has a key.
struct Pairing {
  std::string file;      ///< The key's.
  std::string firmware;  ///< The line with the key for the board's sketch.
  std::string command;   ///< What starts a session with the key.
};

/// What a live session is asked for.
struct EngineSettings {
  std::vector<std::string> listen;  ///< udp://HOST:PORT or serial:DEVICE[?baud=RATE], one or more.
  std::map<std::string, LineCamera> line_cameras;  ///< Those that may speak on serial ones, by their text.
  std::vector<Feed> feeds;                         ///< Beside them.
  bool hear = true;   ///< Whether they are wanted from the beginning on (FeedPort::wanted).
  bool shut = false;  ///< No sound is taken from anywhere, whatever the page says; no feed should bring any.
  std::string network_microphone;  ///< The rig's that sends here, by its name; empty: none does.
  std::vector<std::string> out;    ///< Sinks' addresses, as sink::open_sink takes them.
  std::optional<std::filesystem::path> record;
  bool replace = false;  ///< An existing take.
  /// Where takes go that the page asks for, where it finds those to show, and where the session is kept while
  /// it runs, in a file without a name.
  std::filesystem::path takes = ".";
  /// What a page may have performers read and do for a dataset.
  DatasetShelf::Scripts scripts = [] { return std::vector<RecordingScript>(); };
  /// How the wearer is learnt from a phone; empty: it is not.
  PhoneLesson::Settings lesson;
  /// What that file may take, bytes (Spool). A session that reaches it goes on and can be recorded no more.
  std::uint64_t log_limit = Spool::kDefaultLimit;
  bool sealed = false;                ///< The session has keys: said, not seen to.
  std::vector<std::string> unsealed;  ///< Cameras, whose pictures no key seals: the same.
  /// Makes or reads the key that the page shows to whom it lets in; empty: it shows none. Network thread.
  std::function<Result<Pairing>()> pair;
  std::optional<PageSettings> page;
  std::optional<double> seconds;           ///< Ends by itself after this time.
  std::vector<session::Command> commands;  ///< The session's first, logged as the page's.
  std::vector<session::Prompt> prompts;    ///< Poses to ask for, from the beginning on.
  /// The session is there for `record` alone: it ends when its prompts are over, or its recording is.
  bool ends_with_recording = false;
  std::filesystem::path rig;         ///< The file of the rig, which the page may save views in; empty: none.
  take::Header header;               ///< Of takes; rig and time are filled in by whoever fills the rest.
  std::string model;                 ///< Name of the live model, for the page and takes.
  Player::MakeSession make_session;  ///< For takes that the page looks at.
};

/// How a session went.
struct EngineSummary {
  std::uint64_t frames = 0;
  std::uint64_t missed = 0;  ///< Frames that no sink was offered.
  std::string kernels;       ///< modalities::live_kernels().
  std::string hash;
  Latencies latency;  ///< From the arrival of the entry that fired a frame to its packets sent.
  std::uint64_t datagrams = 0;
  std::uint64_t dropped = 0;  ///< Too fast, too long, too many, or while the tracker was behind.
  std::vector<std::string> listening;
  NetworkState network;       ///< At the end; what came in elsewhere is in `dropped` too.
  std::uint64_t evicted = 0;  ///< Senders that were forgotten for others; none of them said anything sound.
  std::uint64_t malformed = 0;
  std::vector<sink::Status> sinks;
  std::vector<SerialPort::Status> lines;  ///< Serial ones.
  std::vector<CameraStatus> cameras;      ///< As Status has them.
  std::optional<std::filesystem::path> take;
  std::string recording_error;
  Spool::Usage log;        ///< What the session's temporary log took, at its end.
  session::Report report;  ///< The last.
};

/// Who is told how a session goes, on the thread that runs it; each may be empty.
struct EngineListener {
  /// Each thing that a person should see at once ("mentalis is lost").
  std::function<void(const std::string&)> told;
  /// How it is, five times a second.
  std::function<void(const Status&)> seen;
};

/// A live session on the machine's clock: one event loop for everything of the network, a thread for the
/// tracker, one for the take, one for the video beside it.
class Engine {
 public:
  /// Opens every port, sink and take. Errors: theirs.
  [[nodiscard]] static Result<std::unique_ptr<Engine>> open(EngineSettings settings,
                                                            std::unique_ptr<session::Session> session);
  ~Engine();

  /// The addresses that devices may send to, with their ports.
  [[nodiscard]] const std::vector<std::string>& listening() const;
  /// Who can reach them now. Before run().
  [[nodiscard]] NetworkState network() const;
  /// Where a browser finds the page; empty without one.
  [[nodiscard]] std::string page() const;

  /// How many look at the page now. Any thread.
  [[nodiscard]] std::size_t watchers() const;

  /// Runs until `stop` is set, looked at ten times a second, or the time, the prompts or the recording are
  /// over.
  [[nodiscard]] Result<EngineSummary> run(const std::atomic<bool>& stop, const EngineListener& listener);

 private:
  struct State;
  explicit Engine(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace mien::live
