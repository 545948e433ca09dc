#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "mien/core/error.h"
#include "mien/live/camera_status.h"
#include "mien/live/page_inlet.h"
#include "mien/live/payload_source.h"
#include "mien/live/picture_tap.h"

namespace mien::live {

class Intake;

/// What a feed's thread says of itself to who looks on. Any thread.
class FeedState {
 public:
  void set_trouble(std::string text) {
    const std::scoped_lock lock(mutex_);
    trouble_ = std::move(text);
  }
  /// What stands against hearing by it now, in one line; empty: nothing.
  [[nodiscard]] std::string trouble() const {
    const std::scoped_lock lock(mutex_);
    return trouble_;
  }
  void set_camera(CameraStatus camera) {
    const std::scoped_lock lock(mutex_);
    camera_ = std::move(camera);
  }
  /// How the camera is that it follows; none: it follows none.
  [[nodiscard]] std::optional<CameraStatus> camera() const {
    const std::scoped_lock lock(mutex_);
    return camera_;
  }
  void set_awaited(std::string host) {
    const std::scoped_lock lock(mutex_);
    awaited_ = std::move(host);
    answered_ = false;
  }
  /// Who is awaited; empty: nobody.
  [[nodiscard]] std::string awaited() const {
    const std::scoped_lock lock(mutex_);
    return awaited_;
  }
  void set_over() { over_ = true; }
  /// It gave all that it had.
  [[nodiscard]] bool over() const { return over_; }
  void set_answered(bool answered) { answered_ = answered; }
  [[nodiscard]] bool answered() const { return answered_; }

 private:
  mutable std::mutex mutex_;
  std::string trouble_;
  std::optional<CameraStatus> camera_;
  std::string awaited_;
  std::atomic<bool> answered_ = false;
  std::atomic<bool> over_ = false;
};

/// What a feed's thread sees of its session.
class FeedPort {
 public:
  using Tell = std::function<void(std::string kind, std::string text)>;
  FeedPort(PayloadSource& source, const std::atomic<bool>& stop, const std::atomic<bool>& wanted,
           const Tell& tell, FeedState& state)
      : source_(source), stop_(stop), wanted_(wanted), tell_(tell), state_(state) {}

  /// As PayloadSource::hand_over.
  bool hand_over(std::span<const std::byte> datagram, std::span<const std::byte> payload) {
    return source_.hand_over(datagram, payload);
  }
  /// The session is over: to be looked at ten times a second or more often.
  [[nodiscard]] bool stopped() const { return stop_; }
  /// False while the session is not to hear: then a microphone is closed.
  [[nodiscard]] bool wanted() const { return wanted_; }
  /// Says something to whoever looks on, as an event of this kind.
  void tell(std::string kind, std::string text) const { tell_(std::move(kind), std::move(text)); }
  /// What stands against hearing now, for as long as it does; empty: nothing does any more.
  void trouble(std::string text) { state_.set_trouble(std::move(text)); }
  /// Whose answers come in by the session's own ports from now on: an address, "192.168.1.7".
  void await(std::string host) { state_.set_awaited(std::move(host)); }
  /// Whether anything came from there within the last second, as of a tenth of a second ago at the latest.
  [[nodiscard]] bool answered() const { return state_.answered(); }
  /// How the camera is that it follows.
  void show(CameraStatus camera) { state_.set_camera(std::move(camera)); }

 private:
  PayloadSource& source_;
  const std::atomic<bool>& stop_;
  const std::atomic<bool>& wanted_;
  const Tell& tell_;
  FeedState& state_;
};

/// A device inside this program: a microphone, a camera, or a file that is played.
struct Feed {
  std::string name;  ///< Its source in the log: "sound:talk.wav".
  /// Hands over what it has, on a thread of its own from the session's beginning on, until that is over or it
  /// has no more. Where it returns or throws before that the session says so and goes on.
  std::function<void(FeedPort& port)> run;
  /// Where what it has comes from a browser: there the page's messages are left for it.
  std::shared_ptr<PageInlet> inlet = nullptr;
  bool heard = true;  ///< What it has is sound.
  /// Where what a camera sees can be looked at.
  std::shared_ptr<PictureTap> tap = nullptr;
  /// The rig's sensor that it is, where it may have no more: then that is told, and not that the sensor is
  /// lost. Empty: none.
  std::string sensor = {};
};

/// A session's feeds, each with its source and its thread.
class Feeds {
 public:
  /// Before the tracker's thread begins. Errors: Intake::add_source's.
  [[nodiscard]] Result<void> open(std::vector<Feed> feeds, bool wanted, Intake& intake);
  /// Starts every feed. `tell`: of one that is over or failed, and what they say, on their threads.
  void begin(FeedPort::Tell tell);
  /// Whether the session is to hear.
  void want(bool wanted) { wanted_ = wanted; }
  /// Sees who answers those feeds that await it. Ten times a second.
  void look_for_answers();
  /// The first trouble that a feed has; empty: none has any.
  [[nodiscard]] std::string trouble() const;
  /// Those that feeds follow, in their order.
  [[nodiscard]] std::vector<CameraStatus> cameras() const;
  /// What those that are heard handed over and the session took.
  [[nodiscard]] std::uint64_t handed_over() const;
  /// The rig's sensors whose feeds have no more.
  [[nodiscard]] std::vector<std::string> over() const;
  /// Of the feed that hears a browser; null: none does.
  [[nodiscard]] PageInlet* inlet() const;
  /// Asks them to stop, and waits for it.
  void end();
  ~Feeds() { end(); }
  Feeds() = default;
  Feeds(const Feeds&) = delete;
  Feeds& operator=(const Feeds&) = delete;

 private:
  std::vector<Feed> feeds_;
  const Intake* intake_ = nullptr;       // By which answers come.
  std::vector<PayloadSource*> sources_;  // One a feed, ...
  std::deque<FeedState> states_;         // ... and so are these.
  std::atomic<bool> stop_ = false;
  std::atomic<bool> wanted_ = true;
  FeedPort::Tell tell_;
  std::vector<std::jthread> threads_;
};

}  // namespace mien::live
