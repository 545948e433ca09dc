#include "mien/live/video_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string_view>

#include "tests/folder.h"

namespace mien::live::video_writer_test {
namespace {

using ::testing::HasSubstr;

std::span<const std::byte> bytes_of(std::string_view text) {
  return std::as_bytes(std::span(text));
}
std::string read(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(VideoWriter, WritesBesideTheTakeAndReplacesNothing) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  VideoWriter writer(0);
  writer.open(1, folder / "anna.mien", VideoContainer::webm);
  EXPECT_TRUE(writer.append(1, bytes_of("one")));
  EXPECT_TRUE(writer.append(1, bytes_of("two")));
  EXPECT_TRUE(writer.append(7, bytes_of("of no video")));
  writer.wait();
  EXPECT_EQ(read(folder / "anna.webm"), "onetwo") << "it is there while it goes on, should the program not";
  EXPECT_EQ(writer.bytes(), 6U);
  const auto rights = std::filesystem::status(folder / "anna.webm").permissions();
  EXPECT_EQ(rights, std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  writer.close(1);
  writer.open(2, folder / "anna.mien", VideoContainer::mp4);
  EXPECT_TRUE(writer.append(2, bytes_of("three")));
  writer.close(2);
  writer.open(3, folder / "anna.mien", VideoContainer::webm);
  EXPECT_TRUE(writer.append(3, bytes_of("four")));
  writer.close(3);
  writer.wait();
  EXPECT_EQ(read(folder / "anna.webm"), "onetwo");
  EXPECT_EQ(read(folder / "anna_2.mp4"), "three") << "the number is the video's, whatever its container";
  EXPECT_EQ(read(folder / "anna_3.webm"), "four");
  const auto reports = writer.take_reports();
  ASSERT_EQ(reports.size(), 6U);
  EXPECT_EQ(reports[0].video, 1U);
  EXPECT_EQ(reports[0].file, folder / "anna.webm");
  EXPECT_FALSE(reports[0].closed);
  EXPECT_TRUE(reports[1].closed);
  EXPECT_EQ(reports[1].bytes, 6U);
  EXPECT_EQ(reports[5].file, folder / "anna_3.webm");
  EXPECT_TRUE(writer.take_reports().empty());
}

TEST(VideoWriter, LeavesTheTakeItsRoomAndNoEmptyFile) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  VideoWriter writer(std::uint64_t{1} << 60U);  // No disk has so much left.
  writer.open(1, folder / "anna.mien", VideoContainer::webm);
  EXPECT_TRUE(writer.append(1, bytes_of("one")));
  EXPECT_TRUE(writer.append(1, bytes_of("two")));
  writer.close(1);
  writer.wait();
  const auto reports = writer.take_reports();
  ASSERT_EQ(reports.size(), 3U) << "it is said once";
  EXPECT_THAT(reports[1].error, HasSubstr("left on the disk, which the take needs"));
  EXPECT_TRUE(reports[2].closed);
  EXPECT_TRUE(folder.files().empty());
}

TEST(VideoWriter, SaysWhatCannotBeMade) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  VideoWriter writer(0);
  writer.open(1, folder / "no" / "anna.mien", VideoContainer::webm);
  EXPECT_TRUE(writer.append(1, bytes_of("one")));
  writer.close(1);
  writer.wait();
  const auto reports = writer.take_reports();
  ASSERT_EQ(reports.size(), 2U);
  EXPECT_THAT(reports[0].error, HasSubstr("cannot be made"));
  EXPECT_TRUE(reports[0].file.empty());
}

TEST(VideoWriter, WhatWasHandedOverIsWrittenBeforeItEnds) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  const std::string chunk(100'000, 'x');
  {
    VideoWriter writer(0);
    writer.open(1, folder / "anna.mien", VideoContainer::mp4);
    for (int i = 0; i < 50; ++i) EXPECT_TRUE(writer.append(1, bytes_of(chunk)));
  }
  EXPECT_EQ(std::filesystem::file_size(folder / "anna.mp4"), 50 * chunk.size());
}

}  // namespace
}  // namespace mien::live::video_writer_test
