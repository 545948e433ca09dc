#include "mien/live/player.h"

#include <algorithm>
#include <atomic>
#include <map>

#include "mien/session/replay.h"
#include "mien/take/take.h"

namespace mien::live {
namespace {

/// Half an hour of frames takes 60 MB.
constexpr std::size_t kMaxFrames = 108'000;

}  // namespace

/// What the reader makes; everything but the flags belongs to it until `ready`.
struct Player::Job {
  std::filesystem::path path;
  std::vector<face::OutputFrame> frames;
  std::vector<std::optional<face::BlendshapeWeights>> truth;  // One a frame, or none at all.
  std::string error;
  std::atomic<bool> ready = false;
  std::atomic<bool> cancelled = false;

  Result<void> read(const MakeSession& make_session) {
    MIEN_TRY_ASSIGN(const take::Take take, take::Take::open(path));
    MIEN_TRY_ASSIGN(const std::vector<take::Tick> ticks, take.ticks());
    if (ticks.size() > kMaxFrames)
      return fail(ErrorCode::out_of_range, "the take is longer than half an hour", path.string(),
                  "solve it with mien solve, and look at that");
    if (cancelled) return {};
    MIEN_TRY_ASSIGN(const std::unique_ptr<session::Session> session, make_session(take.rig()));
    MIEN_TRY_ASSIGN(const std::vector<take::TruthFrame> known, take.truth());
    std::map<DeviceTime, const face::BlendshapeWeights*> by_time;
    for (const take::TruthFrame& one : known)
      if (one.has_face) by_time.emplace(one.time, &one.weights);
    MIEN_TRY(session::replay(take, *session, [&](const take::Tick& tick, const face::OutputFrame& frame) {
      frames.push_back(frame);
      if (!by_time.empty()) {
        const auto found = by_time.find(tick.frame);
        truth.push_back(found == by_time.end() ? std::nullopt : std::optional(*found->second));
      }
      return !cancelled.load();
    }));
    return {};
  }
};

Player::~Player() {
  stop();
  for (Reader& reader : readers_) reader.thread.join();
}

void Player::load(const std::filesystem::path& take) {
  stop();
  std::erase_if(readers_, [](Reader& reader) {
    if (!reader.job->ready) return false;
    reader.thread.join();
    return true;
  });
  job_ = std::make_shared<Job>();
  job_->path = take;
  paused_ = false;
  from_s_ = 0;
  since_.reset();
  shown_ = -1;
  readers_.push_back({job_, std::jthread([job = job_, make_session = make_session_] {
                        try {
                          if (const auto done = job->read(make_session); !done)
                            job->error = done.error().message();
                        } catch (const std::exception& error) {
                          job->error = error.what();
                        }
                        job->ready = true;
                      })});
}

void Player::stop() {
  if (job_) job_->cancelled = true;  // Its reader ends by itself: nobody waits for it.
  job_.reset();
}

double Player::position(HostTime now) const {
  if (!since_ || paused_) return from_s_;
  return from_s_ + to_seconds(now - *since_);
}

std::optional<Player::Moment> Player::next(HostTime now) {
  if (!job_ || !job_->ready || job_->frames.empty()) return std::nullopt;
  if (!since_) since_ = now;
  const auto count = static_cast<std::int64_t>(job_->frames.size());
  const auto at = static_cast<std::int64_t>(position(now) * kFrameRateHz);
  if (at >= count && !paused_) {  // Stands still at its end.
    from_s_ = static_cast<double>(count - 1) / kFrameRateHz;
    paused_ = true;
  }
  const std::int64_t shown = std::clamp<std::int64_t>(at, 0, count - 1);
  if (shown == shown_) return std::nullopt;
  shown_ = shown;
  const auto i = static_cast<std::size_t>(shown);
  Moment moment{shown, &job_->frames[i], nullptr};
  if (!job_->truth.empty() && job_->truth[i]) moment.truth = &*job_->truth[i];
  return moment;
}

void Player::pause(bool paused, HostTime now) {
  const double at = position(now);
  const double end = job_ && job_->ready ? static_cast<double>(job_->frames.size() - 1) / kFrameRateHz : at;
  from_s_ = !paused && at >= end ? 0 : at;  // From the end it plays again.
  since_ = now;
  paused_ = paused;
}

void Player::seek(double seconds, HostTime now) {
  from_s_ = std::clamp(seconds, 0.0, view(now).duration_s);
  since_ = now;
  shown_ = -1;  // Shown also while paused.
}

Player::View Player::view(HostTime now) const {
  View view;
  if (!job_) return view;
  view.take = job_->path.filename().string();
  view.paused = paused_;
  if (!job_->ready) return view;
  view.error = job_->error;
  view.has_truth = !job_->truth.empty();
  view.duration_s = static_cast<double>(job_->frames.size()) / kFrameRateHz;
  view.time_s = std::min(position(now), view.duration_s);
  return view;
}

}  // namespace mien::live
