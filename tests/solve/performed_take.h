#pragma once

#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <string>

#include "mien/take/take.h"
#include "mien/virtual/imu/imu_session.h"
#include "tests/folder.h"
#include "tests/virtual/three_sensors.h"

namespace mien::solve::test {

struct Folder : mien::test::Folder {
  Folder() : mien::test::Folder(On::memory) {}
};

/// A second of a nodding, talking performer on hand-made sites, after a short prologue.
inline virt::VirtualSession device_session() {
  const performer::PrologueMotion motion =
      performer::with_prologue(virt::test::talking(60), performer::PrologueKind::brief, Random(3));
  return virt::play_devices(motion, virt::test::three_sites(), virt::test::three_sensors(),
                            virt::test::mild_faults(), Random(11))
      .value();
}
inline virt::VirtualSession lab_session(double noise_rad = virt::kLabNoiseRad) {
  const performer::PrologueMotion motion = performer::with_prologue(
      virt::test::talking(60, false), performer::PrologueKind::brief, Random(3), {.gestures = false});
  return virt::play_lab(motion, virt::test::three_sites(), virt::test::three_sensors(), Random(11), noise_rad)
      .value();
}

/// Stores a session as mien perform does, and opens it.
inline take::Take stored(const virt::VirtualSession& session, const std::filesystem::path& path,
                         const std::string& devices) {
  take::Header header;
  header.software = "mien test";
  header.devices = devices;
  header.face = "builtin";
  header.rig_toml = virt::test::kRig;
  auto writer = take::TakeWriter::create(path, header, true).value();
  for (const take::Event& event : session.events) writer.add_event(event);
  std::size_t next = 0;
  for (const take::LogEntry& entry : session.entries) {
    const std::int64_t id = writer.add_entry(entry.arrival, entry.source, entry.bytes);
    for (; next < session.samples.size() && session.samples[next].entry == entry.id; ++next)
      writer.add_sample(id, entry.arrival, session.samples[next].sample);
  }
  for (const take::Tick& tick : session.ticks) writer.add_tick(tick);
  for (const take::TruthFrame& truth : session.truth) writer.add_truth(truth);
  const auto done = writer.finish();
  EXPECT_TRUE(done) << done.error().message();
  return take::Take::open(path).value();
}

}  // namespace mien::solve::test
