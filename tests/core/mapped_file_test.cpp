#include "mien/core/mapped_file.h"

#include <gtest/gtest.h>

#include <fstream>
#include <utility>

#include "tests/folder.h"

namespace mien::core::mapped_file_test {
namespace {

TEST(MappedFile, HoldsAFilesBytes) {
  const mien::test::Folder folder;
  std::ofstream(folder / "a") << "bytes";
  auto opened = MappedFile::open(folder / "a");
  ASSERT_TRUE(opened) << opened.error().message();
  const MappedFile moved = std::move(*opened);
  ASSERT_EQ(moved.bytes().size(), 5u);
  EXPECT_EQ(moved.bytes()[4], std::byte{'s'});
}

TEST(MappedFile, RefusesWhatCannotBeMapped) {
  const mien::test::Folder folder;
  const auto missing = MappedFile::open(folder / "none");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::not_found);
  std::ofstream(folder / "empty");
  for (const auto& path : {folder / "empty", folder.path()}) {
    const auto refused = MappedFile::open(path);
    ASSERT_FALSE(refused) << path;
    EXPECT_EQ(refused.error().code, ErrorCode::io);
  }
}

}  // namespace
}  // namespace mien::core::mapped_file_test
