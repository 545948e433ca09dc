#include "app/live/microphone.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <portaudio.h>
#include <unistd.h>

#include <algorithm>
#include <boost/lockfree/spsc_queue.hpp>
#include <chrono>
#include <future>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include "mien/speech/block_maker.h"
#include "mien/speech/sound_block.h"

namespace mien::app {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kRetry = std::chrono::seconds(1);
constexpr auto kLook = std::chrono::milliseconds(50);
constexpr auto kPoll = std::chrono::milliseconds(3);
/// Without a sample for so long a microphone was pulled out.
constexpr auto kGone = std::chrono::seconds(1);
/// Below it for so long a microphone is told to be silent: a quiet room is louder.
constexpr float kSilence = 3e-4F;
constexpr auto kSilent = std::chrono::seconds(5);
/// A stream that falls so far behind has lost sound, ...
constexpr double kLost_s = 0.2;
/// ... beside what it was behind over about so long.
constexpr auto kDrift = std::chrono::seconds(10);

/// ALSA and JACK tell standard error of everything that they do not find.
class QuietErrors {
 public:
  QuietErrors() : kept_(::fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 0)) {
    if (kept_ < 0) return;
    const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
    if (nowhere < 0) return;
    ::dup2(nowhere, STDERR_FILENO);
    ::close(nowhere);
  }
  QuietErrors(const QuietErrors&) = delete;
  QuietErrors& operator=(const QuietErrors&) = delete;
  ~QuietErrors() {
    if (kept_ < 0) return;
    ::dup2(kept_, STDERR_FILENO);
    ::close(kept_);
  }

 private:
  int kept_;
};

/// PortAudio while it is used. It looks for devices when it starts, and only then.
class PortAudio {
 public:
  PortAudio() {
    const QuietErrors quiet;
    error_ = Pa_Initialize();
  }
  PortAudio(const PortAudio&) = delete;
  PortAudio& operator=(const PortAudio&) = delete;
  ~PortAudio() {
    if (error_ == paNoError) Pa_Terminate();
  }
  [[nodiscard]] bool works() const { return error_ == paNoError; }
  [[nodiscard]] std::string error() const { return Pa_GetErrorText(error_); }

 private:
  PaError error_;
};

/// Devices that give sound, the default one first.
std::vector<PaDeviceIndex> inputs() {
  std::vector<PaDeviceIndex> found;
  const PaDeviceIndex first = Pa_GetDefaultInputDevice();
  if (first != paNoDevice) found.push_back(first);
  for (PaDeviceIndex i = 0; i < Pa_GetDeviceCount(); ++i)
    if (i != first && Pa_GetDeviceInfo(i)->maxInputChannels > 0) found.push_back(i);
  return found;
}

std::optional<PaDeviceIndex> find_input(const std::string& name) {
  for (const PaDeviceIndex i : inputs())
    if (name == "default" || std::string_view(Pa_GetDeviceInfo(i)->name).find(name) != std::string_view::npos)
      return i;
  return std::nullopt;
}

/// A stream that is open. PortAudio's own thread brings the sound; nothing waits in there.
class Stream {
 public:
  static std::unique_ptr<Stream> open(PaDeviceIndex device, std::string& why) {
    const PaDeviceInfo* const info = Pa_GetDeviceInfo(device);
    const PaStreamParameters want{.device = device,
                                  .channelCount = 1,
                                  .sampleFormat = paFloat32,
                                  .suggestedLatency = info->defaultLowInputLatency,
                                  .hostApiSpecificStreamInfo = nullptr};
    // Its own rate: what it is asked for otherwise is worse than what libsamplerate makes.
    auto stream = std::unique_ptr<Stream>(new Stream(static_cast<int>(info->defaultSampleRate)));
    const QuietErrors quiet;
    PaError error = Pa_OpenStream(&stream->stream_, &want, nullptr, info->defaultSampleRate,
                                  paFramesPerBufferUnspecified, paNoFlag, &Stream::take, stream.get());
    if (error == paNoError) error = Pa_StartStream(stream->stream_);
    if (error == paNoError) return stream;
    why = Pa_GetErrorText(error);
    return nullptr;
  }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;
  ~Stream() {
    if (stream_ != nullptr) Pa_CloseStream(stream_);
  }
  [[nodiscard]] int rate_hz() const { return rate_hz_; }
  /// What has come since; empty: nothing yet.
  std::span<const float> read() {
    return std::span(piece_).first(waiting_.pop(piece_.data(), piece_.size()));
  }
  [[nodiscard]] bool is_active() const { return Pa_IsStreamActive(stream_) == 1; }

 private:
  explicit Stream(int rate_hz) : rate_hz_(rate_hz), piece_(static_cast<std::size_t>(rate_hz)) {}
  static int take(const void* in, void*, unsigned long count, const PaStreamCallbackTimeInfo*,
                  PaStreamCallbackFlags, void* self) noexcept {
    if (in != nullptr) static_cast<Stream*>(self)->waiting_.push(static_cast<const float*>(in), count);
    return paContinue;
  }

  PaStream* stream_ = nullptr;
  int rate_hz_;
  std::vector<float> piece_;
  boost::lockfree::spsc_queue<float, boost::lockfree::capacity<std::size_t{1} << 18U>> waiting_;
};

/// PortAudio and a stream of it.
struct Opened {
  PortAudio audio;
  std::unique_ptr<Stream> stream;  // Ends before it.
};

/// Closes it; false where the sound system does not answer any more, as a JACK whose server was killed: then
/// it is left to itself.
bool close_patiently(std::unique_ptr<Opened> opened) {
  constexpr auto kPatience = std::chrono::seconds(2);
  const auto closed = std::make_shared<std::promise<void>>();
  std::future<void> done = closed->get_future();
  std::thread([closed, opened = std::move(opened)]() mutable {
    opened.reset();
    closed->set_value();
  }).detach();
  return done.wait_for(kPatience) == std::future_status::ready;
}

