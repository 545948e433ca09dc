#include "mien/media/sound_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

extern "C" {
#include <libavutil/channel_layout.h>
#include <libavutil/samplefmt.h>
#include <libswresample/swresample.h>
}

#include "mien/media/film_file.h"

namespace mien::media {
namespace fs = std::filesystem;
namespace {

constexpr const char* kSoundFormats = "mov,mp4,m4a,3gp,3g2,mj2,matroska,webm,avi,mpegts,mpeg,wav";
constexpr int kLeastRate_hz = 1'000, kMostRate_hz = 192'000;
/// Packets of other streams, or without sound, before a film is given up: an hour of pictures may come first.
constexpr int kMostWithoutSound = 1'000'000;
/// Where the sound is said to go on differs from where it is by no more than rounding, s.
constexpr double kJoins_s = 0.01;
/// Samples that a frame may become at once: ten seconds at the highest rate.
constexpr int kMostAtOnce = 10 * kMostRate_hz;

struct CloseResampler {
  void operator()(SwrContext* p) const { swr_free(&p); }
};

/// Of the film's own track, or of its pictures', which name it.
std::optional<FilmStart> start_of(const AVFormatContext& film) {
  const AVDictionaryEntry* told = av_dict_get(film.metadata, "timecode", nullptr, 0);
  double rate_hz = 0;
  for (unsigned i = 0; i < film.nb_streams; ++i) {
    const AVStream& stream = *film.streams[i];
    if (told == nullptr) told = av_dict_get(stream.metadata, "timecode", nullptr, 0);
    if (stream.codecpar->codec_type == AVMEDIA_TYPE_VIDEO && rate_hz == 0)
      rate_hz = std::round(av_q2d(stream.avg_frame_rate));
  }
  if (told == nullptr) return std::nullopt;
  const auto timecode = face::parse_timecode(told->value);
  if (!timecode || !(rate_hz >= 1 && rate_hz <= 240) || timecode->frame_milli >= 1000 * rate_hz)
    return std::nullopt;
  return FilmStart{*timecode, rate_hz};
}

/// The planes of a frame from a sample on.
std::array<const std::uint8_t*, SoundReader::kMostChannels> planes_from(const AVFrame& frame, int sample) {
  const auto format = static_cast<AVSampleFormat>(frame.format);
  const int planes = av_sample_fmt_is_planar(format) != 0 ? frame.ch_layout.nb_channels : 1;
  const int step = av_get_bytes_per_sample(format) * (planes == 1 ? frame.ch_layout.nb_channels : 1);
  std::array<const std::uint8_t*, SoundReader::kMostChannels> out{};
  for (int p = 0; p < planes; ++p)
    out[static_cast<std::size_t>(p)] = frame.extended_data[p] + std::ptrdiff_t{step} * sample;
  return out;
}

}  // namespace

struct SoundReader::State : FilmFile {
  explicit State(int asked_hz)
      : FilmFile{"its sound", "sound", "convert it to MP4 or WAV", kMostWithoutSound}, rate_hz(asked_hz) {}

  int rate_hz;
  std::unique_ptr<SwrContext, CloseResampler> converter;
  HeldFilm<AVFrame> silent;  // A tenth of a second.
  std::optional<FilmStart> film_start;
  double begin_s = 0;      // The film's time 0, on its streams' clocks.
  std::int64_t taken = 0;  // Samples that the converter was given, as the film has them, silence too.
  std::vector<float> out;
  bool over = false;

  /// By the first frame: how its sound becomes ours, and what silence is.
  Result<void> begin() {
    const int from_hz = frame->sample_rate, channels = frame->ch_layout.nb_channels;
    if (from_hz < kLeastRate_hz || from_hz > kMostRate_hz || channels < 1 || channels > kMostChannels)
      return refused(ErrorCode::out_of_range,
                     fmt::format("its sound has {} channels of {} Hz", channels, from_hz));
    AVChannelLayout mono{}, known{};
    av_channel_layout_default(&mono, 1);
    // Which channel is which may not be told; a mean needs to know.
    if (frame->ch_layout.order == AV_CHANNEL_ORDER_UNSPEC)
      av_channel_layout_default(&known, channels);
    else
      av_channel_layout_copy(&known, &frame->ch_layout);
    SwrContext* made = nullptr;
    const int set = swr_alloc_set_opts2(&made, &mono, AV_SAMPLE_FMT_FLT, rate_hz, &known,
                                        static_cast<AVSampleFormat>(frame->format), from_hz, 0, nullptr);
    av_channel_layout_uninit(&known);
    converter.reset(made);
    if (set < 0 || swr_init(converter.get()) < 0)
      return refused(ErrorCode::unsupported, "its sound cannot be converted");
    silent.reset(av_frame_alloc());
    silent->format = frame->format;
    silent->nb_samples = from_hz / 10;
    silent->sample_rate = from_hz;
    av_channel_layout_copy(&silent->ch_layout, &frame->ch_layout);
    if (av_frame_get_buffer(silent.get(), 0) < 0 ||
        av_samples_set_silence(silent->extended_data, 0, silent->nb_samples, channels,
                               static_cast<AVSampleFormat>(frame->format)) < 0)
      return refused(ErrorCode::io, "no memory for its sound");
    return {};
  }

