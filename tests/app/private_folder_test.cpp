#include "app/private_folder.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "tests/app/program.h"

namespace mien::app::test::private_folder_test {
namespace {

namespace fs = std::filesystem;

TEST(PrivateFolder, WhatIsMadeIsItsOwnersAloneAndWhatIsThereStays) {
  const Folder folder;
  const mode_t before = ::umask(022);
  ASSERT_TRUE(fs::create_directory(folder / "open"));
  for (const char* name : {"open/made", "open/deep/deeper", "open/slash/", "open/deep/.."}) {
    const auto made = make_private_folders(folder / name);
    EXPECT_TRUE(made) << made.error().message();
  }
  EXPECT_EQ(fs::status(folder / "open").permissions(), static_cast<fs::perms>(0755));
  for (const char* name : {"open/made", "open/deep", "open/deep/deeper", "open/slash"})
    EXPECT_EQ(fs::status(folder / name).permissions(), fs::perms::owner_all) << name;
  ::umask(before);
}

TEST(PrivateFolder, WhatCannotBeMadeIsTold) {
  const Folder folder;
  write(folder / "file", "");
  for (const std::string& name : {folder / "file", folder / "file/in", std::string()}) {
    const auto made = make_private_folders(name);
    ASSERT_FALSE(made) << name;
    EXPECT_EQ(made.error().code, ErrorCode::io);
    EXPECT_EQ(made.error().where, name);
  }
}

}  // namespace
}  // namespace mien::app::test::private_folder_test