/// The microphone's thread.
class Listening {
 public:
  Listening(std::string name, std::uint64_t device, live::FeedPort& port)
      : name_(std::move(name)), device_(device), port_(port) {}

  void run() {
    while (!port_.stopped()) {
      if (!port_.wanted()) {
        std::this_thread::sleep_for(kLook);
        continue;
      }
      std::string why;
      auto opened = std::make_unique<Opened>();
      const bool unwanted = listen(*opened, why);
      if (!close_patiently(std::move(opened))) {
        port_.tell("microphone_lost",
                   name_ + ": the sound system does not answer any more; begin the session anew to hear");
        return;
      }
      if (unwanted) continue;
      if (told_ != why) port_.tell("microphone_lost", name_ + ": " + why + "; it is tried again each second");
      told_ = why;
      for (const auto again = Clock::now() + kRetry; !port_.stopped() && Clock::now() < again;)
        std::this_thread::sleep_for(kLook);
    }
  }

 private:
  /// Until nobody wants to hear; false where it was lost, with the reason.
  bool listen(Opened& sound, std::string& why) {
    if (!sound.audio.works()) {
      why = sound.audio.error();
      return false;
    }
    const auto device = find_input(name_);
    if (!device) {
      why = "there is no such microphone";
      return false;
    }
    sound.stream = Stream::open(*device, why);
    const Stream* const stream = sound.stream.get();
    if (stream == nullptr) return false;
    auto maker = speech::BlockMaker::create(stream->rate_hz());
    if (!maker) {
      why = maker.error().message();
      return false;
    }
    if (!told_.empty()) port_.tell("microphone_back", name_ + " is back");
    told_.clear();
    const auto opened = Clock::now();
    std::uint64_t samples = 0;
    quiet_since_ = opened;
    begun_blocks_ = false;
    auto newest = opened;
    double usual_s = 0;
    while (!port_.stopped() && port_.wanted()) {
      std::this_thread::sleep_for(kPoll);
      const std::span<const float> piece = sound.stream->read();
      const auto now = Clock::now();
      if (piece.empty()) {
        if (stream->is_active() && now - newest < kGone) continue;
        why = "it gives no sound any more";
        return false;
      }
      newest = now;
      watch_silence(piece);
      samples += piece.size();
      // A card's clock is not the machine's: what grows slowly is drift, what jumps was lost.
      const double behind_s = std::chrono::duration<double>(now - opened).count() -
                              static_cast<double>(samples) / stream->rate_hz();
      usual_s += std::chrono::duration<double>(kPoll) / kDrift * (behind_s - usual_s);
      if (behind_s - usual_s > kLost_s) {
        samples += static_cast<std::uint64_t>((behind_s - usual_s) * stream->rate_hz());
        next_block_ = std::max(next_block_, block_now());
      }
      maker->push(piece, [this](const speech::Block& block) { hand_over(block); });
    }
    return true;
  }

  void watch_silence(std::span<const float> piece) {
    const auto now = Clock::now();
    if (std::ranges::any_of(piece, [](float s) { return std::abs(s) > kSilence; })) {
      if (said_silent_) port_.tell("microphone_heard", name_ + " is heard");
      said_silent_ = false;
      quiet_since_ = now;
    } else if (!said_silent_ && now - quiet_since_ >= kSilent) {
      said_silent_ = true;
      port_.tell(
          "microphone_silent",
          name_ + " has been silent for 5 s: see that it is switched on, and that this program may hear it");
    }
  }

  /// By the machine's clock.
  [[nodiscard]] std::uint64_t block_now() const {
    return static_cast<std::uint64_t>((Clock::now() - begun_) / speech::kBlockDuration);
  }
  void hand_over(const speech::Block& block) {
    if (!begun_blocks_) next_block_ = std::max(next_block_, block_now());
    begun_blocks_ = true;
    if (const auto header = speech::encode_header({.device = device_, .block = next_block_}))
      port_.hand_over(*header, speech::payload_of(block));
    ++next_block_;
  }

  std::string name_;
  std::uint64_t device_;
  live::FeedPort& port_;
  Clock::time_point begun_ = Clock::now();
  Clock::time_point quiet_since_;
  std::uint64_t next_block_ = 0;
  bool begun_blocks_ = false;
  bool said_silent_ = false;
  std::string told_;  // Why it was lost, as it was said.
};

}  // namespace

Result<std::vector<std::string>> microphones() {
  const PortAudio audio;
  if (!audio.works())
    return fail(ErrorCode::io, audio.error(), "microphones", "see that a sound system is there");
  std::vector<std::string> names;
  for (const PaDeviceIndex i : inputs()) names.emplace_back(Pa_GetDeviceInfo(i)->name);
  return names;
}

Result<live::Feed> microphone_feed(const std::string& name, std::uint64_t device) {
  if (name != "default") {
    MIEN_TRY_ASSIGN(const std::vector<std::string> names, microphones());
    if (std::ranges::none_of(names,
                             [&](const std::string& one) { return one.find(name) != std::string::npos; }))
      return fail(ErrorCode::not_found, "this machine has no microphone of that name", "--audio " + name,
                  names.empty() ? "it has none at all; plug one in, or name a WAV file"
                                : fmt::format("it has {}; or name a WAV file", fmt::join(names, ", ")));
  }
  return live::Feed{"microphone:" + name,
                    [name, device](live::FeedPort& port) { Listening(name, device, port).run(); }};
}

}  // namespace mien::app