  /// Appends what the converter makes of so many samples; of null, what it still holds.
  Result<void> convert(const std::uint8_t** data, int samples) {
    taken += samples;
    if (static_cast<double>(taken) > kLongestS * silent->sample_rate)
      return refused(ErrorCode::out_of_range,
                     fmt::format("it is longer than {:.0f} hours", kLongestS / 3600));
    const int most = swr_get_out_samples(converter.get(), samples);
    if (most < 0 || most > kMostAtOnce)
      return refused(ErrorCode::malformed, "a piece of its sound is too long");
    const std::size_t before = out.size();
    out.resize(before + static_cast<std::size_t>(most));
    auto* into = reinterpret_cast<std::uint8_t*>(out.data() + before);
    const int made = swr_convert(converter.get(), &into, most, data, samples);
    if (made < 0)
      return refused(ErrorCode::malformed, "its sound cannot be converted: " + ffmpeg_words(made));
    out.resize(before + static_cast<std::size_t>(made));
    return {};
  }

  /// The frame where it belongs: after silence, or without what was heard already.
  Result<void> place() {
    const AVFrame& now = *frame;
    if (now.sample_rate != silent->sample_rate || now.format != silent->format ||
        now.ch_layout.nb_channels != silent->ch_layout.nb_channels)
      return refused(ErrorCode::mismatch, "its sound changes its rate or its channels");
    int skipped = 0;
    if (now.best_effort_timestamp != AV_NOPTS_VALUE) {
      const double time_s =
          static_cast<double>(now.best_effort_timestamp) * av_q2d(file->streams[stream]->time_base) - begin_s;
      const double from_hz = now.sample_rate;
      if (!(std::abs(time_s) < 2 * kLongestS))
        return refused(ErrorCode::out_of_range,
                       fmt::format("it is longer than {:.0f} hours", kLongestS / 3600));
      std::int64_t gap = std::llround(time_s * from_hz) - taken;
      if (taken > 0 && std::abs(static_cast<double>(gap)) <= kJoins_s * from_hz) gap = 0;
      for (; gap > 0; gap -= std::min<std::int64_t>(gap, silent->nb_samples))
        MIEN_TRY(convert(planes_from(*silent, 0).data(),
                         static_cast<int>(std::min<std::int64_t>(gap, silent->nb_samples))));
      skipped = static_cast<int>(std::min<std::int64_t>(-gap, now.nb_samples));
    }
    if (skipped == now.nb_samples) return {};
    return convert(planes_from(now, skipped).data(), now.nb_samples - skipped);
  }
};

SoundReader::SoundReader(std::unique_ptr<State> state) : state_(std::move(state)) {}
SoundReader::SoundReader(SoundReader&&) noexcept = default;
SoundReader& SoundReader::operator=(SoundReader&&) noexcept = default;
SoundReader::~SoundReader() = default;

Result<SoundReader> SoundReader::open(const fs::path& path, int rate_hz) {
  auto state = std::make_unique<State>(rate_hz);
  if (rate_hz < kLeastRate_hz || rate_hz > kMostRate_hz)
    return fail(ErrorCode::bad_usage, fmt::format("{} samples a second", rate_hz), path.string(),
                fmt::format("choose {} to {}", kLeastRate_hz, kMostRate_hz));
  MIEN_TRY(state->open(path, kSoundFormats));
  AVFormatContext* const opened = state->file.get();
  const AVCodec* codec = nullptr;
  state->stream = av_find_best_stream(opened, AVMEDIA_TYPE_AUDIO, -1, -1, &codec, 0);
  if (state->stream == AVERROR_DECODER_NOT_FOUND)
    return state->refused(ErrorCode::unsupported, "it has no sound that this machine's FFmpeg reads");
  if (state->stream < 0 || codec == nullptr)
    return fail(ErrorCode::not_found, "it has no sound", path.string());
  state->film_start = start_of(*opened);
  const AVStream* clock = opened->streams[state->stream];
  for (unsigned i = 0; i < opened->nb_streams; ++i) {
    AVStream& other = *opened->streams[i];
    if (static_cast<int>(i) == state->stream) continue;
    other.discard = AVDISCARD_ALL;
    // The first picture is the film's time 0; a cover is none.
    if (other.codecpar->codec_type == AVMEDIA_TYPE_VIDEO && clock == opened->streams[state->stream] &&
        (other.disposition & AV_DISPOSITION_ATTACHED_PIC) == 0)
      clock = &other;
  }
  if (clock->start_time != AV_NOPTS_VALUE)
    state->begin_s = static_cast<double>(clock->start_time) * av_q2d(clock->time_base);
  MIEN_TRY(state->start(codec));
  return SoundReader(std::move(state));
}

const std::optional<FilmStart>& SoundReader::start() const {
  return state_->film_start;
}

Result<std::optional<std::span<const float>>> SoundReader::next() {
  State& s = *state_;
  s.out.clear();
  while (s.out.empty() && !s.over) {
    MIEN_TRY_ASSIGN(const bool more, s.decode());
    if (more) {
      if (!s.converter) MIEN_TRY(s.begin());
      MIEN_TRY(s.place());
    } else {
      s.over = true;
      if (s.converter) MIEN_TRY(s.convert(nullptr, 0));
    }
  }
  if (s.out.empty()) return std::nullopt;
  return std::span<const float>(s.out);
}

}  // namespace mien::media
