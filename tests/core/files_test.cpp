#include "mien/core/files.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>

#include "tests/folder.h"

namespace mien::files_test {
namespace {

namespace fs = std::filesystem;

class Files : public testing::Test {
 protected:
  [[nodiscard]] std::size_t entries() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(folder_.path()), fs::directory_iterator()));
  }

  mien::test::Folder folder_;
};

TEST_F(Files, WrittenIsRead) {
  const std::string text("a\r\nb\0c", 6);
  ASSERT_TRUE(write_file(folder_ / "a.txt", text));
  EXPECT_EQ(read_text(folder_ / "a.txt").value(), text);
  EXPECT_EQ(read_file(folder_ / "a.txt").value().size(), 6U);
  EXPECT_EQ(entries(), 1U);  // Nothing half-written beside it.
}

TEST_F(Files, EmptyIsAFileToo) {
  ASSERT_TRUE(write_file(folder_ / "empty", std::string_view()));
  EXPECT_EQ(read_text(folder_ / "empty").value(), "");
}

TEST_F(Files, LargerThanOneReadIsReadWhole) {
  std::string text(std::size_t{3} << 20U, 'm');
  text.back() = 'n';
  ASSERT_TRUE(write_file(folder_ / "large", text));
  EXPECT_EQ(read_text(folder_ / "large").value(), text);
}

TEST_F(Files, TooLargeIsRefused) {
  ASSERT_TRUE(write_file(folder_ / "eleven", std::string_view("eleven byte")));
  EXPECT_EQ(read_text(folder_ / "eleven", 11).value().size(), 11U);
  const auto refused = read_text(folder_ / "eleven", 10);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::out_of_range);
  EXPECT_EQ(refused.error().where, (folder_ / "eleven").string());
}

TEST_F(Files, MissingAndFolderAreTold) {
  EXPECT_EQ(read_file(folder_ / "none").error().code, ErrorCode::not_found);
  EXPECT_EQ(read_file(folder_.path()).error().code, ErrorCode::bad_usage);
  EXPECT_EQ(write_file(folder_.path(), std::string_view("x")).error().code, ErrorCode::bad_usage);
  EXPECT_EQ(write_file(folder_ / "none" / "a", std::string_view("x")).error().code, ErrorCode::not_found);
  EXPECT_EQ(entries(), 0U);
}

TEST_F(Files, AnEndlessSourceIsRefusedAtItsLimit) {
  if (!fs::exists("/dev/zero")) GTEST_SKIP() << "there is no /dev/zero here";
  EXPECT_EQ(read_file("/dev/zero", 4096).error().code, ErrorCode::out_of_range);
}

TEST_F(Files, OldContentIsReplacedWhole) {
  ASSERT_TRUE(write_file(folder_ / "a", std::string_view("the old and longer content")));
  // Whoever has the old one open goes on reading the old one.
  std::ifstream old(folder_ / "a");
  ASSERT_TRUE(write_file(folder_ / "a", std::string_view("new")));
  std::string line;
  std::getline(old, line);
  EXPECT_EQ(line, "the old and longer content");
  EXPECT_EQ(read_text(folder_ / "a").value(), "new");
  EXPECT_EQ(entries(), 1U);
}

TEST_F(Files, ALinkStaysALink) {
  ASSERT_TRUE(write_file(folder_ / "target", std::string_view("old")));
  fs::create_symlink("target", folder_ / "link");
  ASSERT_TRUE(write_file(folder_ / "link", std::string_view("new")));
  EXPECT_TRUE(fs::is_symlink(folder_ / "link"));
  EXPECT_EQ(read_text(folder_ / "target").value(), "new");
}

TEST_F(Files, APipeStaysAPipe) {
  const fs::path pipe = folder_ / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const int reader = ::open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  ASSERT_TRUE(write_file(pipe, std::string_view("through")));
  std::array<char, 16> got{};
  EXPECT_EQ(::read(reader, got.data(), got.size()), 7);
  EXPECT_EQ(std::string(got.data()), "through");
  ::close(reader);
  EXPECT_TRUE(fs::is_fifo(pipe));
}

TEST_F(Files, TheUmaskHolds) {
  const mode_t before = ::umask(0027);
  const auto written = write_file(folder_ / "a", std::string_view("x"));
  ::umask(before);
  ASSERT_TRUE(written);
  EXPECT_EQ(fs::status(folder_ / "a").permissions(), static_cast<fs::perms>(0640));
}

TEST_F(Files, AFullDiskIsToldAndLeavesNothing) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "there is no /dev/full here";
  const auto written = write_file("/dev/full", std::string_view("x"));
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, ErrorCode::io);
}

TEST(FindResource, FindsTheProjectsOwnPartsFromABuildFolder) {
  const auto rig = find_resource("rigs/default.toml");
  ASSERT_TRUE(rig) << rig.error().message();
  EXPECT_TRUE(fs::exists(*rig));
}

TEST(FindResource, SaysWhatIsMissing) {
  const auto none = find_resource("no/such/part");
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, ErrorCode::not_found);
  EXPECT_NE(none.error().message().find("no/such/part"), std::string::npos);
}

}  // namespace
}  // namespace mien::files_test
