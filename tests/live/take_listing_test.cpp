#include "mien/live/take_listing.h"

#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <fstream>

#include "mien/take/take.h"
#include "tests/folder.h"
#include "tests/take/example_take.h"

namespace mien::live::take_listing_test {
namespace {

using Entries = std::vector<TakeListing::Entry>;

/// A finished take of so many frames.
void write_take(const std::filesystem::path& path, int frames) {
  auto writer = take::TakeWriter::create(path, take::test::example_header(), false);
  ASSERT_TRUE(writer) << writer.error().message();
  for (int i = 0; i < frames; ++i)
    writer->add_tick({i, 0, HostTime(frame_offset(i)), DeviceTime(frame_offset(i))});
  ASSERT_TRUE(writer->finish());
}

/// A listing, and how often its lengths have been read.
struct Stage {
  explicit Stage(std::filesystem::path folder)
      : listing(std::move(folder), [this] {
          ++read;
          read.notify_all();
        }) {}
  /// What list() gives when all lengths it wants have been read.
  Entries settled() {
    const int before = read;
    Entries entries = listing.list({}, true);
    read.wait(before);
    return listing.list({}, false);
  }
  std::atomic<int> read = 0;
  TakeListing listing;
};

TEST(TakeListing, TellsHowLongATakeIsOnceItHasBeenRead) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  write_take(folder / "one.mien", 121);
  std::ofstream(folder / "broken.mien") << "no take";
  std::ofstream(folder / "notes.txt") << "not listed";
  Stage stage(folder.path());
  const Entries entries = stage.settled();
  ASSERT_EQ(entries.size(), 2u);
  for (const auto& entry : entries) {
    EXPECT_GT(entry.megabytes, 0);
    if (entry.name == "one.mien") {
      EXPECT_NEAR(entry.seconds.value_or(-1), 2, 1e-6);
      EXPECT_EQ(entry.error, "");
    } else {
      EXPECT_FALSE(entry.seconds);
      EXPECT_NE(entry.error.find("broken.mien"), std::string::npos) << entry.error;
    }
  }
}

TEST(TakeListing, ReadsATakeAnewWhenItsFileIsAnother) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  const std::filesystem::path path = folder / "one.mien";
  write_take(path, 61);
  Stage stage(folder.path());
  EXPECT_NEAR(stage.settled().at(0).seconds.value_or(-1), 1, 1e-6);
  const int read = stage.read;
  EXPECT_NEAR(stage.listing.list({}, true).at(0).seconds.value_or(-1), 1, 1e-6);
  EXPECT_EQ(stage.read, read) << "what was read is kept";

  std::filesystem::remove(path);
  write_take(path, 601);
  EXPECT_NEAR(stage.settled().at(0).seconds.value_or(-1), 10, 1e-6);
  std::filesystem::remove(path);
  EXPECT_TRUE(stage.listing.list({}, true).empty());
}

TEST(TakeListing, NeverOpensATakeThatGrows) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  std::ofstream(folder / "growing.mien") << "half a take";
  write_take(folder / "one.mien", 61);
  Stage stage(folder.path());
  const TakeListing::Growing growing{folder / "growing.mien", 7};
  static_cast<void>(stage.listing.list(growing, true));
  stage.read.wait(0);
  for (const TakeListing::Entry& entry : stage.listing.list(growing, false)) {
    EXPECT_EQ(entry.error, "");
    EXPECT_NEAR(entry.seconds.value_or(-1), entry.name == "growing.mien" ? 7 : 1, 1e-6);
  }
}

TEST(TakeListing, WhatWasReadAsksForNoMoreToBeRead) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  write_take(folder / "one.mien", 61);
  Stage stage(folder.path());
  ASSERT_EQ(stage.settled().size(), 1u);
  // Somebody else's recording: another file at each look.
  std::filesystem::remove(folder / "one.mien");
  write_take(folder / "one.mien", 601);
  EXPECT_FALSE(stage.listing.list({}, false).at(0).seconds);
  EXPECT_NEAR(stage.settled().at(0).seconds.value_or(-1), 10, 1e-6);
  EXPECT_EQ(stage.read, 2);
}

TEST(TakeListing, TheNewestComeFirstAndNoMoreThanTheLimit) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  const auto now = std::filesystem::file_time_type::clock::now();
  for (std::size_t i = 0; i < TakeListing::kMaxTakes + 2; ++i) {
    const std::filesystem::path path = folder / (std::to_string(i) + ".mien");
    std::ofstream(path) << "x";
    std::filesystem::last_write_time(path, now - std::chrono::seconds(i));
  }
  Stage stage(folder.path());
  const Entries entries = stage.listing.list({}, true);
  ASSERT_EQ(entries.size(), TakeListing::kMaxTakes);
  EXPECT_EQ(entries.front().name, "0.mien");
  EXPECT_EQ(entries.back().name, std::to_string(TakeListing::kMaxTakes - 1) + ".mien");
}

TEST(TakeListing, AFolderThatIsNotThereHasNone) {
  TakeListing listing("/nowhere/at/all", [] {});
  EXPECT_TRUE(listing.list({}, true).empty());
}

}  // namespace
}  // namespace mien::live::take_listing_test
