#include "app/live/perform_cameras.h"

#include <fmt/format.h>

#include <utility>
// Asio 1.74 needs <utility> before itself.
#include <algorithm>
#include <atomic>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "app/command.h"
#include "mien/core/host_port.h"
#include "mien/face/motion.h"
#include "mien/live/picture_server.h"
#include "mien/performer/encore.h"
#include "mien/virtual/headset/worn_headset.h"
#include "mien/virtual/node.h"

namespace mien::app {
namespace {

namespace asio = boost::asio;

/// What one core renders as it is performed.
constexpr int kLiveWidth = 96;
constexpr double kLiveHz = 30;
/// The longest motion that is rendered first, s, but for what a script's last movement takes beyond: with a
/// prologue and four cameras up to some 300 MB.
constexpr double kLongestAheadS = 60;
/// Pictures are made so far ahead, so that no hiccup of the machine makes one late.
constexpr double kMadeAheadS = 0.5;
constexpr Duration kLookAgain = std::chrono::milliseconds(10);
/// So much later boards look up, at most, when the performance begins.
constexpr Duration kBoardsLookUp = std::chrono::milliseconds(50);
constexpr std::string_view kScheme = "http://";

std::chrono::steady_clock::duration clock_duration(double seconds) {
  return std::chrono::duration_cast<std::chrono::steady_clock::duration>(from_seconds(seconds));
}

struct Address {
  std::string host;
  std::uint16_t port = 0;
};
Result<Address> parse_first_camera(const std::string& to, std::size_t cameras) {
  const auto parsed = parse_host_port(std::string_view(to).substr(kScheme.size()));
  if (!parsed || parsed->host.empty() || parsed->port.value_or(0) == 0)
    return fail(ErrorCode::bad_usage, "no address of cameras", to,
                "write http://HOST:PORT, with an address of this machine");
  if (*parsed->port + cameras - 1 > 65'535)
    return fail(ErrorCode::bad_usage, fmt::format("{} cameras have no ports from there on", cameras), to,
                "name a lower port");
  return Address{std::string(parsed->host), *parsed->port};
}

/// One moment's pictures.
struct RenderedShot {
  double begin_s = 0;  // True time, but for its jitter.
  std::vector<virt::BoardPicture> pictures;
};

/// The performance before the cameras, shot after shot: rendered when it is asked for, or all at first. Until
/// it begins the performer waits in its first pose, and the cameras are on: who watches them has a stream.
/// Times are true ones from when the cameras were switched on.
class RenderedFilm {
 public:
  RenderedFilm(const virt::Stage& stage, const virt::WornHeadset& headset, virt::HeadsetBoards boards,
               const std::optional<performer::Encore>& encore, bool beside_boards)
      : stage_(stage),
        headset_(headset),
        boards_(std::move(boards)),
        encore_(encore),
        beside_boards_(beside_boards),
        curve_(stage.motion.motion),
        end_s_(curve_.duration_s() + (encore ? 0 : virt::kDeviceMarginS)) {}

  /// False: stopped.
  Result<bool> render_all(const Progress& progress) {
    shots_.emplace();
    begin_s_ = 0;
    while (boards_.shot_s() < end_s_) {
      if (!progress(std::clamp(boards_.shot_s() / end_s_, 0.0, 0.999), "rendering")) return false;
      MIEN_TRY_ASSIGN(RenderedShot shot, shoot());
      shots_->push_back(std::move(shot));
    }
    begin_s_.reset();
    const auto first_from = [&](double time_s) {
      const auto first =
          std::ranges::find_if(*shots_, [&](const RenderedShot& s) { return s.begin_s >= time_s; });
      return static_cast<std::size_t>(first - shots_->begin());
    };
    waiting_ = std::max<std::size_t>(1, first_from(0));
    if (!encore_) return true;
    again_ = first_from(encore_->begin_s);
    // Boards repeat themselves to the microsecond: the round's last shot is left out where its first one
    // would follow at once.
    const double round_s = encore_->end_s - encore_->begin_s;
    while (beside_boards_ && again_ + 1 < shots_->size() &&
           (*shots_)[again_].begin_s + round_s - shots_->back().begin_s < 0.5 / boards_.rate_hz())
      shots_->pop_back();
    return true;
  }

  [[nodiscard]] DeviceTime time_of(const virt::BoardPicture& picture) const {
    return boards_.clock(picture.camera).device(picture.read_s);
  }
  /// The wait is over: the performance begins, not before `at_least_s`, which pictures rendered ahead keep by
  /// themselves. Returns when.
  double begin(double at_least_s) {
    begin_s_ = shots_ ? shift_s_ : std::max(at_least_s, boards_.shot_s());
    return *begin_s_;
  }
  /// How long the performance has been on; none before it begins.
  [[nodiscard]] std::optional<double> performed_s(double true_s) const {
    return begin_s_ && true_s >= *begin_s_ ? std::optional(true_s - *begin_s_) : std::nullopt;
  }
  /// Which playing of the motion is on then, and how far it is.
  [[nodiscard]] std::pair<std::size_t, double> round_at(double performed_s) const {
    const double once_s = curve_.duration_s();
    if (!encore_ || performed_s < once_s) return {1, std::clamp(performed_s / once_s, 0.0, 1.0)};
    const double rounds = (performed_s - encore_->begin_s) / (encore_->end_s - encore_->begin_s);
    return {static_cast<std::size_t>(rounds) + 1, rounds - std::floor(rounds)};
  }

  /// When the next shot is; none: it is over.
  [[nodiscard]] std::optional<double> next_s() const {
    if (shots_)
      return next_ < shots_->size() ? std::optional((*shots_)[next_].begin_s + shift_s_) : std::nullopt;
    const bool over = begin_s_ && !encore_ && boards_.shot_s() - *begin_s_ >= end_s_;
    return over ? std::nullopt : std::optional(boards_.shot_s());
  }
  Result<RenderedShot> next() {
    if (!shots_) return shoot();
    RenderedShot shot = (*shots_)[next_++];
    for (virt::BoardPicture& picture : shot.pictures) {
      picture.read_s += shift_s_;
      picture.arrival_s += shift_s_;
    }
    // Whole shots, so that their pace goes on where they come again.
    const auto whole_s = [this](std::size_t from) {
      return static_cast<double>(next_ - from) / boards_.rate_hz();
    };
    if (!begin_s_ && next_ == waiting_) come_again(0, whole_s(0));
    if (encore_ && next_ == shots_->size() && again_ < next_)
      come_again(again_, beside_boards_ ? encore_->end_s - encore_->begin_s : whole_s(again_));
    return shot;
  }
  /// Leaves out what is not rendered yet and should have been shot before this time.
  std::uint64_t skip_until(double true_s) {
    std::uint64_t skipped = 0;
    for (; !shots_ && next_s() && boards_.shot_s() < true_s; ++skipped) boards_.skip();
    return skipped;
  }

 private:
  Result<RenderedShot> shoot() {
    RenderedShot shot{.begin_s = boards_.shot_s()};
    MIEN_TRY(boards_.shoot(
        [this](double true_s) {
          return headset_.moment_at(stage_, {curve_, encore_},
                                    begin_s_ ? true_s - *begin_s_ : -virt::kDeviceMarginS);
        },
        shot.pictures));
    return shot;
  }
  void come_again(std::size_t from, double later_s) {
    shift_s_ += later_s;
    next_ = from;
  }

  const virt::Stage& stage_;
  const virt::WornHeadset& headset_;
  virt::HeadsetBoards boards_;
  const std::optional<performer::Encore>& encore_;
  bool beside_boards_;
  face::MotionCurve curve_;
  double end_s_;
  std::optional<double> begin_s_;                   // Of the performance.
  std::optional<std::vector<RenderedShot>> shots_;  // Where it was rendered ahead, by the performance's time.
  std::size_t next_ = 0;
  std::size_t waiting_ = 0, again_ = 0;  // So many at first show the wait; a round begins with this one.
  double shift_s_ = 0;
};

/// The cameras' servers and what is to be sent when, on a thread of their own: pictures leave in time while
/// the next ones are rendered.
class Cameras {
 public:
  using Clock = std::chrono::steady_clock;

  ~Cameras() {
    if (!thread_.joinable()) return;
    asio::post(io_, [this] {
      for (auto& server : servers_) server->close();
      work_.reset();
      io_.stop();
    });
  }
  Result<void> open(const Address& address, std::size_t cameras, double rate_hz) {
    for (std::size_t c = 0; c < cameras; ++c) {
      MIEN_TRY_ASSIGN(auto server,
                      live::PictureServer::open(io_, {.host = address.host,
                                                      .port = static_cast<std::uint16_t>(address.port + c),
                                                      .rate_hz = rate_hz}));
      servers_.push_back(std::move(server));
    }
    thread_ = std::jthread([this] { io_.run(); });
    return {};
  }
  void add(Clock::time_point due, std::size_t camera, DeviceTime time, std::vector<std::byte> jpeg) {
    ++left_;
    asio::post(io_, [this, due, waiting = Waiting{camera, time, std::move(jpeg)}]() mutable {
      waiting_.emplace(due, std::move(waiting));
      send_due();
    });
  }
  /// Pictures that wait for their time.
  [[nodiscard]] std::size_t left() const { return left_; }
  [[nodiscard]] double latest_ms() const { return latest_ms_; }
  /// Cameras whose pictures somebody has asked for.
  [[nodiscard]] std::size_t watched() const {
    return static_cast<std::size_t>(
        std::ranges::count_if(servers_, [](const auto& server) { return server->counts().clients > 0; }));
  }
  [[nodiscard]] live::PictureServer::Counts counts() const {
    live::PictureServer::Counts all;
    for (const auto& server : servers_) {
      const auto one = server->counts();
      all.clients += one.clients;
      all.pictures += one.pictures;
      all.dropped += one.dropped;
    }
    return all;
  }

 private:
  struct Waiting {
    std::size_t camera = 0;
    DeviceTime time;
    std::vector<std::byte> jpeg;
  };
  void send_due() {
    const auto now = Clock::now();
    while (!waiting_.empty() && waiting_.begin()->first <= now) {
      const auto& [due, picture] = *waiting_.begin();
      servers_[picture.camera]->send(picture.time, picture.jpeg);
      latest_ms_ =
          std::max(latest_ms_.load(), std::chrono::duration<double, std::milli>(Clock::now() - due).count());
      waiting_.erase(waiting_.begin());
      --left_;
    }
    if (waiting_.empty()) return;
    timer_.expires_at(waiting_.begin()->first);
    timer_.async_wait([this](const boost::system::error_code& code) {
      if (!code) send_due();
    });
  }

  asio::io_context io_;
  std::optional<asio::executor_work_guard<asio::io_context::executor_type>> work_{io_.get_executor()};
  asio::steady_timer timer_{io_};
  std::vector<std::unique_ptr<live::PictureServer>> servers_;
  std::multimap<Clock::time_point, Waiting> waiting_;
  std::atomic<std::size_t> left_ = 0;
  std::atomic<double> latest_ms_ = 0;  // Written by one thread.
  std::jthread thread_;                // Last: it ends first.
};

}  // namespace

bool is_camera_address(std::string_view to) {
  return to.starts_with(kScheme);
}

Result<CameraSummary> perform_to_cameras(const virt::StageRequest& request, const CameraOptions& options) {
  MIEN_TRY(parse_first_camera(options.to, 1));
  MIEN_TRY_ASSIGN(virt::Stage stage, virt::set_stage(request));
  const virt::WornHeadset* headset = virt::headset_of(stage);
  if (headset != nullptr && options.start == nullptr && has_senders(stage.rig))
    return fail(ErrorCode::bad_usage,
                "the rig has boards or a phone beside its cameras, for which nobody sends",
                request.rig.string(), "send, too: --to udp://HOST:PORT --cameras " + options.to);
  if (headset == nullptr)
    return fail(ErrorCode::bad_usage, "only cameras are asked for pictures, and the rig is of other sensors",
                request.rig.string(), "use rigs/headset.toml, or send to udp://HOST:PORT");
  const double motion_s = stage.motion.motion.duration_s() - stage.motion.times.motion_start_s;
  if (options.ahead && !(motion_s < kLongestAheadS + 1))
    return fail(ErrorCode::bad_usage,
                fmt::format("{:.0f} s are too long to be rendered ahead, which is into memory", motion_s),
                request.script_name,
                fmt::format("perform at most {:.0f} s (--seconds), or leave out --ahead", kLongestAheadS));
  const std::optional<performer::Encore> encore =
      options.loop ? std::optional(performer::add_encore(stage.motion)) : std::nullopt;
  MIEN_TRY_ASSIGN(virt::HeadsetBoards boards,
                  options.ahead ? headset->boards(stage) : headset->boards(stage, kLiveWidth, kLiveHz));
  CameraSummary summary;
  summary.cameras = boards.cameras();
  const double rate_hz = boards.rate_hz();
  MIEN_TRY_ASSIGN(const Address address, parse_first_camera(options.to, summary.cameras));
  Cameras cameras;
  MIEN_TRY(cameras.open(address, summary.cameras, rate_hz));

  RenderedFilm film(stage, *headset, std::move(boards), encore, options.start != nullptr);
  if (options.ahead) {
    const Progress shown = terminal_progress("perform");
    MIEN_TRY_ASSIGN(const bool rendered, film.render_all([&](double share, std::string_view what) {
      return shown(share, what) && !(options.start != nullptr && options.start->stopped);
    }));
    summary.stopped = !rendered;
  }
  if (options.start != nullptr) options.start->cameras_on = true;
  if (options.wait_s > 0 && !summary.stopped) {
    clear_progress();
    fmt::print(stderr, "mien: {}: waiting {:.0f} s until all {} cameras are asked for (--wait)\n", options.to,
               options.wait_s, summary.cameras);
  }
  Progress progress = terminal_progress("perform");
  const auto on = Cameras::Clock::now() + clock_duration(virt::kDeviceMarginS + kMadeAheadS);
  bool begun = false;
  while (!summary.stopped && (film.next_s() || cameras.left() > 0)) {
    const double now_s = std::chrono::duration<double>(Cameras::Clock::now() - on).count();
    if (!begun) summary.watched = cameras.watched();
    const bool others_ready = options.start == nullptr || options.start->boards_ready;
    if (!begun && others_ready && (summary.watched == summary.cameras || now_s >= options.wait_s)) {
      const double begin_s = film.begin(now_s + virt::kDeviceMarginS + to_seconds(kBoardsLookUp));
      if (options.start != nullptr) options.start->begin = on + clock_duration(begin_s);
      begun = true;
    }
    if (const auto performed_s = film.performed_s(now_s)) {
      summary.performed_s = *performed_s;
      const auto [round, share] = film.round_at(*performed_s);
      if (round > summary.rounds && round > 1)
        progress = terminal_progress(fmt::format("perform, round {}", round));
      summary.rounds = round;
      summary.stopped = !progress(std::min(0.999, share), fmt::format("{} of {} cameras asked for",
                                                                      cameras.watched(), summary.cameras));
    } else {
      summary.stopped = !progress(0, "waiting");
    }
    if (options.start != nullptr && options.start->stopped) summary.stopped = true;
    const std::uint64_t skipped = film.skip_until(now_s);
    if (begun) summary.skipped += skipped;
    const auto next_s = film.next_s();
    if (!next_s || *next_s > now_s + kMadeAheadS) {
      std::this_thread::sleep_for(kLookAgain);
      continue;
    }
    MIEN_TRY_ASSIGN(RenderedShot shot, film.next());
    for (virt::BoardPicture& picture : shot.pictures) {
      const DeviceTime time = film.time_of(picture);
      cameras.add(on + clock_duration(picture.arrival_s), picture.camera, time, std::move(picture.jpeg));
    }
  }
  if (!summary.stopped) progress(1, "performed");
  const live::PictureServer::Counts counts = cameras.counts();
  summary.pictures = counts.pictures;
  summary.dropped = counts.dropped;
  summary.latest_ms = cameras.latest_ms();
  return summary;
}

}  // namespace mien::app
