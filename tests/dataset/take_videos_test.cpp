#include "mien/dataset/take_videos.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/folder.h"

namespace mien::dataset::take_videos_test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(TakeVideos, AreThoseOfItsNameInTheirOrder) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  const auto write = [&folder](const char* name, std::size_t bytes) {
    std::ofstream(folder / name) << std::string(bytes, 'x');
  };
  EXPECT_THAT(videos_beside(folder / "anna.mien"), IsEmpty());
  write("anna.mien", 1);
  write("anna.webm", 1'000'000);
  write("anna_3.mp4", 500'000);  // One was deleted.
  write("anna_10.webm", 2);
  write("anna_2.mien", 1);  // Another take, of the same second.
  write("anna_2.webm", 7);
  write("anna_1.webm", 7);
  write("anna_x.webm", 7);
  write("berta.webm", 7);
  std::filesystem::create_directory(folder / "anna_4.webm");
  std::vector<std::string> names;
  const std::vector<TakeVideo> videos = videos_beside(folder / "anna.mien");
  for (const TakeVideo& video : videos) names.push_back(video.file);
  EXPECT_THAT(names, ElementsAre("anna.webm", "anna_3.mp4", "anna_10.webm"));
  EXPECT_NEAR(megabytes_of(videos), 1.5, 0.001);
  ASSERT_EQ(videos_beside(folder / "anna_2.mien").size(), 1U);
  EXPECT_EQ(videos_beside(folder / "anna_2.mien").front().bytes, 7U);
}

}  // namespace
}  // namespace mien::dataset::take_videos_test
