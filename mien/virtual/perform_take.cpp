#include "mien/virtual/perform_take.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <chrono>
#include <ctime>
#include <span>
#include <thread>

#include "mien/take/take.h"
#include "mien/virtual/session.h"

namespace mien::virt {
namespace {

std::string_view prologue_name(performer::PrologueKind kind) {
  switch (kind) {
    case performer::PrologueKind::none:
      return "none";
    case performer::PrologueKind::brief:
      return "short";
    case performer::PrologueKind::full:
      return "full";
    case performer::PrologueKind::guided:
      return "guided";
    case performer::PrologueKind::gaze:
      return "gaze";
  }
  return "none";
}

std::string now_utc() {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(now));
}

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
  MIEN_TRY_ASSIGN(const Stage stage, set_stage(request));
  if (!progress(0.1, "performing")) return fail(ErrorCode::cancelled, "stopped", request.take.string());
  MIEN_TRY_ASSIGN(const VirtualSession session, play(stage, [&](double share, std::string_view what) {
                    return progress(0.1 + 0.4 * share, what);
                  }));
  if (!progress(0.5, "performing")) return fail(ErrorCode::cancelled, "stopped", request.take.string());

  take::Header header;
  header.software = request.software;
  header.performer = fmt::format("virtual:{}", request.seed);
  header.script = request.script_name;
  header.devices = request.devices;
  header.face = request.face;
  header.prologue = prologue_name(request.prologue);
  header.seed = request.seed;
  header.rig_toml = stage.rig_toml;
  header.created_utc = now_utc();
  // Before the file is there: a recording begins when its take does.
  const std::vector<take::CalibrationVersion> calibrations = stage.worn->calibrations(stage, session);
  MIEN_TRY_ASSIGN(
      take::TakeWriter writer,
      take::TakeWriter::create(request.take, header, request.replace,
                               request.real_time ? take::Appears::at_once : take::Appears::when_finished));
  for (const take::Event& event : session.events) writer.add_event(event);

  const auto start = std::chrono::steady_clock::now();
  std::size_t next_sample = 0;
  std::size_t next_tick = 0;
  std::size_t next_calibration = 0;
  std::size_t sound_written = 0;
  bool stopped = false;
  // Sound goes in as it is heard, in pieces of half a second and what is left at the end.
  const auto write_sound = [&](DeviceTime reached, bool last) {
    if (!request.sound) return;
    const Sound& sound = *request.sound;
    const double at = std::max(0.0, to_seconds(reached - session.motion_start)) * sound.rate_hz;
    const std::size_t end =
        last ? sound.samples.size() : std::min(sound.samples.size(), static_cast<std::size_t>(at));
    if (end <= sound_written || (!last && end - sound_written < sound.rate_hz / 2)) return;
    const double from_s = static_cast<double>(sound_written) / sound.rate_hz;
    writer.add_audio(static_cast<int>(sound.rate_hz), session.motion_start + from_seconds(from_s),
                     std::span(sound.samples).subspan(sound_written, end - sound_written));
    sound_written = end;
  };
  const auto write_ticks = [&](std::int64_t known) {
    for (; next_tick < session.ticks.size() && session.ticks[next_tick].after_entry <= known; ++next_tick) {
      writer.add_tick(session.ticks[next_tick]);
      writer.add_truth(session.truth[next_tick]);
      write_sound(session.ticks[next_tick].frame, false);
      for (; next_calibration < calibrations.size() &&
             calibrations[next_calibration].made <= session.ticks[next_tick].frame;
           ++next_calibration)
        writer.add_calibration(calibrations[next_calibration]);
    }
  };
  for (const take::LogEntry& entry : session.entries) {
    write_ticks(entry.id - 1);
    if (request.real_time) std::this_thread::sleep_until(start + entry.arrival.time_since_epoch());
    sensor::Payload payload;
    const auto beside = session.payloads.find(entry.id);
    if (beside != session.payloads.end()) payload.bytes = beside->second;
    const std::int64_t id = writer.add_entry(entry.arrival, entry.source, entry.bytes, payload);
    for (; next_sample < session.samples.size() && session.samples[next_sample].entry == entry.id;
         ++next_sample)
      writer.add_sample(id, entry.arrival, session.samples[next_sample].sample);
    if (entry.id % 512 != 0) continue;
    if (!writer.status()) break;  // The disk is full, say: finish() tells.
    if (!progress(0.5 + 0.5 * static_cast<double>(entry.id) / static_cast<double>(session.entries.size()),
                  "writing")) {
      stopped = true;
      break;
    }
  }
  if (stopped && !request.real_time)
    return fail(ErrorCode::cancelled, "stopped", request.take.string(), "nothing was kept");
  if (!stopped) {
    write_ticks(static_cast<std::int64_t>(session.entries.size()));
    write_sound({}, true);
  }
  MIEN_TRY(writer.finish());
  if (stopped)
    return fail(ErrorCode::cancelled, "stopped", request.take.string(),
                "what was performed until then is kept");
  progress(1, "written");
  return PerformSummary{stage.motion.motion.duration_s(), session.ticks.size(), session.entries.size(),
                        session.samples.size()};
}

}  // namespace mien::virt
