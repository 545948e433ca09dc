#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/time.h"
#include "mien/live/sentence.h"
#include "mien/live/video_message.h"
#include "mien/live/video_writer.h"

namespace mien::live {

/// What the page is told of the video beside a dataset's recording.
struct VideoState {
  bool agreed = false;        ///< A recording runs whose performer agreed to it.
  bool on = false;            ///< Video is being written.
  std::string file;           ///< The newest one's name; empty before the first.
  std::size_t files = 0;      ///< Of this recording.
  double megabytes = 0;       ///< In these together.
  std::string trouble;        ///< Why none is written now, or what is wrong; empty: nothing.
  std::uint64_t refused = 0;  ///< Messages of browsers that were not taken.
};

/// The video of a performer's face beside a dataset's recording: the camera of one browser at a time, as its
/// page sends it, into a file beside the take, where the performer agreed to it. A gap in what is sent,
/// another MediaRecorder or another browser begins another file. Whatever happens to it, the recording goes
/// on. Network thread.
class VideoRecording {
 public:
  /// More is not taken in the long run, bytes a second; at once so much may come, bytes.
  static constexpr double kMostBytes_s = 4e6;
  static constexpr double kBurstBytes = 16e6;
  /// Another browser may take the place of one that has sent nothing for so long, ...
  static constexpr Duration kGone = std::chrono::seconds(3);
  /// ... and what is missing is told after so long.
  static constexpr Duration kSilent = std::chrono::seconds(5);
  /// The page may take so long to send the last of a recording that is over.
  static constexpr Duration kLastChunk = std::chrono::seconds(2);
  /// A message costs so many bytes beside its own: a browser sends one a second.
  static constexpr std::size_t kMessageBytes = 64 << 10;
  /// And each file's beginning so many: one in half a second in the long run.
  static constexpr std::size_t kFileBytes = 2'000'000;

  /// `reserve_bytes`: as VideoWriter's.
  explicit VideoRecording(std::uint64_t reserve_bytes = VideoWriter::kReserveBytes)
      : writer_(reserve_bytes) {}

  /// A recording begins whose performer agreed to video.
  void allow(const std::filesystem::path& take);
  /// It is over: the page is told to stop, and what it sends until then is the last.
  void finish(HostTime now);
  /// No video is written, and none will be.
  [[nodiscard]] bool is_over() const { return !agreed_ && videos_.empty(); }
  /// The session ends: what was handed over is written when this returns. look() then tells the rest.
  void close(HostTime now);

  /// What a client asks for by the command `video`: that its camera is recorded from now on, or no more.
  /// Errors: bad_usage (nobody agreed, another browser's is recorded).
  [[nodiscard]] Result<void> camera(std::uint64_t client, bool on, HostTime now);
  /// Whose camera is recorded; 0: nobody's.
  [[nodiscard]] std::uint64_t client() const { return client_; }
  /// A binary message of a client.
  void take(std::uint64_t client, std::span<const std::byte> bytes, HostTime now);

  /// What follows: for people, for the take's log, and for browsers.
  struct News {
    struct Event {
      std::string kind;  ///< "video" or "video_over" (docs/reference/page_protocol.md).
      std::string json;
    };
    /// A browser is to stop, or to begin anew.
    struct Stop {
      std::uint64_t client = 0;
      std::string why;
      bool again = false;
    };
    std::vector<Sentence> sentences;  ///< "video" or "video_failed".
    std::vector<Event> events;
    std::vector<Stop> stops;
  };
  /// To be called often. `here`: whether client() is still there.
  [[nodiscard]] News look(HostTime now, bool here);

  /// None where nobody has ever agreed, or sent any.
  [[nodiscard]] std::optional<VideoState> state() const;

 private:
  /// One file.
  struct Video {
    VideoContainer container = VideoContainer::webm;
    HostTime received;          // Of its first chunk, whose age was ...
    std::uint32_t age_ms = 0;   // ... this.
    Duration zero{};            // Its first frame on the session's clock: no chunk came sooner after it.
    std::uint32_t next = 0;     // The sequence number that should come.
    std::uint32_t last_ms = 0;  // Age of the newest chunk.
    std::string file;           // Once it is made.
    std::string ended;          // Why; empty while it is written.
    bool failed = false;
  };
  void refuse(std::uint64_t client, const std::string& why);
  [[nodiscard]] Video* open_video();
  void begin_video(const VideoMessage& chunk, HostTime now);
  void end_video(const std::string& why, bool failed);
  void release(const std::string& why, bool again = false);
  void fail_video(const std::string& why, bool again = false);
  [[nodiscard]] bool pay(std::size_t bytes, HostTime now);
  void over();
  void see(const VideoWriter::Report& report);

  VideoWriter writer_;
  std::filesystem::path take_;
  bool agreed_ = false;
  std::optional<HostTime> finishing_;  // When the recording ended; the last chunk is waited for.
  std::uint64_t client_ = 0;
  std::uint64_t former_ = 0;      // The last one that was: what it still sends is no news.
  HostTime heard_;                // When it was let in, or sent the newest chunk.
  std::set<std::uint64_t> told_;  // Clients whose refusal was told.
  double allowance_ = kBurstBytes;
  HostTime paid_;
  std::uint64_t newest_ = 0;               // Number of the newest video; 0: none.
  std::map<std::uint64_t, Video> videos_;  // Those that are not closed.
  VideoState state_;
  std::uint64_t bytes_before_ = 0;  // Of recordings before.
  News news_;
};

}  // namespace mien::live
