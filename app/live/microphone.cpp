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

#include "app/live/heard_sound.h"

namespace mien::app {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kRetry = std::chrono::seconds(1);
constexpr auto kLook = std::chrono::milliseconds(50);
constexpr auto kPoll = std::chrono::milliseconds(3);
/// Without a sample for so long a microphone was pulled out.
constexpr auto kGone = std::chrono::seconds(1);
/// A stream that falls so far behind has lost sound.
constexpr double kLost_s = 0.2;

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
      : asked_(std::move(name)),
        name_(asked_ == "default" ? "the default microphone" : asked_),
        port_(port),
        heard_(name_, device, port, Clock::now()) {}

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
        const std::string gone =
            name_ + ": the sound system does not answer any more; begin the session anew to hear";
        port_.tell("microphone_lost", gone);
        heard_.trouble(gone);
        return;
      }
      if (unwanted) {
        heard_.over();
        continue;
      }
      const std::string lost = name_ + ": " + why + "; it is tried again each second";
      if (told_ != why) port_.tell("microphone_lost", lost);
      heard_.trouble(lost);
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
    const auto device = find_input(asked_);
    if (!device) {
      why = "there is no such microphone";
      return false;
    }
    sound.stream = Stream::open(*device, why);
    const Stream* const stream = sound.stream.get();
    if (stream == nullptr) return false;
    const auto opened = Clock::now();
    if (const auto begun = heard_.begin(stream->rate_hz(), opened); !begun) {
      why = begun.error().message();
      return false;
    }
    if (!told_.empty()) port_.tell("microphone_back", name_ + " is back");
    told_.clear();
    heard_.trouble({});
    Lateness lateness(opened);
    double heard_s = 0;
    auto newest = opened;
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
      heard_s += static_cast<double>(piece.size()) / stream->rate_hz();
      if (const double lost_s = lateness.at(heard_s, now); lost_s > kLost_s) {
        heard_s += lost_s;
        heard_.catch_up(now);
      }
      lateness.follow(heard_s, now);
      heard_.push(piece, now);
    }
    return true;
  }

  std::string asked_;  // As find_input() takes it.
  std::string name_;   // As it is told.
  live::FeedPort& port_;
  HeardSound heard_;
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
