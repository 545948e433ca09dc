#include "mien/virtual/perform_take.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <thread>

#include "mien/session/performed_prologue.h"
#include "mien/take/take.h"
#include "mien/virtual/session.h"

namespace mien::virt {
namespace {

/// Share of the work that setting the stage counts as.
constexpr double kBegun = 0.1;

std::string now_utc() {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(now));
}

/// Writes a session as it comes, stretch by stretch.
class SessionWriter {
 public:
  SessionWriter(const PerformRequest& request, take::TakeWriter& writer)
      : request_(request), writer_(writer), start_(std::chrono::steady_clock::now()) {}

  /// False when `written` says so, which hears of the share of this stretch; or when the writer failed.
  bool add(const Stretch& stretch, const std::function<bool(double share)>& written) {
    constexpr std::size_t kShownEvery = 512;
    const VirtualSession& session = stretch.session;
    motion_start_ = session.motion_start;
    for (const take::Event& event : session.events) writer_.add_event(event);
    if (!session.entries.empty())
      commands_ += session::begin_log(session.events, session.entries.front().arrival, writer_);
    next_tick_ = 0;
    std::size_t next_sample = 0;
    for (std::size_t e = 0; e < session.entries.size(); ++e) {
      const take::LogEntry& entry = session.entries[e];
      write_ticks(stretch, entry.id - 1);
      if (request_.real_time) std::this_thread::sleep_until(start_ + entry.arrival.time_since_epoch());
      sensor::Payload payload;
      const auto beside = session.payloads.find(entry.id);
      if (beside != session.payloads.end()) payload.bytes = beside->second;
      const std::int64_t id = writer_.add_entry(entry.arrival, entry.source, entry.bytes, payload);
      for (; next_sample < session.samples.size() && session.samples[next_sample].entry == entry.id;
           ++next_sample)
        writer_.add_sample(id, entry.arrival, session.samples[next_sample].sample);
      if (e % kShownEvery != kShownEvery - 1) continue;
      // The disk is full, say: finish() tells.
      if (!writer_.status()) return false;
      if (!written(static_cast<double>(e) / static_cast<double>(session.entries.size()))) return false;
    }
    write_ticks(stretch, std::numeric_limits<std::int64_t>::max());
    return writer_.status().has_value() && written(1);
  }
  /// What is left of the sound.
  void finish() { write_sound({}, true); }

 private:
  void write_ticks(const Stretch& stretch, std::int64_t known) {
    const std::vector<take::Tick>& ticks = stretch.session.ticks;
    for (; next_tick_ < ticks.size() && ticks[next_tick_].after_entry <= known; ++next_tick_) {
      take::Tick tick = ticks[next_tick_];
      tick.after_entry += commands_;
      writer_.add_tick(tick);
      writer_.add_truth(stretch.session.truth[next_tick_]);
      write_sound(tick.frame, false);
    }
  }
  /// Sound goes in as it is heard, in pieces of half a second and what is left at the end.
  void write_sound(DeviceTime reached, bool last) {
    if (!request_.sound) return;
    const Sound& sound = *request_.sound;
    const double at = std::max(0.0, to_seconds(reached - motion_start_)) * sound.rate_hz;
    const std::size_t end =
        last ? sound.samples.size() : std::min(sound.samples.size(), static_cast<std::size_t>(at));
    if (end <= sound_written_ || (!last && end - sound_written_ < sound.rate_hz / 2)) return;
    const double from_s = static_cast<double>(sound_written_) / sound.rate_hz;
    writer_.add_audio(static_cast<int>(sound.rate_hz), motion_start_ + from_seconds(from_s),
                      std::span(sound.samples).subspan(sound_written_, end - sound_written_));
    sound_written_ = end;
  }

  const PerformRequest& request_;
  take::TakeWriter& writer_;
  std::chrono::steady_clock::time_point start_;
  DeviceTime motion_start_;
  std::size_t next_tick_ = 0;  // Of the stretch.
  std::int64_t commands_ = 0;  // Entries before the devices'.
  std::size_t sound_written_ = 0;
};

}  // namespace

Result<void> check_take_is_new(const PerformRequest& request) {
  std::error_code code;
  if (!request.replace && std::filesystem::exists(request.take, code))
    return fail(ErrorCode::bad_usage, "the take exists already", request.take.string(),
                "give another name, or --force");
  return {};
}

Result<PerformSummary> perform_take(const PerformRequest& request, const Progress& progress) {
  std::error_code code;
  MIEN_TRY(check_take_is_new(request));
  if (request.take.has_parent_path() && !std::filesystem::is_directory(request.take.parent_path(), code))
    return fail(ErrorCode::not_found, "there is no such folder", request.take.parent_path().string(),
                "make it first");
  if (!progress(0, "reading")) return fail(ErrorCode::cancelled, "stopped", request.take.string());
  MIEN_TRY_ASSIGN(const Stage stage, set_stage(request, StageHolds::piece));
  if (!progress(kBegun, "performing")) return fail(ErrorCode::cancelled, "stopped", request.take.string());
  MIEN_TRY_ASSIGN(const std::unique_ptr<SessionStream> session, stream(stage));
  // Before the file is there: a recording begins when its take does.
  double shown = kBegun;
  const auto show = [&](double at, std::string_view what) { return progress(shown = at, what); };
  MIEN_TRY_ASSIGN(Stretch stretch, session->next([&](double share, std::string_view what) {
    return show(kBegun + 0.4 * share, what);
  }));
  if (!show(kBegun + 0.4 * stretch.share, "performing"))
    return fail(ErrorCode::cancelled, "stopped", request.take.string());

  take::Header header;
  header.software = request.software;
  header.performer = fmt::format("virtual:{}", request.seed);
  header.script = request.script_name;
  header.devices = request.devices;
  header.face = request.face;
  header.prologue = performer::kPrologueNames[static_cast<std::size_t>(request.prologue)];
  header.seed = request.seed;
  header.rig_toml = stage.rig_toml;
  header.created_utc = now_utc();
  MIEN_TRY_ASSIGN(
      take::TakeWriter writer,
      take::TakeWriter::create(request.take, header, request.replace,
                               request.real_time ? take::Appears::at_once : take::Appears::when_finished));

  PerformSummary summary{.duration_s = stage.duration_s};
  SessionWriter out(request, writer);
  bool stopped = false;
  for (bool whole = false; !whole && !stopped;) {
    whole = session->done();
    const double from = shown, to = kBegun + (1 - kBegun) * stretch.share;
    const bool all = out.add(stretch, [&](double share) {
      stopped = !show(from + (to - from) * share, "writing");
      return !stopped;
    });
    if (!all) break;
    summary.frames += stretch.session.ticks.size();
    summary.packets += stretch.session.entries.size();
    summary.samples += stretch.session.samples.size();
    if (whole) {
      out.finish();
    } else {
      MIEN_TRY_ASSIGN(stretch, session->next(no_progress));
    }
  }
  if (stopped && !request.real_time)
    return fail(ErrorCode::cancelled, "stopped", request.take.string(), "nothing was kept");
  MIEN_TRY(writer.finish());
  if (stopped)
    return fail(ErrorCode::cancelled, "stopped", request.take.string(),
                "what was performed until then is kept");
  progress(1, "written");
  return summary;
}

}  // namespace mien::virt
