#include "mien/media/video_writer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "mien/core/files.h"
#include "tests/folder.h"

namespace mien::media::video_writer_test {
namespace {
namespace fs = std::filesystem;

class VideoWriterTest : public testing::Test {
 protected:
  static std::vector<std::uint8_t> frame(int i) {
    std::vector<std::uint8_t> rgb(64 * 48 * 3);
    for (std::size_t k = 0; k < rgb.size(); ++k)
      rgb[k] = static_cast<std::uint8_t>(k / 3 % 64 * 3 + static_cast<std::size_t>(i));
    return rgb;
  }
  static VideoOptions options() {
    VideoOptions o;
    o.width = 64;
    o.height = 48;
    return o;
  }
  static Sound tone(double seconds) {
    Sound sound{.rate_hz = 22050, .samples = {}};
    for (int i = 0; i < seconds * 22050; ++i)
      sound.samples.push_back(0.3F * static_cast<float>(std::sin(0.1 * i)));
    return sound;
  }
  [[nodiscard]] std::vector<std::byte> film(const std::string& name, const VideoOptions& how,
                                            int frames) const {
    auto writer = VideoWriter::create(folder_ / name, how);
    EXPECT_TRUE(writer.has_value()) << writer.error().message();
    for (int i = 0; i < frames; ++i) EXPECT_TRUE(writer->add_frame(frame(i)).has_value());
    const auto done = writer->finish();
    EXPECT_TRUE(done.has_value()) << done.error().message();
    return read_file(folder_ / name).value();
  }
  [[nodiscard]] std::size_t files() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(folder_.path()), fs::directory_iterator()));
  }
  mien::test::Folder folder_;
};

/// Where a four-letter box stands in an MP4; npos when it lacks it.
std::size_t find_box(const std::vector<std::byte>& file, std::string_view name) {
  return std::string_view(reinterpret_cast<const char*>(file.data()), file.size()).find(name);
}

TEST_F(VideoWriterTest, WritesAnMp4ThatStartsPlayingBeforeItIsWhole) {
  const auto file = film("a.mp4", options(), 20);
  EXPECT_EQ(find_box(file, "ftyp"), 4U);
  EXPECT_LT(find_box(file, "moov"), find_box(file, "mdat"));
  EXPECT_EQ(find_box(file, "mp4a"), std::string::npos);
  EXPECT_EQ(files(), 1U);
}

TEST_F(VideoWriterTest, CarriesSound) {
  VideoOptions how = options();
  how.sound = tone(0.5);
  const auto file = film("a.mp4", how, 20);
  EXPECT_NE(find_box(file, "mp4a"), std::string::npos);
  how.sound = Sound{};
  EXPECT_EQ(find_box(film("b.mp4", how, 20), "mp4a"), std::string::npos) << "no sound is no track";
}

TEST_F(VideoWriterTest, GivesTheSameBytesAgain) {
  VideoOptions how = options();
  how.sound = tone(1);
  EXPECT_EQ(film("a.mp4", how, 45), film("b.mp4", how, 45));
}

TEST_F(VideoWriterTest, LeavesNothingBehindWithoutAnEnd) {
  ASSERT_TRUE(write_file(folder_ / "a.mp4", std::string_view("the old film")).has_value());
  {
    auto writer = VideoWriter::create(folder_ / "a.mp4", options());
    ASSERT_TRUE(writer.has_value());
    ASSERT_TRUE(writer->add_frame(frame(0)).has_value());
  }
  EXPECT_EQ(read_text(folder_ / "a.mp4").value(), "the old film");
  EXPECT_EQ(files(), 1U);
}

TEST_F(VideoWriterTest, RefusesWhatIsNoFilm) {
  const auto code = [&](VideoOptions how) {
    return VideoWriter::create(folder_ / "a.mp4", std::move(how)).error().code;
  };
  VideoOptions how = options();
  how.width = 63;
  EXPECT_EQ(code(how), ErrorCode::bad_usage);
  how = options();
  how.height = 0;
  EXPECT_EQ(code(how), ErrorCode::bad_usage);
  how = options();
  how.rate_hz = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(code(how), ErrorCode::bad_usage);
  how = options();
  how.quality = 99;
  EXPECT_EQ(code(how), ErrorCode::bad_usage);
  auto writer = VideoWriter::create(folder_ / "a.mp4", options());
  ASSERT_TRUE(writer.has_value());
  EXPECT_EQ(writer->add_frame(std::vector<std::uint8_t>(5)).error().code, ErrorCode::mismatch);
  EXPECT_EQ(writer->finish().error().code, ErrorCode::bad_usage) << "no frames";
  EXPECT_EQ(VideoWriter::create("/nowhere/at/all.mp4", options()).error().code, ErrorCode::io);
}

}  // namespace
}  // namespace mien::media::video_writer_test
