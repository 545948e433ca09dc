#pragma once

#include <utility>  // Before Asio 1.74, which forgets it.

#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <future>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "mien/live/page_messages.h"
#include "mien/live/page_server.h"
#include "mien/session/receiver.h"
#include "tests/session/session_run.h"

namespace mien::app::test {

/// A performer who looks ahead for 2 s, does the short prologue, then talks for `seconds`: where a guided
/// calibration begins half a second in, they do what it asks.
inline std::vector<take::LogEntry> obedient(double seconds) {
  constexpr int kFrames = 120;
  performer::PrologueMotion motion = performer::with_prologue(
      virt::test::talking(static_cast<int>(60 * seconds)), performer::PrologueKind::brief, Random(3));
  const double shift_s = kFrames / kFrameRateHz;
  for (face::MotionFrame& frame : motion.motion.frames) frame.time_s += shift_s;
  std::vector<face::MotionFrame> ahead(kFrames, motion.motion.frames.front());
  for (int f = 0; f < kFrames; ++f) ahead[static_cast<std::size_t>(f)].time_s = f / kFrameRateHz;
  motion.motion.frames.insert(motion.motion.frames.begin(), ahead.begin(), ahead.end());
  virt::DeviceFaults faults = virt::test::mild_faults();
  faults.packet_loss = 0;
  return virt::play_devices(motion, virt::test::three_sites(), virt::test::three_sensors(), faults,
                            Random(11))
      .value()
      .entries;
}

/// A session behind the page's own server, on a time of its own: it stands at `start_s` until the first
/// command, then runs `speed` times as fast as the clock on the wall. What it hears was performed before.
class StagedSession {
 public:
  StagedSession(std::vector<take::LogEntry> entries, double start_s, double speed, std::string token = {})
      : entries_(std::move(entries)), speed_(speed), session_(session::test::session()), timer_(network_) {
    live::PageSettings settings;
    settings.port = 0;
    settings.token = std::move(token);
    page_ = live::PageServer::open(
                network_, settings,
                [this] {
                  return sink::hello_json(
                      live::hello_for(session_->rig(), "mien 0.0.0", "two shapes", {}, false));
                },
                [this](std::uint64_t client, std::string_view text) { execute(client, text); })
                .value();
    advance(HostTime(from_seconds(start_s)));
    beat();
    thread_ = std::thread([this] { network_.run(); });
  }
  ~StagedSession() {
    network_.stop();
    thread_.join();
  }
  StagedSession(const StagedSession&) = delete;
  StagedSession& operator=(const StagedSession&) = delete;

  /// As `mien live` prints it.
  [[nodiscard]] std::string page() const { return page_->address(); }
  /// HOST:PORT of it.
  [[nodiscard]] std::string at() const {
    const std::string address = page().substr(std::string("http://").size());
    return address.substr(0, address.find('/'));
  }
  /// How the session is at this moment.
  [[nodiscard]] session::Report report() {
    std::promise<session::Report> promise;
    boost::asio::post(network_, [&] { promise.set_value(report_now()); });
    return promise.get_future().get();
  }

 private:
  static constexpr auto kBeat = std::chrono::milliseconds(20);

  void execute(std::uint64_t client, std::string_view text) {
    going_ = true;
    const auto number = nlohmann::json::parse(text).at("id").get<std::int64_t>();
    const auto done = session_->command(now_, text);
    page_->send(client, live::reply_json(number, done ? std::string() : done.error().message()));
  }

  void beat() {
    timer_.expires_after(kBeat);
    timer_.async_wait([this](boost::system::error_code code) {
      if (code) return;
      if (going_) advance(now_ + from_seconds(speed_ * std::chrono::duration<double>(kBeat).count()));
      for (const take::Event& event : session_->take_events())
        if (const std::string text = live::event_text(event); !text.empty())
          page_->send(live::event_json(event.kind, text));
      live::Status status;
      status.report = report_now();
      page_->send(live::status_json(status, session_->rig()));
      beat();
    });
  }

  /// Feeds the session as the live loop does.
  void advance(HostTime until) {
    const auto fire = [this](HostTime now) {
      while (const auto tick = session_->due(now)) session_->tick(tick->frame, tick->fired);
    };
    const auto fire_deadlines = [&](HostTime before) {
      while (session_->deadline() && *session_->deadline() < before) fire(*session_->deadline());
    };
    for (; next_ < entries_.size() && entries_[next_].arrival < until; ++next_) {
      const take::LogEntry& entry = entries_[next_];
      fire_deadlines(entry.arrival);
      fire(entry.arrival);
      session_->receive(entry.arrival, peers_.of(entry.source), entry.bytes);
      fire(entry.arrival);
    }
    fire_deadlines(until);
    now_ = until;
  }

  [[nodiscard]] session::Report report_now() const {
    session::Report report;
    session_->report(now_, report);
    return report;
  }

  std::vector<take::LogEntry> entries_;
  double speed_;
  bool going_ = false;
  std::size_t next_ = 0;
  session::Peers peers_;
  HostTime now_;
  std::unique_ptr<session::Session> session_;
  boost::asio::io_context network_{1};
  boost::asio::steady_timer timer_;
  std::unique_ptr<live::PageServer> page_;
  std::thread thread_;
};

}  // namespace mien::app::test
