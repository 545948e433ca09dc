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
#include "mien/live/camera_pictures.h"
#include "mien/live/page_inlet.h"
#include "mien/live/payload_source.h"
#include "mien/live/picture_tap.h"

namespace mien::live {

class Intake;
class PageServer;

/// What a feed's thread sees of its session, and what it says of itself to who looks on.
class FeedPort {
 public:
  using Tell = std::function<void(std::string kind, std::string text)>;
  FeedPort(PayloadSource& source, const std::atomic<bool>& stop, const std::atomic<bool>& wanted,
           const Tell& tell)
      : source_(source), stop_(stop), wanted_(wanted), tell_(tell) {}

  // Feed's thread.
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
  void trouble(std::string text) {
    const std::scoped_lock lock(mutex_);
    state_.trouble = std::move(text);
  }
  /// Whose answers come in by the session's own ports from now on: an address, "192.168.1.7".
  void await(std::string host) {
    const std::scoped_lock lock(mutex_);
    state_.awaited = std::move(host);
    answered_ = false;
  }
  /// Whether anything came from there within the last second, as of a tenth of a second ago at the latest.
  [[nodiscard]] bool answered() const { return answered_; }
  /// How the camera is that it follows.
  void show(CameraStatus camera) {
    const std::scoped_lock lock(mutex_);
    state_.camera = std::move(camera);
  }

  // Any thread.
  struct State {
    std::string trouble;                 ///< What stands against hearing by it now; empty: nothing.
    std::optional<CameraStatus> camera;  ///< The one that it follows.
    std::string awaited;                 ///< Who is awaited; empty: nobody.
  };
  [[nodiscard]] State state() const {
    const std::scoped_lock lock(mutex_);
    return state_;
  }
  void set_answered(bool answered) { answered_ = answered; }
  /// Datagrams that it handed over and the session took.
  [[nodiscard]] std::uint64_t handed_over() const;

 private:
  PayloadSource& source_;
  const std::atomic<bool>& stop_;
  const std::atomic<bool>& wanted_;
  const Tell& tell_;
  mutable std::mutex mutex_;
  State state_;
  std::atomic<bool> answered_ = false;
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

/// What the page is told of a session's feeds.
struct HearingState {
  bool shut = false;              ///< The session was begun with every microphone shut.
  std::string trouble;            ///< What stands against hearing now; empty: nothing.
  std::uint64_t handed_over = 0;  ///< Blocks of sound that the session took.
  /// There where a browser's microphone may be heard.
  struct Browser {
    bool heard = false;         ///< One was let in.
    std::uint64_t refused = 0;  ///< Its messages that were not heard, and those of others.
  };
  std::optional<Browser> browser;
};

/// A session's feeds, each with its source and its thread, and which browser's microphone one of them hears:
/// at most one, while the session wants to hear. Network thread.
class Feeds {
 public:
  /// Before the tracker's thread begins. `shut`: there is no microphone, and there shall be none. Errors:
  /// Intake::add_source's.
  [[nodiscard]] Result<void> open(std::vector<Feed> feeds, bool wanted, bool shut, Intake& intake);
  /// Starts every feed. `tell`: of one that is over or failed, and what they say, on their threads.
  void begin(FeedPort::Tell tell);
  /// Asks them to stop, and waits for it.
  void end();
  ~Feeds() { end(); }
  Feeds() = default;
  Feeds(const Feeds&) = delete;
  Feeds& operator=(const Feeds&) = delete;

  /// What a client asks for by the command `microphone`: to be heard from now on instead of any other, who is
  /// told, or no more. Errors: unsupported (this session hears no browser), bad_usage (the voice is off).
  [[nodiscard]] Result<void> microphone(std::uint64_t client, bool on, PageServer& page);
  /// A binary message of a client.
  void take(std::uint64_t client, std::span<const std::byte> bytes);
  /// Ten times a second. `wanted`: whether the session is to hear; none: as before. A browser that is heard
  /// is told to stop where it is not, and forgotten where it is gone; feeds that await somebody learn who
  /// answers.
  void look(std::optional<bool> wanted, PageServer* page);
  [[nodiscard]] HearingState state() const;
  /// The rig's sensors whose feeds have no more.
  [[nodiscard]] std::vector<std::string> over() const;
  /// Those that feeds follow, in their order.
  [[nodiscard]] std::vector<CameraStatus> cameras() const;

 private:
  /// A feed, and what its thread has of the session.
  struct Running {
    Running(Feed its, PayloadSource& source, const Feeds& all)
        : feed(std::move(its)), port(source, all.stop_, all.wanted_, all.tell_) {}
    Feed feed;
    FeedPort port;
    std::atomic<bool> over = false;  // It gave all that it had.
  };
  void run(Running& one);
  /// Of the feed that hears a browser; null: none does.
  [[nodiscard]] PageInlet* inlet() const;
  /// `why`: empty, the voice was switched off.
  void release(PageServer& page, const std::string& why);

  const Intake* intake_ = nullptr;  // By which answers come.
  bool shut_ = false;
  std::atomic<bool> stop_ = false;
  std::atomic<bool> wanted_ = true;
  FeedPort::Tell tell_;
  std::deque<Running> running_;
  std::vector<std::jthread> threads_;
};

}  // namespace mien::live
