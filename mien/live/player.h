#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/time.h"
#include "mien/face/output_frame.h"
#include "mien/session/session.h"

namespace mien::live {

/// A take for the page to look at: replayed once, on a thread of its own, then played, held and wound at
/// will. Truth beside it where the take has one. All calls from one thread.
class Player {
 public:
  using MakeSession = std::function<Result<std::unique_ptr<session::Session>>(const sensor::Rig&)>;
  explicit Player(MakeSession make_session) : make_session_(std::move(make_session)) {}
  ~Player();

  /// Begins to replay; what was there before is gone. Longer takes than half an hour are refused once known.
  void load(const std::filesystem::path& take);
  void stop();
  [[nodiscard]] bool on() const { return job_ != nullptr; }

  struct Moment {
    std::int64_t index = 0;
    const face::OutputFrame* frame = nullptr;
    const face::BlendshapeWeights* truth = nullptr;
  };
  /// The frame to show now, if it is another than the last that was given; none while it is being read.
  [[nodiscard]] std::optional<Moment> next(HostTime now);
  void pause(bool paused, HostTime now);
  void seek(double seconds, HostTime now);

  struct View {
    std::string take;
    double time_s = 0;
    double duration_s = 0;
    bool paused = false;
    bool has_truth = false;
    std::string error;  ///< Why it cannot be shown; empty when it can.
  };
  [[nodiscard]] View view(HostTime now) const;

 private:
  struct Job;
  [[nodiscard]] double position(HostTime now) const;

  MakeSession make_session_;
  std::shared_ptr<Job> job_;
  struct Reader {
    std::shared_ptr<Job> job;
    std::jthread thread;
  };
  std::vector<Reader> readers_;  // The newest, and those that have not ended yet.
  bool paused_ = false;
  double from_s_ = 0;  // Position at `since_`.
  std::optional<HostTime> since_;
  std::int64_t shown_ = -1;
};

}  // namespace mien::live
