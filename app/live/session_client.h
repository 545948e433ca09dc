#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "app/live/page_token.h"
#include "app/live/session_message.h"
#include "mien/core/error.h"

namespace mien::app {

/// A terminal's line to a running `mien live`: says what the page may say, and hears how the session is
/// (docs/reference/page_protocol.md). A call that waits for something from there blocks until it comes, or
/// until its patience is over; then the line is broken and later calls fail with the same words. Thread: one
/// at a time.
class SessionClient {
 public:
  /// How long it bears silence, and waits for an answer while other news comes: a busy machine answers late.
  struct Patience {
    std::chrono::milliseconds silence{5'000}, answer{30'000};
  };
  /// Connects and waits for the first status. `at` is HOST:PORT, or the page's address as `mien live` prints
  /// it, token and all; `token` goes before the one in `at`, and that before the environment's. `stop` ends
  /// the waiting. Errors: bad_usage (no such address or token, the wrong token), given_token()'s, io (no
  /// session there, or something else), cancelled.
  [[nodiscard]] static Result<std::unique_ptr<SessionClient>> open(const std::string& at,
                                                                   const TokenOption& token,
                                                                   const std::atomic<bool>& stop,
                                                                   Patience patience);
  [[nodiscard]] static Result<std::unique_ptr<SessionClient>> open(const std::string& at,
                                                                   const TokenOption& token,
                                                                   const std::atomic<bool>& stop) {
    return open(at, token, stop, Patience());
  }
  ~SessionClient();

  /// Sends {"command": NAME, ...} and waits for its reply. Errors: bad_usage (the session refused it: its
  /// words), io (the line is broken).
  [[nodiscard]] Result<void> command(nlohmann::json command);

  /// The newest.
  [[nodiscard]] const SessionStatus& status() const;
  /// Waits for the next one: a quarter of a second at most while all is well. What it says may be as much
  /// older than the reply that came before it. Errors: io.
  [[nodiscard]] Result<void> next_status();

  /// Hears what the session says until then. Who neither asks nor listens for seconds has everything of those
  /// seconds to read before the next answer. Errors: io.
  [[nodiscard]] Result<void> listen_until(std::chrono::steady_clock::time_point until);

  /// Events since the last call, the newest 64; then forgotten.
  [[nodiscard]] std::vector<SessionEvent> take_events();

 private:
  struct State;
  explicit SessionClient(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace mien::app
