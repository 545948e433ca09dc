#pragma once

#include <gtest/gtest.h>
#include <sqlite3.h>
#include <stdlib.h>

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "mien/take/take.h"
#include "tests/folder.h"

namespace mien::take::test {

using mien::test::Folder;

inline constexpr const char* kRig =
    "name = \"pair\"\nreference = \"b\"\n"
    "[[sensor]]\nname = \"a\"\nkind = \"imu\"\nsite = \"mentalis\"\nside = \"M\"\nrole = \"face\"\n"
    "[[sensor]]\nname = \"b\"\nkind = \"imu\"\nsite = \"mastoid\"\nside = \"L\"\nrole = \"head\"\n";

inline Header example_header() {
  Header header;
  header.software = "mien test";
  header.performer = "virtual:7";
  header.script = "alex.csv";
  header.devices = "device";
  header.face = "builtin";
  header.face_parameters = "{\"jaw\":0.5}";
  header.prologue = "short";
  header.seed = 0xFEDCBA9876543210U;
  header.rig_toml = kRig;
  header.created_utc = "2026-01-02T03:04:05Z";
  return header;
}

inline HostTime host_ms(std::int64_t ms) {
  return HostTime(std::chrono::milliseconds(ms));
}
inline DeviceTime device_ms(std::int64_t ms) {
  return DeviceTime(std::chrono::milliseconds(ms));
}

/// What a packet number `id` holds, so that a reader can tell that it is whole.
inline std::vector<std::byte> example_bytes(std::int64_t id) {
  std::vector<std::byte> bytes(static_cast<std::size_t>(20 + id % 180));
  for (std::size_t i = 0; i < bytes.size(); ++i)
    bytes[i] = static_cast<std::byte>((static_cast<std::size_t>(id) * 31 + i * 7) & 0xFFU);
  return bytes;
}

inline sensor::Sample example_sample(std::int64_t id) {
  sensor::Sample sample;
  sample.sensor = static_cast<std::uint16_t>(id % 2);
  sample.kind = sensor::SampleKind::imu_raw;
  sample.sequence = static_cast<std::uint32_t>(id);
  sample.time = device_ms(5000 + id);
  sample.count = 6;
  for (std::size_t i = 0; i < 6; ++i)
    sample.values[i] = static_cast<float>(id) * 0.25F + static_cast<float>(i);
  return sample;
}

inline TruthFrame example_truth(std::int64_t index) {
  TruthFrame truth;
  truth.time = device_ms(5000) + frame_offset(index);
  for (std::size_t i = 0; i < face::kShapeCount; ++i)
    truth.weights[i] = static_cast<float>((index + static_cast<std::int64_t>(i)) % 64) / 64.0F;
  truth.tongue_out = 0.125F;
  truth.has_face = index % 5 != 0;
  truth.evaluated = index > 2;
  return truth;
}

/// One millisecond of a recording: a packet with one sample, and now and then a tick and a frame of truth.
inline void add_example(TakeWriter& writer, std::int64_t id, HostTime arrival) {
  const auto entry = writer.add_entry(arrival, "udp://127.0.0.1:5005", example_bytes(id));
  writer.add_sample(entry, arrival, example_sample(id));
  if (id % 16 == 0) {
    const std::int64_t index = id / 16;
    writer.add_tick({index, entry, arrival, device_ms(5000) + frame_offset(index)});
    writer.add_truth(example_truth(index));
  }
}

/// A finished take with something in every table.
inline void write_example(const std::filesystem::path& path, std::int64_t packets = 64) {
  auto writer = TakeWriter::create(path, example_header(), true);
  ASSERT_TRUE(writer) << writer.error().message();
  for (std::int64_t id = 1; id <= packets; ++id) add_example(*writer, id, host_ms(id));
  writer->add_event({"nod", device_ms(5010), device_ms(5020), "{\"n\":1}"});
  writer->add_calibration({0, device_ms(5030), "imu", "{\"v\":1}"});
  writer->add_audio(8000, device_ms(5000), std::vector<float>(80, 0.5F));
  writer->add_note("model", "none");
  const auto done = writer->finish();
  ASSERT_TRUE(done) << done.error().message();
}

inline std::string read_raw(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}
inline void write_raw(const std::filesystem::path& path, std::string_view bytes) {
  // A new file each time: some file systems flush one that is truncated and written again.
  std::filesystem::remove(path);
  std::ofstream file(path, std::ios::binary);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

/// The same as write_example(), from memory: recording a take anew for each test would wait for the disk each
/// time.
inline void copy_example(const std::filesystem::path& path) {
  static const std::string example = [] {
    const Folder folder;
    write_example(folder / "a.mien");
    return read_raw(folder / "a.mien");
  }();
  write_raw(path, example);
}

/// Opens the take and reads every track; the first error, or "" when all is well.
inline std::string read_everything(const std::filesystem::path& path) {
  const auto take = Take::open(path);
  if (!take) return take.error().message();
  const auto message = [](const auto& result) { return result ? std::string() : result.error().message(); };
  for (const std::string& text :
       {message(take->entries()), message(take->samples()), message(take->ticks()), message(take->truth()),
        message(take->events()), message(take->calibrations()), message(take->audio()),
        message(take->notes()), message(take->check())})
    if (!text.empty()) return text;
  return {};
}

/// Changes a file as another program could.
inline void run_sql(const std::filesystem::path& path, const std::string& sql) {
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(path.c_str(), &database), SQLITE_OK);
  sqlite3_exec(database, "PRAGMA synchronous=OFF", nullptr, nullptr, nullptr);
  char* message = nullptr;
  EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, &message), SQLITE_OK)
      << sql << ": " << (message == nullptr ? "" : message);
  sqlite3_free(message);
  sqlite3_close(database);
}

}  // namespace mien::take::test
