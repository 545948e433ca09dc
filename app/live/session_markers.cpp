#include "app/live/session_markers.h"

#include <fmt/format.h>

#include <memory>
#include <vector>

#include "mien/mocap/marker_log.h"
#include "mien/modalities/modalities.h"
#include "mien/sensor/clock_model.h"
#include "mien/session/replay.h"
#include "mien/take/layout.h"

namespace mien::app {
namespace {

DeviceTime device_time(double seconds) {
  return DeviceTime(from_seconds(seconds));
}

/// The track with its times on the take's line; frames before both clocks are known are left out. What was
/// known of the clocks at the first tick after a frame came places it. Errors: the take's,
/// modalities::make_receiving_session's.
Result<mocap::MarkerTrack> on_line(const mocap::MarkerLog::Received& received, const take::Take& take) {
  MIEN_TRY_ASSIGN(const std::unique_ptr<session::Session> session,
                  modalities::make_receiving_session(take.rig()));
  sensor::ClockModel server;
  mocap::MarkerTrack track;
  track.name = take.path().stem().string();
  track.markers = received.track.markers;
  std::size_t next = 0;
  const auto place_until = [&](HostTime known) {
    for (; next < received.track.frames() && received.arrival[next] <= known; ++next) {
      const DeviceTime time = device_time(received.track.time_s[next]);
      server.add(time, received.arrival[next]);
      if (!session->lines().ready()) continue;
      const double line_s = to_seconds(session->lines().from_host(server.to_host(time)).time_since_epoch());
      if (!track.time_s.empty() && line_s <= track.time_s.back()) continue;
      track.time_s.push_back(line_s);
      const auto frame = received.track.frame(next);
      track.position_m.insert(track.position_m.end(), frame.begin(), frame.end());
    }
  };
  MIEN_TRY(session::replay(take, *session, [&](const take::Tick& tick, const face::OutputFrame&) {
    place_until(tick.fired);
    return true;
  }));
  place_until(HostTime::max());
  return track;
}

}  // namespace

Result<SessionMarkers> session_markers(const take::Take& take, const MarkerImport& options) {
  MIEN_TRY_ASSIGN(const std::vector<take::LogEntry> entries, take.entries());
  mocap::MarkerLog log;
  for (const take::LogEntry& entry : entries) log.add(entry.arrival, entry.bytes);
  const std::vector<mocap::MarkerLog::Received> received = log.received();
  SessionMarkers markers;
  markers.unnamed = log.unnamed();
  if (received.empty() || received.front().track.frames() == 0)
    return fail(ErrorCode::not_found,
                markers.unnamed > 0
                    ? fmt::format("{} frames of markers whose names nobody told", markers.unnamed)
                    : std::string("no markers were recorded in this take"),
                take.path().string(),
                "a motion capture server sends names and positions to a port of mien live: "
                "docs/reference/protocol.md");
  MIEN_TRY_ASSIGN(const mocap::MarkerTrack track, on_line(received.front(), take));
  if (track.frames() == 0)
    return fail(ErrorCode::not_found, "no marker came while a sensor was sending", take.path().string());
  markers.begin = device_time(track.time_s.front());
  MIEN_TRY_ASSIGN(markers.imported, import_markers(track, options));
  return markers;
}

Result<void> write_with_truth(const take::Take& take, const face::Motion& motion, DeviceTime begin,
                              const std::string& face, const std::filesystem::path& path, bool replace) {
  std::error_code code;
  if (std::filesystem::equivalent(take.path(), path, code))
    return fail(ErrorCode::bad_usage, "a take cannot be written over itself", path.string(),
                "give --take another name");
  take::Header header = take.header();
  header.face = face;
  MIEN_TRY_ASSIGN(const std::vector<take::LogEntry> entries, take.entries());
  MIEN_TRY_ASSIGN(const std::vector<take::StoredSample> samples, take.samples());
  MIEN_TRY_ASSIGN(const std::vector<take::Tick> ticks, take.ticks());
  MIEN_TRY_ASSIGN(const std::vector<take::Event> events, take.events());
  MIEN_TRY_ASSIGN(const std::vector<take::CalibrationVersion> calibrations, take.calibrations());
  MIEN_TRY_ASSIGN(const std::optional<take::Audio> audio, take.audio());
  MIEN_TRY_ASSIGN(const std::vector<take::Note> notes, take.notes());

  MIEN_TRY_ASSIGN(take::TakeWriter writer,
                  take::TakeWriter::create(path, header, replace, take::Appears::when_finished));
  MIEN_TRY_ASSIGN(take::PayloadReader payloads, take.payloads());
  for (const take::LogEntry& entry : entries) {
    MIEN_TRY_ASSIGN(const sensor::Payload payload, payloads.of(entry.id));
    writer.add_entry(entry.arrival, entry.source, entry.bytes, payload);
  }
  for (const take::StoredSample& stored : samples)
    writer.add_sample(stored.entry, stored.arrival, stored.sample);
  for (const take::Tick& tick : ticks) writer.add_tick(tick);
  const face::MotionCurve curve(motion);
  for (const take::Tick& tick : ticks) {
    const double time_s = to_seconds(tick.frame - begin);
    if (time_s < 0 || time_s > motion.duration_s()) continue;
    const face::MotionFrame frame = curve.at(time_s);
    take::TruthFrame truth;
    truth.time = tick.frame;
    truth.weights = frame.weights;
    truth.has_face = frame.has_face;
    writer.add_truth(truth);
  }
  for (const take::Event& event : events) writer.add_event(event);
  for (const take::CalibrationVersion& calibration : calibrations) writer.add_calibration(calibration);
  if (audio) writer.add_audio(audio->rate_hz, audio->start, audio->samples);
  for (const take::Note& note : notes)
    if (note.key != take::kFinishedKey) writer.add_note(note.key, note.value);
  return writer.finish();
}

}  // namespace mien::app
