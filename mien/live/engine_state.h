#pragma once

#include <utility>  // Before Asio 1.74, which forgets it.

#include <array>
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mien/live/camera_news.h"
#include "mien/live/dataset_recording.h"
#include "mien/live/dataset_shelf.h"
#include "mien/live/engine.h"
#include "mien/live/fast_sender_news.h"
#include "mien/live/intake.h"
#include "mien/live/page_pictures.h"
#include "mien/live/phone_lesson.h"
#include "mien/live/recorder.h"
#include "mien/live/recording_news.h"
#include "mien/live/take_listing.h"
#include "mien/live/tracker_loop.h"
#include "mien/live/unheard.h"
#include "mien/live/video_recording.h"

// A session's parts, and who runs what of them: the engine's own, shared by engine.cpp, which runs them, and
// engine_requests.cpp, which does what pages ask. Everything on the network's thread but where it says so.
namespace mien::live {

/// Whose the engine's own commands are: no page's.
inline constexpr std::uint64_t kNobody = 0;
/// The rolling latency is that of this many beats: ten seconds, in pieces of one.
inline constexpr std::size_t kLatencyPieces = 10;

struct Engine::State {
  State(EngineSettings s, std::unique_ptr<session::Session> made)
      : settings(std::move(s)),
        session(std::move(made)),
        begun(std::chrono::steady_clock::now()),
        network(1),
        intake(network, [this] { return now(); }),
        recorder(settings.takes, settings.log_limit),
        loop(*session, intake, recorder, [this] { return now(); }),
        player(settings.make_session),
        listing(settings.takes, [this] { boost::asio::post(network, [this] { send_takes(); }); }),
        shelf(settings.takes, settings.scripts),
        lesson(settings.lesson,
               [this](Result<TaughtByPhone> taught) {
                 boost::asio::post(network, [this, taught = std::move(taught)] { finish_lesson(taught); });
               }),
        wake(network),
        beat(network),
        play(network) {}

  [[nodiscard]] HostTime now() const {
    return HostTime(std::chrono::duration_cast<Duration>(std::chrono::steady_clock::now() - begun));
  }

  struct Outlet {
    std::int64_t id = 0;
    bool on = true;
    std::unique_ptr<sink::Sink> sink;
    std::string told;  // What is wrong with it, as it was said last.
  };

  Result<void> add_sink(const std::string& address);
  void wait_for_answers();
  void take_answers();
  void send_frame(const Answer& answer);
  void wait_for_beat();
  void on_beat();
  [[nodiscard]] bool recording_is_over() const;
  [[nodiscard]] std::vector<CameraStatus> cameras() const;
  [[nodiscard]] Status status() const;
  [[nodiscard]] NetworkState network_state() const;
  void look_at_interfaces();
  void on_message(std::uint64_t client, std::string_view text);
  void answer(std::uint64_t client, std::string_view text);
  Result<std::string> execute(std::uint64_t client, const nlohmann::json& command);
  Result<std::string> execute_sink(const nlohmann::json& command);
  Result<std::string> execute_replay(const nlohmann::json& command);
  Result<std::string> execute_listen(const nlohmann::json& command);
  Result<std::string> execute_pair();
  /// What a command came to, with what its reply adds; network thread.
  using Answered = std::function<void(const Result<std::string>&)>;
  /// The commands whose answer waits for somebody else.
  void answer_record(const nlohmann::json& command, const Answered& answered);
  void answer_dataset(const nlohmann::json& command, const Answered& answered);
  void begin_dataset(const DatasetPlan& plan, const Answered& answered);
  Result<std::string> go_through(const DatasetPlan& plan);
  void answer_lesson(const nlohmann::json& command, const Answered& answered);
  Result<void> begin_lesson(const Answered& answered);
  void finish_lesson(const Result<TaughtByPhone>& taught);
  /// Commands of the engine's own. False: no room for them.
  [[nodiscard]] bool tell_session(const std::vector<session::Command>& commands);
  void own_command_failed(const std::string& why);
  void follow_recordings(const Recorder::State& recording, const session::Report& report);
  /// Ends the recording once the video beside it has ended.
  void end_recording();
  void on_bytes(std::uint64_t client, std::span<const std::byte> bytes);
  void look_at_video();
  Result<std::string> execute_video(std::uint64_t client, const nlohmann::json& command);
  [[nodiscard]] std::filesystem::path growing() const;
  [[nodiscard]] nlohmann::json list_takes(bool read_lengths);
  void send_takes();
  void wait_for_play();
  /// `then`: once it has begun, or cannot; network thread.
  void start_recording(const std::filesystem::path& path, take::Header header,
                       std::function<void(const Result<void>&)> then);
  void has_begun(const std::filesystem::path& path);
  [[nodiscard]] std::vector<take::Note> notes() const;
  void tell(const std::string& kind, const std::string& text);

  EngineSettings settings;
  std::unique_ptr<session::Session> session;
  std::chrono::steady_clock::time_point begun;
  boost::asio::io_context network;
  Intake intake;
  Recorder recorder;
  TrackerLoop loop;
  Feeds feeds;  // Before what they fill is gone they have ended.
  PagePictures pictures;
  Player player;
  TakeListing listing;
  DatasetShelf shelf;
  DatasetRecording dataset;
  bool dataset_dropped = false;  // Ended while its takes were read, or its file was made.
  PhoneLesson lesson;
  VideoRecording video;
  std::optional<HostTime> ending;      // Since when the recording waits for the end of its video.
  std::vector<session::Command> held;  // Told to the session once the take is closed.
  boost::asio::posix::stream_descriptor wake;
  boost::asio::steady_timer beat;
  boost::asio::steady_timer play;  // Runs while the page looks at a take.
  std::unique_ptr<PageServer> page;
  std::vector<std::string> listening;
  std::vector<std::string> open;             // Those on every interface, ...
  std::vector<NetworkInterface> interfaces;  // ... and by what they are reached, as of a second ago.
  std::vector<Outlet> outlets;
  LineNews line_news;
  FastSenderNews fast_sender_news;
  std::vector<Intake::FastSender> fast_senders;  // Kept for its memory.
  std::int64_t next_sink = 1;

  Latencies latency;
  std::array<Latencies, kLatencyPieces> pieces;
  std::size_t piece = 0;
  int beats = 0;
  int beats_over = 0;  // Since the recording was over that the session is there for.
  std::uint64_t frames = 0;
  std::string frame_text;
  RecordingNews recording_news;
  bool told_silent = false;        // That nothing is heard; already told, ...
  bool told_uncalibrated = false;  // ... as this.
  UnheardMicrophone unheard_microphone{settings.network_microphone};
  std::atomic<std::size_t> watchers = 0;
  const std::atomic<bool>* stop = nullptr;
  EngineListener listener;
};

}  // namespace mien::live
