#include "mien/media/sound_reader.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <numbers>
#include <string>
#include <vector>

extern "C" {
#include <libavformat/avformat.h>
}

#include "mien/core/files.h"
#include "mien/core/wav.h"
#include "mien/media/video_writer.h"
#include "tests/folder.h"

namespace mien::media::sound_reader_test {
namespace {

constexpr int kRateHz = 8'000;
/// When the sound of a film begins, s.
constexpr double kBurstS = 0.75;

/// Silence, then a tone.
Sound burst(std::uint32_t rate_hz, double seconds) {
  Sound sound{.rate_hz = rate_hz, .samples = {}};
  for (int i = 0; i < seconds * rate_hz; ++i) {
    const double time_s = static_cast<double>(i) / rate_hz;
    sound.samples.push_back(static_cast<float>(
        time_s < kBurstS ? 0 : 0.5 * std::sin(2 * std::numbers::pi * 800 * (time_s - kBurstS))));
  }
  return sound;
}

Result<std::vector<float>> all_of(SoundReader& reader) {
  std::vector<float> samples;
  for (;;) {
    MIEN_TRY_ASSIGN(const auto piece, reader.next());
    if (!piece) return samples;
    samples.insert(samples.end(), piece->begin(), piece->end());
  }
}

/// When the tone is half as loud as it becomes, s.
double onset(const std::vector<float>& samples) {
  for (std::size_t i = 0; i < samples.size(); ++i)
    if (std::abs(samples[i]) > 0.25) return static_cast<double>(i) / kRateHz;
  return -1;
}

class SoundReaderTest : public testing::Test {
 protected:
  /// Of 30 pictures a second.
  [[nodiscard]] std::filesystem::path film(std::optional<Sound> sound, double seconds = 2) const {
    VideoOptions options;
    options.width = options.height = 32;
    options.sound = std::move(sound);
    auto writer = VideoWriter::create(folder_ / "film.mp4", options);
    EXPECT_TRUE(writer) << writer.error().message();
    const std::vector<std::uint8_t> grey(std::size_t{3} * 32 * 32, 100);
    for (int i = 0; i < 30 * seconds; ++i) EXPECT_TRUE(writer->add_frame(grey));
    EXPECT_TRUE(writer->finish());
    return folder_ / "film.mp4";
  }
  /// The film's streams as a QuickTime file with a time code, its sound later by so much.
  [[nodiscard]] std::filesystem::path as_mov(const std::filesystem::path& film, const char* timecode,
                                             double sound_later_s = 0) const {
    const auto path = folder_ / "film.mov";
    AVFormatContext *in = nullptr, *out = nullptr;
    EXPECT_EQ(avformat_open_input(&in, film.c_str(), nullptr, nullptr), 0);
    EXPECT_GE(avformat_find_stream_info(in, nullptr), 0);
    EXPECT_GE(avformat_alloc_output_context2(&out, nullptr, "mov", path.c_str()), 0);
    for (unsigned i = 0; i < in->nb_streams; ++i) {
      AVStream* stream = avformat_new_stream(out, nullptr);
      avcodec_parameters_copy(stream->codecpar, in->streams[i]->codecpar);
      stream->codecpar->codec_tag = 0;
      stream->time_base = in->streams[i]->time_base;
      stream->avg_frame_rate = in->streams[i]->avg_frame_rate;
      if (timecode != nullptr && stream->codecpar->codec_type == AVMEDIA_TYPE_VIDEO)
        av_dict_set(&stream->metadata, "timecode", timecode, 0);
    }
    EXPECT_GE(avio_open(&out->pb, path.c_str(), AVIO_FLAG_WRITE), 0);
    EXPECT_GE(avformat_write_header(out, nullptr), 0);
    AVPacket* packet = av_packet_alloc();
    while (av_read_frame(in, packet) >= 0) {
      const AVStream& from = *in->streams[packet->stream_index];
      av_packet_rescale_ts(packet, from.time_base, out->streams[packet->stream_index]->time_base);
      if (from.codecpar->codec_type == AVMEDIA_TYPE_AUDIO) {
        const auto later =
            std::llround(sound_later_s / av_q2d(out->streams[packet->stream_index]->time_base));
        packet->pts += later;
        packet->dts += later;
      }
      EXPECT_GE(av_interleaved_write_frame(out, packet), 0);
    }
    av_packet_free(&packet);
    EXPECT_EQ(av_write_trailer(out), 0);
    avio_closep(&out->pb);
    avformat_free_context(out);
    avformat_close_input(&in);
    return path;
  }
  mien::test::Folder folder_;
};

TEST_F(SoundReaderTest, GivesAFilmsSoundAtAnotherRateAndInTime) {
  auto reader = SoundReader::open(film(burst(44'100, 2)), kRateHz);
  ASSERT_TRUE(reader) << reader.error().message();
  EXPECT_FALSE(reader->start());
  const auto samples = all_of(*reader);
  ASSERT_TRUE(samples) << samples.error().message();
  EXPECT_NEAR(static_cast<double>(samples->size()) / kRateHz, 2, 0.05);
  EXPECT_NEAR(onset(*samples), kBurstS, 0.002);
  EXPECT_NEAR(*std::ranges::max_element(*samples), 0.5, 0.05);
  EXPECT_FALSE(reader->next().value()) << "it has ended";
}

TEST_F(SoundReaderTest, ReadsAWavToo) {
  for (const std::uint32_t rate_hz : {8'000U, 22'050U, 48'000U}) {
    ASSERT_TRUE(write_file(folder_ / "sound.wav", format_wav(burst(rate_hz, 3))));
    auto reader = SoundReader::open(folder_ / "sound.wav", kRateHz);
    ASSERT_TRUE(reader) << reader.error().message();
    const auto samples = all_of(*reader);
    ASSERT_TRUE(samples) << samples.error().message();
    EXPECT_NEAR(static_cast<double>(samples->size()), 3 * kRateHz, 2) << rate_hz;
    EXPECT_NEAR(onset(*samples), kBurstS, 0.0005) << rate_hz;
  }
}

TEST_F(SoundReaderTest, TellsTheTimeCodeOfAMovAndPutsItsSoundWhereItBelongs) {
  const auto plain = film(burst(48'000, 2));
  for (const double later_s : {0.0, 0.5}) {
    auto reader = SoundReader::open(as_mov(plain, "14:03:59:12", later_s), kRateHz);
    ASSERT_TRUE(reader) << reader.error().message();
    ASSERT_TRUE(reader->start());
    EXPECT_EQ(reader->start()->timecode, (face::Timecode{14, 3, 59, 12'000}));
    EXPECT_EQ(reader->start()->rate_hz, 30);
    const auto samples = all_of(*reader);
    ASSERT_TRUE(samples) << samples.error().message();
    EXPECT_NEAR(onset(*samples), kBurstS + later_s, 0.002);
  }
  auto without = SoundReader::open(as_mov(plain, nullptr), kRateHz);
  ASSERT_TRUE(without) << without.error().message();
  EXPECT_FALSE(without->start());
}

TEST_F(SoundReaderTest, RefusesWhatHasNoSoundAndWhatIsNoFilm) {
  EXPECT_EQ(SoundReader::open(folder_ / "none.mov", kRateHz).error().code, ErrorCode::not_found);
  EXPECT_EQ(SoundReader::open(folder_.path(), kRateHz).error().code, ErrorCode::not_found);
  const auto silent = SoundReader::open(film(std::nullopt), kRateHz);
  ASSERT_FALSE(silent);
  EXPECT_EQ(silent.error().code, ErrorCode::not_found);
  EXPECT_NE(silent.error().message().find("it has no sound"), std::string::npos);
  EXPECT_EQ(SoundReader::open(film(burst(8'000, 2)), 10).error().code, ErrorCode::bad_usage);
  ASSERT_TRUE(write_file(folder_ / "text.mov", std::string("no film at all")));
  EXPECT_EQ(SoundReader::open(folder_ / "text.mov", kRateHz).error().code, ErrorCode::malformed);
  // A playlist may name any file of this machine.
  ASSERT_TRUE(write_file(folder_ / "list.mov", "ffconcat version 1.0\nfile film.mp4\n"));
  EXPECT_EQ(SoundReader::open(folder_ / "list.mov", kRateHz).error().code, ErrorCode::malformed);
  ASSERT_TRUE(write_file(folder_ / "list.m3u8", "#EXTM3U\n#EXTINF:2,\nfilm.mp4\n#EXT-X-ENDLIST\n"));
  EXPECT_EQ(SoundReader::open(folder_ / "list.m3u8", kRateHz).error().code, ErrorCode::malformed);
}

TEST_F(SoundReaderTest, SurvivesAFilmCutOrChangedAnywhere) {
  for (const bool mov : {false, true}) {
    const auto whole = mov ? as_mov(film(burst(48'000, 2)), "14:03:59:12") : film(burst(48'000, 2));
    const auto bytes = read_file(whole).value();
    const auto read = [&](std::span<const std::byte> damaged) {
      const auto cut = folder_ / "cut.mov";
      ASSERT_TRUE(write_file(cut, damaged));
      auto reader = SoundReader::open(cut, kRateHz);
      if (!reader) return;
      const auto samples = all_of(*reader);
      EXPECT_TRUE(!samples || samples->size() <= SoundReader::kLongestS * kRateHz);
    };
    for (std::size_t share = 1; share < 20; ++share) read(std::span(bytes).first(bytes.size() * share / 20));
    for (std::size_t place = 0; place < 60; ++place) {
      auto changed = bytes;
      for (std::size_t i = 0; i < 8; ++i)
        changed[(place * bytes.size() / 60 + i * 3) % bytes.size()] ^= std::byte{0x55};
      read(changed);
    }
  }
}

}  // namespace
}  // namespace mien::media::sound_reader_test
