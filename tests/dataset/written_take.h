#pragma once

#include <optional>
#include <string>
#include <vector>

#include "mien/builtin_face/load_face.h"
#include "mien/performer/script.h"
#include "mien/session/consent.h"
#include "mien/virtual/stage.h"
#include "tests/project_path.h"
#include "tests/solve/performed_take.h"

namespace mien::dataset::test {

using solve::test::Folder;

/// What is written into a take of a virtual session.
struct WrittenTake {
  std::string performer = "virtual:1";  ///< Of the header.
  std::string rig_toml = virt::test::kRig;
  std::optional<std::string> consents;  ///< Somebody of this name, `consent_s` after the first frame.
  double consent_s = 0;
  bool own_truth = true;
  std::vector<take::Event> events;  ///< More of them.
  std::vector<float> sound;         ///< 16 kHz, from the first frame on.
};

inline session::Consent consent_of_test(const std::string& performer) {
  return {
      .performer = performer, .recorded_by = "a theatre", .purpose = "to *train* | models", .sound = true};
}

inline DeviceTime at_s(const virt::VirtualSession& session, double seconds) {
  return session.ticks.front().frame + from_seconds(seconds);
}

/// A line's event, from and to so many seconds after the first frame.
inline take::Event line_event(const virt::VirtualSession& session, double from_s, double to_s,
                              const std::string& json) {
  return {"prompt", at_s(session, from_s), at_s(session, to_s), json};
}

inline void write_take(const std::filesystem::path& path, const virt::VirtualSession& session,
                       const WrittenTake& written) {
  take::Header header;
  header.software = "mien test";
  header.performer = written.performer;
  header.devices = "device";
  header.face = "builtin";
  header.created_utc = "2026-11-28T00:00:00Z";
  header.rig_toml = written.rig_toml;
  auto writer = take::TakeWriter::create(path, header, true).value();
  for (const take::Event& event : session.events) writer.add_event(event);
  if (written.consents) {
    const DeviceTime when = at_s(session, written.consent_s);
    writer.add_event(
        {"consent", when, when, session::consent_event_json(consent_of_test(*written.consents))});
  }
  for (const take::Event& event : written.events) writer.add_event(event);
  std::size_t next = 0;
  for (const take::LogEntry& entry : session.entries) {
    const std::int64_t id = writer.add_entry(entry.arrival, entry.source, entry.bytes);
    for (; next < session.samples.size() && session.samples[next].entry == entry.id; ++next)
      writer.add_sample(id, entry.arrival, session.samples[next].sample);
  }
  for (const take::Tick& tick : session.ticks) writer.add_tick(tick);
  if (written.own_truth)
    for (const take::TruthFrame& truth : session.truth) writer.add_truth(truth);
  if (!written.sound.empty()) writer.add_audio(16'000, session.ticks.front().frame, written.sound);
  const auto done = writer.finish();
  EXPECT_TRUE(done) << done.error().message();
}

/// A performer on hand-made sites of three sensors, who talks for so long after a short prologue.
inline virt::VirtualSession talking_session(double seconds, std::uint64_t seed = 11) {
  const performer::PrologueMotion motion = performer::with_prologue(
      virt::test::talking(static_cast<int>(60 * seconds)), performer::PrologueKind::brief, Random(3));
  return virt::play_devices(motion, virt::test::three_sites(), virt::test::three_sensors(),
                            virt::test::mild_faults(), Random(seed))
      .value();
}

/// Without the sensor "buccinator_L" as a sensor of the face.
inline std::string rig_of_one_face_sensor() {
  sensor::Rig rig = virt::test::three_sensors();
  rig.sensors[1].role = "head";
  rig.sensors[2].role = "face";
  return sensor::write_rig(rig);
}

}  // namespace mien::dataset::test
