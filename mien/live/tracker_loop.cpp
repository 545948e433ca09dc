#include "mien/live/tracker_loop.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "mien/live/page_messages.h"
#include "mien/live/unheard.h"

namespace mien::live {
namespace {

/// A second of frames.
constexpr std::size_t kAnswers = 64;
constexpr std::size_t kOutboxBytes = std::size_t{1} << 18U;
/// How often devices are greeted, and a report is made each second time.
constexpr Duration kLook = std::chrono::milliseconds(100);

struct MessageHead {
  OutgoingMessage::Kind kind;
  std::uint64_t to;
  std::int64_t number;
};

std::span<const std::byte> bytes_of(std::string_view text) {
  return std::as_bytes(std::span(text));
}

}  // namespace

TrackerLoop::TrackerLoop(session::Session& session, Intake& intake, Recorder& recorder, Clock clock)
    : session_(session),
      intake_(intake),
      recorder_(recorder),
      clock_(std::move(clock)),
      answers_(kAnswers),
      said_(kOutboxBytes) {}

TrackerLoop::~TrackerLoop() {
  stop();
}

Result<void> TrackerLoop::execute(std::string_view json_text) {
  recorder_.command(newest_, json_text);
  return session_.command(newest_, json_text);
}

void TrackerLoop::start() {
  thread_ = std::thread([this] { run(); });
}

void TrackerLoop::stop() {
  stopping_ = true;
  intake_.signal().give();
  if (thread_.joinable()) thread_.join();
}

void TrackerLoop::run() {
  while (!stopping_) {
    while (!stopping_) {
      const auto arrived = intake_.front();
      if (!arrived) break;
      // The order here is the log's: nothing arrives before what was known when the last tick fired.
      newest_ = std::max(newest_, arrived->arrival);
      fire(newest_, newest_);
      Arrived inside = *arrived;
      inside.arrival = newest_;
      take(inside);
      fire(newest_, arrived->arrival);
      intake_.release();
      look_around(newest_);
    }
    newest_ = std::max(newest_, clock_());
    fire(newest_, newest_);
    look_around(newest_);
    const HostTime deadline = std::min(session_.deadline().value_or(next_look_), next_look_);
    intake_.signal().wait(deadline - clock_());
  }
}

void TrackerLoop::fire(HostTime now, HostTime cause) {
  while (const auto tick = session_.due(now)) {
    const face::OutputFrame& frame = session_.tick(tick->frame, tick->fired);
    recorder_.tick(*tick);
    if (answers_.push(Answer{*tick, tick->complete ? cause : tick->fired, frame}))
      out_.give();
    else
      ++missed_;
    hand_over_news(now);
  }
}

void TrackerLoop::take(const Arrived& arrived) {
  if (arrived.kind == Arrived::Kind::command) {
    const std::string_view json_text(reinterpret_cast<const char*>(arrived.bytes.data()),
                                     arrived.bytes.size());
    // A command that fails changes nothing: it is logged all the same, and fails again in a replay.
    recorder_.command(arrived.arrival, json_text);
    const auto done = session_.command(arrived.arrival, json_text);
    renew_report(arrived.arrival);
    const std::string error = done ? std::string() : done.error().message();
    post({OutgoingMessage::Kind::reply, arrived.client, arrived.number, bytes_of(error)});
    hand_over_news(arrived.arrival);
    return;
  }
  const session::Session::Received received =
      session_.receive(arrived.arrival, {arrived.peer, arrived.source}, arrived.bytes, arrived.payload);
  if (!received.log.empty() &&
      (received.verdict == sensor::Verdict::taken || received.verdict == sensor::Verdict::ignored)) {
    if (!received.samples.empty()) intake_.judge_bound();
    recorder_.entry(arrived.arrival, arrived.source, received.log, received.samples, received.payload);
  }
  if (!received.reply.empty()) post({OutgoingMessage::Kind::datagram, arrived.peer, 0, received.reply});
}

void TrackerLoop::post(const OutgoingMessage& said) {
  // No room: the network's thread stands still, and nobody would hear it.
  if (said_.put(MessageHead{said.kind, said.to, said.number}, said.bytes)) out_.give();
}

std::optional<OutgoingMessage> TrackerLoop::front_said() {
  const auto record = said_.front_of<MessageHead>();
  if (!record) return std::nullopt;
  return OutgoingMessage{record->first.kind, record->first.to, record->first.number, record->second};
}

void TrackerLoop::post_event(std::string_view kind, std::string_view text) {
  const std::string both = fmt::format("{} {}", kind, text);
  post({OutgoingMessage::Kind::event, 0, 0, bytes_of(both)});
}

void TrackerLoop::hand_over_news(HostTime now) {
  const std::vector<take::Event> events = session_.take_events();
  for (const take::Event& event : events) {
    recorder_.event(event);
    if (LinkNews::is_about_a_link(event)) continue;
    if (const std::string words = event_text(event); !words.empty()) post_event(event.kind, words);
  }
  for (const Sentence& news : link_news_.tell(now, events)) post_event(news.kind, news.text);
  const auto& versions = session_.versions();
  for (; versions_ < static_cast<std::int64_t>(versions.size()); ++versions_) {
    const session::CalibrationVersion& version = versions[static_cast<std::size_t>(versions_)];
    if (!version.json.empty())
      recorder_.calibration(version.id, version.made, session_.modality(), version.json);
  }
}

void TrackerLoop::look_around(HostTime now) {
  if (now < next_look_) return;
  next_look_ = now + kLook;
  outgoing_.clear();
  session_.heartbeats(now, outgoing_);
  for (const sensor::Protocol::Outgoing& said : outgoing_)
    post({OutgoingMessage::Kind::datagram, said.peer, 0, said.datagram});
  if (++looks_ % 2 == 0) return;
  for (const Sentence& news : link_news_.tell(now, {})) post_event(news.kind, news.text);
  session_.report(now, draft_);
  tell_of_hold();
  tell_of_versions();
  // A reader that holds it gets the next one.
  if (const std::unique_lock lock(report_mutex_, std::try_to_lock); lock) std::swap(draft_, report_);
}

void TrackerLoop::renew_report(HostTime now) {
  session_.report(now, draft_);
  // Held for the time of a copy.
  const std::lock_guard lock(report_mutex_);
  std::swap(draft_, report_);
}

void TrackerLoop::tell_of_hold() {
  const bool held = draft_.hold > Duration::zero();
  if (held == told_held_) return;
  told_held_ = held;
  if (held)
    post_event("frames_held",
               fmt::format("holding frames {:.0f} ms: packets arrive late", 1e3 * to_seconds(draft_.hold)));
  else
    post_event("frames_punctual", "packets arrive in time again: frames are not held any more");
}

void TrackerLoop::tell_of_versions() {
  for (; unknown_versions_ < draft_.unknown_versions.size(); ++unknown_versions_)
    post_event("version_error", unknown_version_text(draft_.unknown_versions[unknown_versions_]));
}

session::Report TrackerLoop::report() const {
  const std::lock_guard lock(report_mutex_);
  return report_;
}

}  // namespace mien::live
