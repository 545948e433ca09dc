#include "mien/study/media/sound_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/channel_layout.h>
#include <libavutil/samplefmt.h>
#include <libswresample/swresample.h>
}

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

struct CloseSound {
  void operator()(AVFormatContext* p) const { avformat_close_input(&p); }
  void operator()(AVCodecContext* p) const { avcodec_free_context(&p); }
  void operator()(AVFrame* p) const { av_frame_free(&p); }
  void operator()(AVPacket* p) const { av_packet_free(&p); }
  void operator()(SwrContext* p) const { swr_free(&p); }
};
template <class T>
using HeldSound = std::unique_ptr<T, CloseSound>;

std::string said(int code) {
  std::array<char, AV_ERROR_MAX_STRING_SIZE> text{};
  av_strerror(code, text.data(), text.size());
  return text.data();
}

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

struct SoundReader::State {
  std::string path;
  int rate_hz = 0;
  HeldSound<AVFormatContext> file;
  HeldSound<AVCodecContext> decoder;
  HeldSound<AVFrame> frame{av_frame_alloc()};
  HeldSound<AVPacket> packet{av_packet_alloc()};
  HeldSound<SwrContext> converter;
  HeldSound<AVFrame> silent;  // A tenth of a second.
  int stream = -1;
  std::optional<FilmStart> start;
  double begin_s = 0;      // The film's time 0, on its streams' clocks.
  std::int64_t taken = 0;  // Samples that the converter was given, as the film has them, silence too.
  std::vector<float> out;
  bool drained = false, over = false;

  [[nodiscard]] std::unexpected<Error> refused(ErrorCode code, std::string what) const {
    return fail(code, std::move(what), path, "convert it to MP4 or WAV");
  }

  /// Fills the decoder until it has sound. False: there is no more.
  Result<bool> decode() {
    for (int without = 0; without < kMostWithoutSound; ++without) {
      const int got = avcodec_receive_frame(decoder.get(), frame.get());
      if (got == 0) return true;
      if (got == AVERROR_EOF) return false;
      if (got != AVERROR(EAGAIN))
        return refused(ErrorCode::malformed, "its sound does not decode: " + said(got));
      if (drained) return false;
      const int read = av_read_frame(file.get(), packet.get());
      if (read < 0) {
        if (read != AVERROR_EOF) return refused(ErrorCode::malformed, "it breaks off: " + said(read));
        drained = true;
        avcodec_send_packet(decoder.get(), nullptr);
        continue;
      }
      const int sent = packet->stream_index == stream ? avcodec_send_packet(decoder.get(), packet.get()) : 0;
      av_packet_unref(packet.get());
      if (sent < 0) return refused(ErrorCode::malformed, "its sound does not decode: " + said(sent));
    }
    return refused(ErrorCode::malformed, "it goes on without sound");
  }

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
    if (made < 0) return refused(ErrorCode::malformed, "its sound cannot be converted: " + said(made));
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
  auto state = std::make_unique<State>();
  state->path = path.string();
  state->rate_hz = rate_hz;
  if (rate_hz < kLeastRate_hz || rate_hz > kMostRate_hz)
    return fail(ErrorCode::bad_usage, fmt::format("{} samples a second", rate_hz), path.string(),
                fmt::format("choose {} to {}", kLeastRate_hz, kMostRate_hz));
  std::error_code ignored;
  if (!fs::is_regular_file(path, ignored))
    return fail(ErrorCode::not_found, "there is no such film", path.string());
  av_log_set_level(AV_LOG_QUIET);
  AVDictionary* options = nullptr;
  av_dict_set(&options, "protocol_whitelist", "file", 0);
  av_dict_set(&options, "format_whitelist", kSoundFormats, 0);
  AVFormatContext* opened = nullptr;
  // With its protocol, so that no part of a name is taken for one.
  const int code = avformat_open_input(&opened, ("file:" + path.string()).c_str(), nullptr, &options);
  av_dict_free(&options);
  if (code < 0) return state->refused(ErrorCode::malformed, "it is no film: " + said(code));
  state->file.reset(opened);
  if (const int found = avformat_find_stream_info(opened, nullptr); found < 0)
    return state->refused(ErrorCode::malformed, "it is no film: " + said(found));
  const AVCodec* codec = nullptr;
  state->stream = av_find_best_stream(opened, AVMEDIA_TYPE_AUDIO, -1, -1, &codec, 0);
  if (state->stream == AVERROR_DECODER_NOT_FOUND)
    return state->refused(ErrorCode::unsupported, "it has no sound that this machine's FFmpeg reads");
  if (state->stream < 0 || codec == nullptr)
    return fail(ErrorCode::not_found, "it has no sound", path.string());
  state->start = start_of(*opened);
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
  state->decoder.reset(avcodec_alloc_context3(codec));
  avcodec_parameters_to_context(state->decoder.get(), opened->streams[state->stream]->codecpar);
  state->decoder->pkt_timebase = opened->streams[state->stream]->time_base;
  state->decoder->thread_count = 1;
  if (const int started = avcodec_open2(state->decoder.get(), codec, nullptr); started < 0)
    return state->refused(ErrorCode::unsupported, "its codec does not start: " + said(started));
  return SoundReader(std::move(state));
}

const std::optional<FilmStart>& SoundReader::start() const {
  return state_->start;
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
