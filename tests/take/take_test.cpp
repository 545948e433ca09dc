#include "mien/take/take.h"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>

#include "mien/take/row_writer.h"
#include "tests/take/example_take.h"

namespace mien::take::take_test {
namespace {

namespace fs = std::filesystem;
using test::device_ms;
using test::host_ms;
using ::testing::HasSubstr;

TEST(Take, GivesBackAllThatWasWritten) {
  const mien::test::Folder folder;
  const auto path = folder / "a.mien";
  test::write_example(path, 100);
  const auto take = Take::open(path);
  ASSERT_TRUE(take) << take.error().message();
  EXPECT_EQ(take->path(), path);
  EXPECT_TRUE(take->finished());
  EXPECT_EQ(take->rig().sensors.size(), 2U);

  const Header expected = test::example_header();
  const Header& header = take->header();
  EXPECT_EQ(header.software, expected.software);
  EXPECT_EQ(header.performer, expected.performer);
  EXPECT_EQ(header.script, expected.script);
  EXPECT_EQ(header.devices, expected.devices);
  EXPECT_EQ(header.face, expected.face);
  EXPECT_EQ(header.face_parameters, expected.face_parameters);
  EXPECT_EQ(header.prologue, expected.prologue);
  EXPECT_EQ(header.seed, expected.seed);
  EXPECT_EQ(header.rig_toml, expected.rig_toml);
  EXPECT_EQ(header.created_utc, expected.created_utc);

  const auto entries = take->entries();
  ASSERT_TRUE(entries) << entries.error().message();
  ASSERT_EQ(entries->size(), 100U);
  for (std::int64_t id = 1; id <= 100; ++id) {
    const LogEntry& entry = (*entries)[static_cast<std::size_t>(id - 1)];
    EXPECT_EQ(entry.id, id);
    EXPECT_EQ(entry.arrival, host_ms(id));
    EXPECT_EQ(entry.source, "udp://127.0.0.1:5005");
    EXPECT_EQ(entry.bytes, test::example_bytes(id));
  }
  EntryReader log = take->log().value();
  for (const LogEntry& entry : *entries) EXPECT_EQ(log.next().value()->id, entry.id);
  for (int again = 0; again < 2; ++again) EXPECT_EQ(log.next().value(), nullptr);
  const auto samples = take->samples();
  ASSERT_TRUE(samples) << samples.error().message();
  ASSERT_EQ(samples->size(), 100U);
  for (std::int64_t id = 1; id <= 100; ++id) {
    const StoredSample& stored = (*samples)[static_cast<std::size_t>(id - 1)];
    const sensor::Sample wanted = test::example_sample(id);
    EXPECT_EQ(stored.entry, id);
    EXPECT_EQ(stored.arrival, host_ms(id));
    EXPECT_EQ(stored.sample.sensor, wanted.sensor);
    EXPECT_EQ(stored.sample.kind, wanted.kind);
    EXPECT_EQ(stored.sample.sequence, wanted.sequence);
    EXPECT_EQ(stored.sample.time, wanted.time);
    EXPECT_EQ(stored.sample.time_estimated, wanted.time_estimated);
    EXPECT_EQ(stored.sample.count, wanted.count);
    EXPECT_EQ(stored.sample.values, wanted.values);
  }
  const auto ticks = take->ticks();
  ASSERT_TRUE(ticks) << ticks.error().message();
  ASSERT_EQ(ticks->size(), 6U);
  EXPECT_EQ((*ticks)[5].index, 6);
  EXPECT_EQ((*ticks)[5].after_entry, 96);
  EXPECT_EQ((*ticks)[5].fired, host_ms(96));
  EXPECT_EQ((*ticks)[5].frame, device_ms(5000) + frame_offset(6));
  const auto truth = take->truth();
  ASSERT_TRUE(truth) << truth.error().message();
  ASSERT_EQ(truth->size(), 6U);
  for (std::int64_t index = 1; index <= 6; ++index) {
    const TruthFrame& frame = (*truth)[static_cast<std::size_t>(index - 1)];
    const TruthFrame wanted = test::example_truth(index);
    EXPECT_EQ(frame.time, wanted.time);
    EXPECT_EQ(frame.weights, wanted.weights);
    EXPECT_EQ(frame.tongue_out, wanted.tongue_out);
    EXPECT_EQ(frame.has_face, wanted.has_face);
    EXPECT_EQ(frame.evaluated, wanted.evaluated);
  }
  const auto events = take->events();
  ASSERT_TRUE(events);
  ASSERT_EQ(events->size(), 1U);
  EXPECT_EQ(events->front().kind, "nod");
  EXPECT_EQ(events->front().begin, device_ms(5010));
  EXPECT_EQ(events->front().end, device_ms(5020));
  EXPECT_EQ(events->front().json, "{\"n\":1}");
  const auto calibrations = take->calibrations();
  ASSERT_TRUE(calibrations);
  ASSERT_EQ(calibrations->size(), 1U);
  EXPECT_EQ(calibrations->front().id, 1);
  EXPECT_EQ(calibrations->front().made, device_ms(5030));
  EXPECT_EQ(calibrations->front().modality, "imu");
  EXPECT_EQ(calibrations->front().json, "{\"v\":1}");
  const auto audio = take->audio();
  ASSERT_TRUE(audio);
  ASSERT_TRUE(audio->has_value());
  EXPECT_EQ((*audio)->rate_hz, 8000);
  EXPECT_EQ((*audio)->start, device_ms(5000));
  EXPECT_EQ((*audio)->samples, std::vector<float>(80, 0.5F));
  EXPECT_EQ(take->note("model"), "none");
  EXPECT_EQ(take->note("no such key"), "");
  EXPECT_TRUE(take->check());
}

TEST(Take, KeepsTheEdgesOfItsRanges) {
  const mien::test::Folder folder;
  const auto path = folder / "a.mien";
  auto writer = TakeWriter::create(path, test::example_header(), false);
  ASSERT_TRUE(writer);
  const std::string odd("a\0b\n\xC3\xA9", 6);
  EXPECT_EQ(writer->add_entry(HostTime{}, "", {}), 1);
  EXPECT_EQ(writer->add_entry(HostTime{}, odd, std::vector<std::byte>(1U << 24U)), 2);
  sensor::Sample sample = test::example_sample(1);
  sample.kind = static_cast<sensor::SampleKind>(200);
  sample.count = sensor::kMaxSampleValues;
  sample.sequence = std::numeric_limits<std::uint32_t>::max();
  sample.time = device_ms(-5);
  sample.time_estimated = true;
  sample.values.back() = -std::numeric_limits<float>::max();
  sample.values.front() = std::numeric_limits<float>::denorm_min();
  writer->add_sample(0, HostTime{}, sample);
  sample.count = 0;
  writer->add_sample(2, HostTime{}, sample);
  writer->add_tick({-3, 0, HostTime{}, device_ms(-50)});
  writer->add_tick({7, 2, HostTime{}, device_ms(0)});
  writer->add_event({"tap", device_ms(1), device_ms(1), ""});
  writer->add_event({"tap", device_ms(0), device_ms(1), odd});
  writer->add_note("key", odd);
  writer->add_note("key", "");
  writer->add_calibration({4, device_ms(1), "imu", ""});
  writer->add_calibration({0, device_ms(1), "imu", ""});
  const auto done = writer->finish();
  ASSERT_TRUE(done) << done.error().message();

  const auto take = Take::open(path);
  ASSERT_TRUE(take) << take.error().message();
  const auto entries = take->entries().value();
  ASSERT_EQ(entries.size(), 2U);
  EXPECT_EQ(entries[0].source, "");
  EXPECT_TRUE(entries[0].bytes.empty());
  EXPECT_EQ(entries[1].source, odd);
  EXPECT_EQ(entries[1].bytes.size(), 1U << 24U);
  const auto samples = take->samples().value();
  ASSERT_EQ(samples.size(), 2U);
  EXPECT_EQ(static_cast<int>(samples[0].sample.kind), 200);
  EXPECT_EQ(samples[0].sample.values, sample.values);
  EXPECT_EQ(samples[0].sample.sequence, sample.sequence);
  EXPECT_EQ(samples[0].sample.time, sample.time);
  EXPECT_TRUE(samples[0].sample.time_estimated);
  EXPECT_EQ(samples[1].sample.count, 0);
  EXPECT_EQ(take->ticks().value().front().index, -3);
  EXPECT_EQ(take->events().value()[1].json, odd);
  EXPECT_EQ(take->note("key"), "");
  EXPECT_EQ(take->notes().value()[0].value, odd);
  EXPECT_EQ(take->calibrations().value()[1].id, 5);
  EXPECT_FALSE(take->audio().value().has_value());
  EXPECT_TRUE(take->check());
}

TEST(Take, JoinsSoundThatCameInPieces) {
  const mien::test::Folder folder;
  const auto path = folder / "a.mien";
  auto writer = TakeWriter::create(path, test::example_header(), false);
  ASSERT_TRUE(writer);
  std::vector<float> sound(200'000);
  for (std::size_t i = 0; i < sound.size(); ++i) sound[i] = std::sin(static_cast<float>(i) * 0.01F);
  writer->add_audio(48000, device_ms(100), std::span(sound).first(150'000));
  writer->add_audio(48000, device_ms(100) + from_seconds(150'000 / 48000.0),
                    std::span(sound).subspan(150'000));
  writer->add_audio(48000, device_ms(0), {});
  ASSERT_TRUE(writer->finish());
  const auto audio = Take::open(path).value().audio().value();
  ASSERT_TRUE(audio);
  EXPECT_EQ(audio->samples, sound);
  EXPECT_EQ(audio->start, device_ms(100));
}

TEST(Take, StoresMoreThanItsQueueHolds) {
  const mien::test::Folder folder;
  const auto path = folder / "a.mien";
  auto writer = TakeWriter::create(path, test::example_header(), false);
  ASSERT_TRUE(writer);
  const std::vector<std::byte> packet(60'000, std::byte{7});
  for (int i = 0; i < 1000; ++i) writer->add_entry(host_ms(i), i % 2 == 0 ? "left" : "right", packet);
  ASSERT_TRUE(writer->finish());
  const auto entries = Take::open(path).value().entries().value();
  ASSERT_EQ(entries.size(), 1000U);
  EXPECT_EQ(entries[999].source, "right");
  EXPECT_EQ(entries[999].bytes, packet);
}

// Strangers who send once, from ever new ports, under the sender that stays.
TEST(Take, RemembersNoMoreSourcesThanItHasRoomFor) {
  const mien::test::Folder folder;
  const auto path = folder / "a.mien";
  const auto name = [](int i) { return i % 10 == 0 ? "board" : "stranger " + std::to_string(i); };
  auto writer = TakeWriter::create(path, test::example_header(), false);
  ASSERT_TRUE(writer);
  constexpr int kEntries = 20'000;
  for (int i = 0; i < kEntries; ++i) writer->add_entry(host_ms(i), name(i), {});
  ASSERT_TRUE(writer->finish());
  const auto entries = Take::open(path).value().entries().value();
  ASSERT_EQ(entries.size(), static_cast<std::size_t>(kEntries));
  for (int i = 0; i < kEntries; ++i) ASSERT_EQ(entries[static_cast<std::size_t>(i)].source, name(i));
  const auto database = Database::open(path, SQLITE_OPEN_READONLY, "a.mien").value();
  // A row anew after each 4,095 others.
  EXPECT_EQ(database.read_integer("SELECT count(*) FROM source WHERE name='board'").value(), 5);
}

TEST(Take, OpensWhileItIsRecorded) {
  const mien::test::Folder folder;
  const auto path = folder / "a.mien";
  auto writer = TakeWriter::create(path, test::example_header(), false);
  ASSERT_TRUE(writer);
  const std::vector<std::byte> packet(60'000, std::byte{7});
  std::size_t seen = 0;
  // Every batch of 4 MiB is committed when it is full, so this ends.
  for (std::int64_t id = 1; seen == 0; ++id) {
    const auto entry = writer->add_entry(host_ms(id), "udp", packet);
    writer->add_sample(entry, host_ms(id), test::example_sample(id));
    if (id % 100 != 0) continue;
    const auto take = Take::open(path);
    ASSERT_TRUE(take) << take.error().message();
    EXPECT_FALSE(take->finished());
    const auto samples = take->samples();
    ASSERT_TRUE(samples) << samples.error().message();
    const auto entries = take->entries();
    ASSERT_TRUE(entries) << entries.error().message();
    seen = entries->size();
  }
  ASSERT_TRUE(writer->finish());
  EXPECT_TRUE(Take::open(path).value().finished());
}

TEST(Take, ShowsWhatStoodThereWhenItWasOpened) {
  const mien::test::Folder folder;
  const auto path = folder / "a.mien";
  test::write_example(path, 10);
  const auto take = Take::open(path);
  ASSERT_TRUE(take);
  test::run_sql(path,
                "INSERT INTO log VALUES(11,99000000,1,x'00'),(12,99000000,1,x'00');"
                "INSERT INTO sample VALUES(11,12,0,0,1,0,0,0,x'');");
  EXPECT_EQ(take->entries().value().size(), 10U);
  EXPECT_EQ(take->samples().value().size(), 10U);
  // The recorder went on after its own end: that is seen.
  EXPECT_THAT(test::read_everything(path), HasSubstr("when it was finished it held"));
}

TEST(TakeWriter, LeavesAnExistingFileAloneUnlessTold) {
  const mien::test::Folder folder;
  const auto path = folder / "a.mien";
  test::write_raw(path, "precious");
  const auto refused = TakeWriter::create(path, test::example_header(), false);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::bad_usage);
  EXPECT_EQ(test::read_raw(path), "precious");

  // A header that cannot be stored replaces nothing either.
  Header bad = test::example_header();
  bad.rig_toml = "name = ";
  EXPECT_FALSE(TakeWriter::create(path, bad, true));
  EXPECT_EQ(test::read_raw(path), "precious");

  test::write_raw(folder / "a.mien-journal", "left by the old one");
  test::write_example(path);
  EXPECT_EQ(test::read_everything(path), "");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1)
      << "something is left beside it";
}

TEST(TakeWriter, AppearsWholeWhenToldTo) {
  const mien::test::Folder folder;
  const auto path = folder / "a.mien";
  test::write_raw(path, "precious");
  const auto files = [&] { return std::distance(std::filesystem::directory_iterator(folder.path()), {}); };
  {
    auto writer = TakeWriter::create(path, test::example_header(), true, Appears::when_finished);
    ASSERT_TRUE(writer);
    writer->add_event({"tap", DeviceTime{}, DeviceTime{}, ""});
    EXPECT_EQ(test::read_raw(path), "precious");
  }
  EXPECT_EQ(test::read_raw(path), "precious") << "it was not finished";
  EXPECT_EQ(files(), 1);
  {
    auto writer = TakeWriter::create(path, test::example_header(), true, Appears::when_finished);
    ASSERT_TRUE(writer);
    writer->add_event({"tap", DeviceTime{}, DeviceTime{}, ""});
    ASSERT_TRUE(writer->finish());
  }
  EXPECT_EQ(files(), 1);
  const auto take = Take::open(path);
  ASSERT_TRUE(take) << take.error().message();
  EXPECT_TRUE(take->finished());
  EXPECT_EQ(take->events()->size(), 1U);
  // Nor does it take a name that was given away meanwhile.
  auto late = TakeWriter::create(folder / "b.mien", test::example_header(), false, Appears::when_finished);
  ASSERT_TRUE(late);
  test::write_raw(folder / "b.mien", "somebody was quicker");
  EXPECT_FALSE(late->finish());
  EXPECT_EQ(test::read_raw(folder / "b.mien"), "somebody was quicker");
  EXPECT_EQ(files(), 2);
}

TEST(TakeWriter, NamesFoldersThatAreNotThere) {
  const mien::test::Folder folder;
  const auto missing = TakeWriter::create(folder / "no/such/a.mien", test::example_header(), false);
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::not_found);
  EXPECT_THAT(missing.error().message(), HasSubstr("no/such: there is no such folder"));
  EXPECT_EQ(TakeWriter::create(folder.path(), test::example_header(), true).error().code,
            ErrorCode::bad_usage);
  EXPECT_EQ(TakeWriter::create("/dev/null", test::example_header(), true).error().code, ErrorCode::bad_usage);
}

TEST(TakeWriter, CommitsWithoutBeingFinishedByName) {
  const mien::test::Folder folder;
  const auto path = folder / "a.mien";
  {
    auto first = TakeWriter::create(path, test::example_header(), false);
    ASSERT_TRUE(first);
    test::add_example(*first, 1, host_ms(1));
    TakeWriter moved = std::move(*first);
    test::add_example(moved, 2, host_ms(2));
  }
  const auto take = Take::open(path);
  ASSERT_TRUE(take);
  EXPECT_TRUE(take->finished());
  EXPECT_EQ(take->entries().value().size(), 2U);
}

TEST(TakeWriter, SaysWhenTheFileWasTakenAway) {
  const mien::test::Folder folder;
  const auto path = folder / "a.mien";
  auto writer = TakeWriter::create(path, test::example_header(), false);
  ASSERT_TRUE(writer);
  std::filesystem::rename(path, folder / "b.mien");
  test::add_example(*writer, 1, host_ms(1));
  const auto done = writer->finish();
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, ErrorCode::io);
  EXPECT_THAT(done.error().message(), HasSubstr("moved"));
}

struct BadInput {
  const char* name;
  std::function<void(TakeWriter&)> add;
  const char* message;
};

class TakeWriterRefuses : public ::testing::TestWithParam<BadInput> {};

TEST_P(TakeWriterRefuses, AndKeepsWhatCameBefore) {
  const mien::test::Folder folder;
  const auto path = folder / "a.mien";
  auto writer = TakeWriter::create(path, test::example_header(), false);
  ASSERT_TRUE(writer);
  for (std::int64_t id = 1; id <= 32; ++id) test::add_example(*writer, id, host_ms(id));
  writer->add_audio(8000, device_ms(0), std::vector<float>(8, 0.0F));
  ASSERT_TRUE(writer->status());
  GetParam().add(*writer);
  const auto status = writer->status();
  ASSERT_FALSE(status);
  EXPECT_THAT(status.error().message(), HasSubstr(GetParam().message));
  EXPECT_THAT(status.error().message(), HasSubstr("a.mien"));
  // Nothing is stored after the error, though in order.
  writer->add_entry(host_ms(10'000), "later", {});
  const auto done = writer->finish();
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error(), status.error());
  EXPECT_EQ(writer->finish().error(), status.error());

  const auto take = Take::open(path);
  ASSERT_TRUE(take) << take.error().message();
  EXPECT_FALSE(take->finished());
  EXPECT_EQ(take->entries().value().size(), 32U);
  EXPECT_EQ(take->samples().value().size(), 32U);
  EXPECT_TRUE(take->check());
}

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

sensor::Sample sample_with(const std::function<void(sensor::Sample&)>& change) {
  sensor::Sample sample = test::example_sample(40);
  change(sample);
  return sample;
}
TruthFrame truth_with(const std::function<void(TruthFrame&)>& change) {
  TruthFrame truth = test::example_truth(40);
  change(truth);
  return truth;
}

INSTANTIATE_TEST_SUITE_P(
    All, TakeWriterRefuses,
    ::testing::Values(
        BadInput{"arrival_backwards", [](TakeWriter& w) { w.add_entry(host_ms(5), "udp", {}); },
                 "arrives before"},
        BadInput{"arrival_at_no_time", [](TakeWriter& w) { w.add_entry(HostTime::max(), "udp", {}); },
                 "at no time"},
        BadInput{"long_source", [](TakeWriter& w) { w.add_entry(host_ms(50), std::string(300, 'x'), {}); },
                 "source"},
        BadInput{
            "long_entry",
            [](TakeWriter& w) { w.add_entry(host_ms(50), "udp", std::vector<std::byte>((1U << 24U) + 1)); },
            "longer"},
        BadInput{
            "unknown_sensor",
            [](TakeWriter& w) { w.add_sample(32, host_ms(32), sample_with([](auto& s) { s.sensor = 2; })); },
            "the rig has 2"},
        BadInput{"nan_sample",
                 [](TakeWriter& w) {
                   w.add_sample(32, host_ms(32), sample_with([](auto& s) { s.values[3] = kNan; }));
                 },
                 "not finite"},
        BadInput{
            "too_many_values",
            [](TakeWriter& w) { w.add_sample(32, host_ms(32), sample_with([](auto& s) { s.count = 17; })); },
            "too many"},
        BadInput{"no_kind",
                 [](TakeWriter& w) {
                   w.add_sample(32, host_ms(32), sample_with([](auto& s) { s.kind = sensor::SampleKind{}; }));
                 },
                 "no kind"},
        BadInput{"sample_of_no_entry",
                 [](TakeWriter& w) { w.add_sample(33, host_ms(32), test::example_sample(33)); },
                 "of 32 entries"},
        BadInput{"sample_of_earlier_entry",
                 [](TakeWriter& w) { w.add_sample(31, host_ms(32), test::example_sample(33)); }, "entry 31"},
        BadInput{"tick_after_no_entry",
                 [](TakeWriter& w) {
                   w.add_tick({9, 33, host_ms(33), device_ms(9000)});
                 },
                 "tick 9"},
        BadInput{"tick_backwards",
                 [](TakeWriter& w) {
                   w.add_tick({2, 32, host_ms(33), device_ms(9000)});
                 },
                 "ascend"},
        BadInput{"tick_time_backwards",
                 [](TakeWriter& w) {
                   w.add_tick({9, 32, host_ms(33), device_ms(0)});
                 },
                 "ascend"},
        BadInput{"truth_backwards", [](TakeWriter& w) { w.add_truth(test::example_truth(1)); },
                 "does not come after"},
        BadInput{"nan_truth",
                 [](TakeWriter& w) { w.add_truth(truth_with([](auto& frame) { frame.weights[3] = kNan; })); },
                 "weight"},
        BadInput{"huge_truth",
                 [](TakeWriter& w) { w.add_truth(truth_with([](auto& frame) { frame.tongue_out = 101; })); },
                 "weight"},
        BadInput{"event_ends_first",
                 [](TakeWriter& w) {
                   w.add_event({"nod", device_ms(2), device_ms(1), ""});
                 },
                 "\"nod\" ends before"},
        BadInput{"calibration_backwards",
                 [](TakeWriter& w) {
                   w.add_calibration({3, device_ms(2), "imu", ""});
                   w.add_calibration({3, device_ms(2), "imu", ""});
                 },
                 "calibration 3"},
        BadInput{"sound_with_a_hole",
                 [](TakeWriter& w) { w.add_audio(8000, device_ms(100), std::vector<float>(8, 0.0F)); },
                 "sound begins"},
        BadInput{"sound_of_another_rate",
                 [](TakeWriter& w) { w.add_audio(16000, device_ms(1), std::vector<float>(8, 0.0F)); },
                 "16000 Hz"},
        BadInput{"nan_sound",
                 [](TakeWriter& w) { w.add_audio(8000, device_ms(1), std::vector<float>(8, kNan)); },
                 "not finite"},
        BadInput{"no_rate", [](TakeWriter& w) { w.add_audio(0, device_ms(1), std::vector<float>(8, 0.0F)); },
                 "1000"},
        BadInput{"note_of_no_text", [](TakeWriter& w) { w.add_note("key", "\xFF"); }, "UTF-8"},
        BadInput{"reserved_note", [](TakeWriter& w) { w.add_note("mien.finished", "yes"); }, "reserved"}),
    [](const auto& tested) { return tested.param.name; });

fs::perms mode_of(const fs::path& path) {
  return fs::status(path).permissions();
}

TEST(TakeWriter, WhatItWritesIsItsOwnersAlone) {
  const mien::test::Folder folder;
  const mode_t before = ::umask(022);
  const fs::perms own = fs::perms::owner_read | fs::perms::owner_write;
  {
    auto at_once = TakeWriter::create(folder / "a.mien", test::example_header(), false);
    ASSERT_TRUE(at_once);
    EXPECT_EQ(mode_of(folder / "a.mien"), own);
    auto later = TakeWriter::create(folder / "b.mien", test::example_header(), false, Appears::when_finished);
    ASSERT_TRUE(later);
    for (const std::string& file : folder.files()) EXPECT_EQ(mode_of(file), own) << file;
    ASSERT_TRUE(later->finish());
  }
  EXPECT_EQ(mode_of(folder / "b.mien"), own);
  // The file that a replaced take becomes is a new one.
  test::write_raw(folder / "c.mien", "old");
  EXPECT_NE(mode_of(folder / "c.mien"), own);
  ASSERT_TRUE(TakeWriter::create(folder / "c.mien", test::example_header(), true));
  EXPECT_EQ(mode_of(folder / "c.mien"), own);
  // A commit under way.
  auto database = open_for_writing((folder / "a.mien").string(), "a.mien");
  ASSERT_TRUE(database);
  ASSERT_TRUE(database->run("BEGIN IMMEDIATE;INSERT INTO note VALUES(99,'a','b')"));
  EXPECT_EQ(mode_of(folder / "a.mien-journal"), own);
  ASSERT_TRUE(database->run("ROLLBACK"));
  ::umask(before);
}

TEST(TakeWriter, RefusesAdditionsAfterTheEnd) {
  const mien::test::Folder folder;
  auto writer = TakeWriter::create(folder / "a.mien", test::example_header(), false);
  ASSERT_TRUE(writer);
  ASSERT_TRUE(writer->finish());
  EXPECT_TRUE(writer->finish());
  test::add_example(*writer, 1, host_ms(1));
  EXPECT_EQ(writer->status().error().code, ErrorCode::bad_usage);
  EXPECT_EQ(test::read_everything(folder / "a.mien"), "");
}

}  // namespace
}  // namespace mien::take::take_test
