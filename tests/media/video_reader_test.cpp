#include "mien/media/video_reader.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "mien/core/files.h"
#include "mien/media/video_writer.h"
#include "tests/folder.h"

namespace mien::media::video_reader_test {
namespace {

constexpr int kWidth = 64, kHeight = 48;

/// A bright left half, which grows brighter from frame to frame.
std::vector<std::uint8_t> frame(int i) {
  std::vector<std::uint8_t> rgb(std::size_t{3} * kWidth * kHeight, 30);
  for (std::size_t p = 0; p < rgb.size(); p += 3)
    if (p / 3 % kWidth < kWidth / 2)
      rgb[p] = rgb[p + 1] = rgb[p + 2] = static_cast<std::uint8_t>(100 + 10 * i);
  return rgb;
}

class VideoReaderTest : public testing::Test {
 protected:
  [[nodiscard]] std::filesystem::path film(int frames) const {
    VideoOptions options;
    options.width = kWidth;
    options.height = kHeight;
    auto writer = VideoWriter::create(folder_ / "film.mp4", options);
    EXPECT_TRUE(writer) << writer.error().message();
    for (int i = 0; i < frames; ++i) EXPECT_TRUE(writer->add_frame(frame(i)));
    EXPECT_TRUE(writer->finish());
    return folder_ / "film.mp4";
  }
  mien::test::Folder folder_;
};

TEST_F(VideoReaderTest, GivesEachPictureInGrey) {
  auto reader = VideoReader::open(film(12), 1280, 960);
  ASSERT_TRUE(reader) << reader.error().message();
  EXPECT_EQ(reader->width(), kWidth);
  EXPECT_EQ(reader->height(), kHeight);
  EXPECT_EQ(reader->about(), 12);
  for (int i = 0; i < 12; ++i) {
    const auto picture = reader->next();
    ASSERT_TRUE(picture) << picture.error().message();
    ASSERT_TRUE(*picture) << i;
    ASSERT_EQ((*picture)->size(), std::size_t{kWidth} * kHeight);
    EXPECT_NEAR((**picture)[10 * kWidth + 10], 100 + 10 * i, 6) << i;
    EXPECT_NEAR((**picture)[10 * kWidth + 54], 30, 6) << i;
  }
  EXPECT_FALSE(reader->next().value()) << "it has ended";
  EXPECT_FALSE(reader->next().value());
}

TEST_F(VideoReaderTest, MakesLargePicturesSmallerAndKeepsTheirShape) {
  auto reader = VideoReader::open(film(2), 32, 960);
  ASSERT_TRUE(reader) << reader.error().message();
  EXPECT_EQ(reader->width(), 32);
  EXPECT_EQ(reader->height(), 24);
  const auto picture = reader->next();
  ASSERT_TRUE(picture && *picture);
  EXPECT_NEAR((**picture)[5 * 32 + 5], 100, 6);
}

TEST_F(VideoReaderTest, RefusesWhatIsNoFilm) {
  EXPECT_EQ(VideoReader::open(folder_ / "none.mp4", 100, 100).error().code, ErrorCode::not_found);
  EXPECT_EQ(VideoReader::open(folder_.path(), 100, 100).error().code, ErrorCode::not_found);
  ASSERT_TRUE(write_file(folder_ / "text.mp4", std::string("no film at all")));
  EXPECT_EQ(VideoReader::open(folder_ / "text.mp4", 100, 100).error().code, ErrorCode::malformed);
  const auto whole = film(3);
  // A playlist may name any file of this machine.
  ASSERT_TRUE(write_file(folder_ / "list.mp4", "ffconcat version 1.0\nfile film.mp4\n"));
  EXPECT_EQ(VideoReader::open(folder_ / "list.mp4", 100, 100).error().code, ErrorCode::malformed);
}

TEST_F(VideoReaderTest, SurvivesAFilmCutAnywhere) {
  const auto bytes = read_file(film(10)).value();
  for (std::size_t share = 1; share < 20; ++share) {
    const auto cut = folder_ / "cut.mp4";
    ASSERT_TRUE(write_file(cut, std::span(bytes).first(bytes.size() * share / 20)));
    auto reader = VideoReader::open(cut, 1280, 960);
    for (int i = 0; reader && i < 20; ++i) {
      const auto picture = reader->next();
      if (!picture || !*picture) break;
    }
  }
}

}  // namespace
}  // namespace mien::media::video_reader_test
