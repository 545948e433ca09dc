#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "mien/core/error.h"
#include "mien/live/feeds.h"

namespace mien::live {

class Intake;
class PageServer;

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

/// A session's feeds, and which browser's microphone one of them hears: at most one, while the session wants
/// to hear. Network thread.
class Hearing {
 public:
  /// As Feeds::open. `shut`: there is no microphone, and there shall be none.
  [[nodiscard]] Result<void> open(std::vector<Feed> feeds, bool wanted, bool shut, Intake& intake);
  void begin(FeedPort::Tell tell) { feeds_.begin(std::move(tell)); }
  void end() { feeds_.end(); }

  /// What a client asks for by the command `microphone`: to be heard from now on instead of any other, who is
  /// told, or no more. Errors: unsupported (this session hears no browser), bad_usage (the voice is off).
  [[nodiscard]] Result<void> microphone(std::uint64_t client, bool on, PageServer& page);
  /// A binary message of a client.
  void take(std::uint64_t client, std::span<const std::byte> bytes);
  /// Ten times a second. `wanted`: whether the session is to hear; none: as before. A browser that is heard
  /// is told to stop where it is not, and forgotten where it is gone.
  void look(std::optional<bool> wanted, PageServer* page);
  [[nodiscard]] HearingState state() const;
  /// As Feeds::over.
  [[nodiscard]] std::vector<std::string> over() const { return feeds_.over(); }
  /// As Feeds::cameras.
  [[nodiscard]] std::vector<CameraStatus> cameras() const { return feeds_.cameras(); }

 private:
  /// `why`: empty, the voice was switched off.
  void release(PageServer& page, const std::string& why);

  Feeds feeds_;
  bool wanted_ = true;
  bool shut_ = false;
};

}  // namespace mien::live
