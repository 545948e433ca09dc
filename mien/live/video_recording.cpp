#include "mien/live/video_recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "mien/session/json_fields.h"

namespace mien::live {
namespace {

constexpr double kVideoMegabyte = 1e6;
/// Of more clients in one recording no refusal is told; it is counted.
constexpr std::size_t kMostTold = 20;
/// What was agreed to and is over, as a video's end says it.
const char* const kRecordingOver = "the recording is over";

double clock_seconds(Duration since_start) {
  return std::round(1e3 * to_seconds(since_start)) / 1e3;
}

}  // namespace

void VideoRecording::allow(const std::filesystem::path& take) {
  if (agreed_) over();  // Of a recording that ended by itself.
  take_ = take;
  agreed_ = true;
  finishing_.reset();
  client_ = former_ = 0;
  told_.clear();
  bytes_before_ = writer_.bytes();
  state_ = {.refused = state_.refused};
}

void VideoRecording::finish(HostTime now) {
  if (!agreed_ || finishing_) return;
  finishing_ = now;
  if (open_video() == nullptr) return over();
  // Not let go: its last chunk is to come.
  news_.stops.push_back({client_, "", false});
}

void VideoRecording::close(HostTime now) {
  if (agreed_) finish(now);
  if (agreed_) over();
  writer_.wait();
}

Result<void> VideoRecording::camera(std::uint64_t client, bool on, HostTime now) {
  if (!on) {
    if (client != client_ || client == 0) return {};
    if (open_video() != nullptr) end_video(finishing_ ? kRecordingOver : "the page stopped it", false);
    former_ = std::exchange(client_, 0);
    if (finishing_) over();
    return {};
  }
  if (!agreed_ || finishing_)
    return fail(ErrorCode::bad_usage, "no dataset is recorded whose performer agreed to video", "video",
                "it is agreed to with the consent, before the recording begins");
  if (client_ != 0 && client_ != client) {
    if (now - heard_ < kGone)
      return fail(ErrorCode::bad_usage, "another browser's camera is recorded", "video",
                  "stop it there, or close that page, and try again");
    if (open_video() != nullptr) end_video("another browser took its place", true);
    release("Another browser's camera is recorded instead.");
  }
  client_ = client;
  heard_ = now;
  state_.trouble.clear();
  return {};
}

void VideoRecording::refuse(std::uint64_t client, const std::string& why) {
  ++state_.refused;
  // A browser that was told to stop has some on the way.
  if (client == former_ || told_.size() == kMostTold || !told_.insert(client).second) return;
  news_.sentences.push_back({"video_failed", "video of a browser is not recorded: " + why});
}

void VideoRecording::take(std::uint64_t client, std::span<const std::byte> bytes, HostTime now) {
  if (!agreed_)
    return refuse(client,
                  "no dataset is recorded whose performer agreed to it; it is agreed to with the consent");
  if (client != client_)
    return refuse(client, client_ == 0 ? "it was not asked for; use the camera from the page's check"
                                       : "another browser's camera is; stop it there first");
  const Result<VideoMessage> chunk = parse_video_message(bytes);
  if (!chunk) return refuse(client, chunk.error().message());
  heard_ = now;
  if (!pay(bytes.size() + kMessageBytes + (chunk->sequence == 0 ? kFileBytes : 0), now))
    return fail_video(fmt::format("more than {:g} MB a second came for a while; let the page send less",
                                  kMostBytes_s / kVideoMegabyte));
  Video* video = open_video();
  if (chunk->sequence == 0 && !finishing_) {
    if (video != nullptr) end_video("the browser began anew", true);
    begin_video(*chunk, now);
    video = open_video();
  }
  if (video == nullptr) {  // The page was told to begin anew, and has not heard of it yet.
    ++state_.refused;
    return;
  }
  if (chunk->container != video->container || chunk->sequence < video->next)
    return refuse(client, fmt::format("the chunk {} came twice, or of another kind; load the page anew",
                                      chunk->sequence));
  if (const std::uint32_t missing = chunk->sequence - video->next; missing > 0) {
    ++state_.refused;
    return fail_video(
        fmt::format("chunks that the browser sent are missing ({}); another file begins", missing), true);
  }
  ++video->next;
  video->last_ms = chunk->age_ms;
  const Duration age = std::chrono::milliseconds(chunk->age_ms);
  video->zero = std::min(video->zero, now.time_since_epoch() - age);
  if (!writer_.append(newest_, chunk->data))
    fail_video("the disk is too slow for it; record to another one, then use the camera again");
}

bool VideoRecording::pay(std::size_t bytes, HostTime now) {
  allowance_ = std::min(kBurstBytes, allowance_ + kMostBytes_s * to_seconds(now - paid_));
  paid_ = now;
  allowance_ -= static_cast<double>(bytes);
  if (allowance_ >= 0) return true;
  allowance_ = 0;
  return false;
}

VideoRecording::Video* VideoRecording::open_video() {
  const auto found = videos_.find(newest_);
  return found != videos_.end() && found->second.ended.empty() ? &found->second : nullptr;
}

void VideoRecording::begin_video(const VideoMessage& chunk, HostTime now) {
  ++newest_;
  writer_.open(newest_, take_, chunk.container);
  Video& video = videos_[newest_];
  video.container = chunk.container;
  video.received = now;
  video.age_ms = chunk.age_ms;
  video.zero = now.time_since_epoch() - std::chrono::milliseconds(chunk.age_ms);
  state_.trouble.clear();
}

void VideoRecording::end_video(const std::string& why, bool failed) {
  Video* const video = open_video();
  video->ended = why;
  video->failed = failed;
  writer_.close(newest_);
}

/// The browser that is recorded is to stop.
void VideoRecording::release(const std::string& why, bool again) {
  if (client_ == 0) return;
  news_.stops.push_back({client_, why, again});
  if (!again) former_ = std::exchange(client_, 0);
}

void VideoRecording::fail_video(const std::string& why, bool again) {
  if (open_video() != nullptr) end_video(why, true);
  state_.trouble = why;
  release(fmt::format("The video ended: {}.", why), again);
  if (finishing_) over();
}

/// Nothing comes any more of a recording that is over.
void VideoRecording::over() {
  if (open_video() != nullptr) end_video(kRecordingOver, false);
  release("");
  agreed_ = false;
  finishing_.reset();
}

void VideoRecording::see(const VideoWriter::Report& report) {
  const auto found = videos_.find(report.video);
  if (found == videos_.end()) return;
  Video& video = found->second;
  if (video.file.empty() && !report.file.empty()) {
    video.file = report.file.filename().string();
    ++state_.files;
    state_.file = video.file;
    news_.events.push_back(
        {"video", session::dumped({{"file", video.file},
                                   {"container", container_name(video.container)},
                                   {"received_s", clock_seconds(video.received.time_since_epoch())},
                                   {"age_s", 1e-3 * video.age_ms}})});
    news_.sentences.push_back(
        {"video", fmt::format("video is recorded to {}{}", report.file.string(),
                              state_.files > 1 ? ", another file: the one before ended" : "")});
  }
  if (!report.error.empty() && video.ended.empty()) {
    // Only the newest can be open.
    const std::string why = report.error + "; make room, then use the camera again";
    end_video(why, true);
    state_.trouble = why;
    release(fmt::format("The video ended: {}.", why));
    if (finishing_) over();
  } else if (!report.error.empty()) {
    video.failed = true;
    video.ended = report.error;
  }
  if (!report.closed) return;
  if (!video.file.empty())
    news_.events.push_back({"video_over", session::dumped({{"file", video.file},
                                                           {"bytes", report.bytes},
                                                           {"chunks", video.next},
                                                           {"zero_s", clock_seconds(video.zero)},
                                                           {"last_s", 1e-3 * video.last_ms},
                                                           {"ended", video.ended}})});
  if (video.failed)
    news_.sentences.push_back(
        {"video_failed", fmt::format("the video ended after {:.1f} MB: {}",
                                     static_cast<double>(report.bytes) / kVideoMegabyte, video.ended)});
  else
    news_.sentences.push_back({"video", fmt::format("{} is written, {:.1f} MB of video", report.file.string(),
                                                    static_cast<double>(report.bytes) / kVideoMegabyte)});
  videos_.erase(found);
}

VideoRecording::News VideoRecording::look(HostTime now, bool here) {
  for (const VideoWriter::Report& report : writer_.take_reports()) see(report);
  if (client_ != 0 && !here) {
    if (open_video() != nullptr) {
      const char* const gone = "the browser that filmed is gone; it goes on in another file when it is back";
      if (!finishing_) state_.trouble = gone;
      end_video(finishing_ ? kRecordingOver : gone, !finishing_);
    }
    former_ = std::exchange(client_, 0);
    if (finishing_) over();
  }
  if (finishing_ && now - *finishing_ >= kLastChunk) over();
  // What was told is told once: until a chunk comes.
  const std::string silent = "no video comes from the browser any more; look at its page";
  if (client_ != 0 && open_video() != nullptr && now - heard_ >= kSilent) {
    if (std::exchange(state_.trouble, silent) != silent) news_.sentences.push_back({"video_failed", silent});
  } else if (state_.trouble == silent) {
    state_.trouble.clear();
  }
  return std::exchange(news_, {});
}

std::optional<VideoState> VideoRecording::state() const {
  if (!agreed_ && newest_ == 0 && state_.refused == 0) return std::nullopt;
  VideoState state = state_;
  state.agreed = agreed_ && !finishing_;
  const auto newest = videos_.find(newest_);
  state.on = newest != videos_.end() && newest->second.ended.empty();
  state.megabytes = static_cast<double>(writer_.bytes() - bytes_before_) / kVideoMegabyte;
  return state;
}

}  // namespace mien::live
