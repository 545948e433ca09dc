#include "mien/media/video_writer.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <string>
#include <system_error>
#include <utility>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/channel_layout.h>
#include <libavutil/opt.h>
#include <libswscale/swscale.h>
}

#include "mien/media/film_file.h"

namespace mien::media {
namespace fs = std::filesystem;
namespace {

struct Free {
  void operator()(AVFormatContext* p) const {
    if (p->pb != nullptr) avio_closep(&p->pb);
    avformat_free_context(p);
  }
  void operator()(AVCodecContext* p) const { avcodec_free_context(&p); }
  void operator()(AVFrame* p) const { av_frame_free(&p); }
  void operator()(AVPacket* p) const { av_packet_free(&p); }
  void operator()(SwsContext* p) const { sws_freeContext(p); }
};
template <class T>
using Owned = std::unique_ptr<T, Free>;

}  // namespace

struct VideoWriter::State {
  VideoOptions options;
  fs::path path;
  fs::path unfinished;  // Where it grows; empty once it has its name.
  Owned<AVFormatContext> file;
  Owned<AVCodecContext> video, audio;
  AVStream* video_stream = nullptr;  // Owned by file.
  AVStream* audio_stream = nullptr;
  Owned<AVFrame> picture, sound_frame;
  Owned<AVPacket> packet;
  Owned<SwsContext> converter;
  std::int64_t frames = 0;
  std::int64_t samples = 0;

  State() = default;
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  ~State() {
    file.reset();
    std::error_code ignored;
    if (!unfinished.empty()) fs::remove(unfinished, ignored);
  }

  [[nodiscard]] Result<void> check(int code, const char* what) const {
    if (code >= 0) return {};
    return fail(ErrorCode::io, fmt::format("{} ({})", what, ffmpeg_words(code)), path.string(),
                "nothing was written");
  }

  Result<void> open_video() {
    const AVCodec* codec = avcodec_find_encoder_by_name("libx264");
    const bool h264 = codec != nullptr;
    if (codec == nullptr) codec = avcodec_find_encoder(AV_CODEC_ID_MPEG4);
    if (codec == nullptr)
      return fail(ErrorCode::unsupported, "this machine's FFmpeg writes neither H.264 nor MPEG-4",
                  path.string(), "install Debian's libavcodec59");
    video.reset(avcodec_alloc_context3(codec));
    video_stream = avformat_new_stream(file.get(), nullptr);
    video->width = options.width;
    video->height = options.height;
    const AVRational rate = av_d2q(options.rate_hz, 100'000);
    video->time_base = av_inv_q(rate);
    video->framerate = rate;
    video->pix_fmt = AV_PIX_FMT_YUV420P;
    video->color_range = AVCOL_RANGE_MPEG;
    video->colorspace = AVCOL_SPC_BT709;
    video->color_primaries = AVCOL_PRI_BT709;
    video->color_trc = AVCOL_TRC_BT709;
    // Threads cut pictures differently: a fixed number, so that the bytes do not depend on the machine.
    video->thread_count = 2;
    video->flags |= AV_CODEC_FLAG_BITEXACT;
    if ((file->oformat->flags & AVFMT_GLOBALHEADER) != 0) video->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
    if (h264) {
      av_opt_set(video->priv_data, "preset", "veryfast", 0);
      av_opt_set(video->priv_data, "crf", std::to_string(options.quality).c_str(), 0);
    } else {
      video->flags |= AV_CODEC_FLAG_QSCALE;
      video->global_quality = FF_QP2LAMBDA * std::clamp(options.quality / 6, 1, 31);
    }
    MIEN_TRY(check(avcodec_open2(video.get(), codec, nullptr), "the video encoder does not start"));
    video_stream->time_base = video->time_base;
    video_stream->avg_frame_rate = rate;
    MIEN_TRY(check(avcodec_parameters_from_context(video_stream->codecpar, video.get()),
                   "the video cannot be described"));

    picture.reset(av_frame_alloc());
    picture->format = video->pix_fmt;
    picture->width = options.width;
    picture->height = options.height;
    picture->color_range = video->color_range;
    picture->colorspace = video->colorspace;
    MIEN_TRY(check(av_frame_get_buffer(picture.get(), 0), "no memory for a picture"));
    converter.reset(sws_getContext(
        options.width, options.height, AV_PIX_FMT_RGB24, options.width, options.height, AV_PIX_FMT_YUV420P,
        SWS_BICUBIC | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INP, nullptr, nullptr, nullptr));
    if (!converter) return fail(ErrorCode::io, "the colours cannot be converted", path.string());
    const int* bt709 = sws_getCoefficients(SWS_CS_ITU709);
    sws_setColorspaceDetails(converter.get(), bt709, 1, bt709, 0, 0, 1 << 16, 1 << 16);
    return {};
  }

  Result<void> open_audio() {
    const AVCodec* codec = avcodec_find_encoder(AV_CODEC_ID_AAC);
    if (codec == nullptr)
      return fail(ErrorCode::unsupported, "this machine's FFmpeg writes no AAC", path.string(),
                  "install Debian's libavcodec59");
    audio.reset(avcodec_alloc_context3(codec));
    audio_stream = avformat_new_stream(file.get(), nullptr);
    audio->sample_fmt = AV_SAMPLE_FMT_FLTP;
    audio->sample_rate = static_cast<int>(options.sound->rate_hz);
    audio->bit_rate = 96'000;
    av_channel_layout_default(&audio->ch_layout, 1);
    audio->time_base = {1, audio->sample_rate};
    audio->flags |= AV_CODEC_FLAG_BITEXACT;
    if ((file->oformat->flags & AVFMT_GLOBALHEADER) != 0) audio->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
    MIEN_TRY(check(avcodec_open2(audio.get(), codec, nullptr), "the sound encoder does not take this rate"));
    audio_stream->time_base = audio->time_base;
    MIEN_TRY(check(avcodec_parameters_from_context(audio_stream->codecpar, audio.get()),
                   "the sound cannot be described"));
    sound_frame.reset(av_frame_alloc());
    sound_frame->format = audio->sample_fmt;
    sound_frame->sample_rate = audio->sample_rate;
    sound_frame->nb_samples = audio->frame_size;
    av_channel_layout_copy(&sound_frame->ch_layout, &audio->ch_layout);
    return check(av_frame_get_buffer(sound_frame.get(), 0), "no memory for sound");
  }

  /// Hands a frame (null: the end) to an encoder and what comes out to the file.
  Result<void> encode(AVCodecContext& encoder, AVStream& stream, const AVFrame* frame) {
    MIEN_TRY(check(avcodec_send_frame(&encoder, frame), "a frame cannot be encoded"));
    for (;;) {
      const int code = avcodec_receive_packet(&encoder, packet.get());
      if (code == AVERROR(EAGAIN) || code == AVERROR_EOF) return {};
      MIEN_TRY(check(code, "a frame cannot be encoded"));
      av_packet_rescale_ts(packet.get(), encoder.time_base, stream.time_base);
      packet->stream_index = stream.index;
      MIEN_TRY(check(av_interleaved_write_frame(file.get(), packet.get()), "the file cannot be written"));
    }
  }

  /// Sound up to `until` samples, in whole AAC frames; the last one may be short.
  Result<void> write_sound(std::int64_t until, bool last) {
    const auto& all = options.sound->samples;
    const std::int64_t end = std::min<std::int64_t>(until, static_cast<std::int64_t>(all.size()));
    const std::int64_t whole = audio->frame_size;
    while (samples < end && (last || end - samples >= whole)) {
      const std::int64_t count = std::min(whole, end - samples);
      MIEN_TRY(check(av_frame_make_writable(sound_frame.get()), "no memory for sound"));
      sound_frame->nb_samples = static_cast<int>(count);
      std::copy_n(all.begin() + samples, count, reinterpret_cast<float*>(sound_frame->data[0]));
      sound_frame->pts = samples;
      samples += count;
      MIEN_TRY(encode(*audio, *audio_stream, sound_frame.get()));
    }
    return {};
  }

  [[nodiscard]] std::int64_t samples_so_far() const {
    return static_cast<std::int64_t>(static_cast<double>(frames) / options.rate_hz * options.sound->rate_hz);
  }
};

VideoWriter::VideoWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}
VideoWriter::VideoWriter(VideoWriter&&) noexcept = default;
VideoWriter& VideoWriter::operator=(VideoWriter&&) noexcept = default;
VideoWriter::~VideoWriter() = default;

Result<VideoWriter> VideoWriter::create(const fs::path& path, VideoOptions options) {
  const auto side_ok = [](int side) { return side >= 16 && side <= 8192 && side % 2 == 0; };
  if (!side_ok(options.width) || !side_ok(options.height))
    return fail(ErrorCode::bad_usage,
                fmt::format("a video of {} x {} cannot be written", options.width, options.height),
                path.string(), "choose even sides from 16 to 8192");
  if (!(options.rate_hz >= 1 && options.rate_hz <= 240))
    return fail(ErrorCode::bad_usage, fmt::format("{} frames a second", options.rate_hz), path.string(),
                "choose 1 to 240");
  if (options.quality < 0 || options.quality > 51)
    return fail(ErrorCode::bad_usage, fmt::format("a quality of {}", options.quality), path.string(),
                "choose 0 to 51");
  if (options.sound && (options.sound->samples.empty() || options.sound->rate_hz == 0)) options.sound.reset();

  av_log_set_level(AV_LOG_QUIET);
  auto state = std::make_unique<State>();
  state->options = std::move(options);
  state->path = path;
  std::string name = path.string() + ".XXXXXX";
  const int taken = ::mkstemp(name.data());
  if (taken < 0)
    return fail(ErrorCode::io, std::generic_category().message(errno), path.string(),
                "check the folder and its permissions");
  ::close(taken);
  state->unfinished = name;

  AVFormatContext* file = nullptr;
  if (avformat_alloc_output_context2(&file, nullptr, "mp4", nullptr) < 0 || file == nullptr)
    return fail(ErrorCode::unsupported, "this machine's FFmpeg writes no MP4", path.string(),
                "install Debian's libavformat59");
  state->file.reset(file);
  file->flags |= AVFMT_FLAG_BITEXACT;
  // At its end FFmpeg opens the file once more by name, to move the index to the front.
  file->url = av_strdup(name.c_str());
  MIEN_TRY(state->open_video());
  if (state->options.sound) MIEN_TRY(state->open_audio());
  state->packet.reset(av_packet_alloc());
  MIEN_TRY(state->check(avio_open(&file->pb, name.c_str(), AVIO_FLAG_WRITE), "the file cannot be opened"));
  AVDictionary* settings = nullptr;
  av_dict_set(&settings, "movflags", "+faststart", 0);
  const int code = avformat_write_header(file, &settings);
  av_dict_free(&settings);
  MIEN_TRY(state->check(code, "the file cannot be begun"));
  return VideoWriter(std::move(state));
}

Result<void> VideoWriter::add_frame(std::span<const std::uint8_t> rgb) {
  State& s = *state_;
  if (rgb.size() !=
      std::size_t{3} * static_cast<std::size_t>(s.options.width) * static_cast<std::size_t>(s.options.height))
    return fail(ErrorCode::mismatch, fmt::format("frame {} has {} bytes", s.frames, rgb.size()),
                s.path.string());
  MIEN_TRY(s.check(av_frame_make_writable(s.picture.get()), "no memory for a picture"));
  const std::uint8_t* rows = rgb.data();
  const int stride = 3 * s.options.width;
  sws_scale(s.converter.get(), &rows, &stride, 0, s.options.height, s.picture->data, s.picture->linesize);
  s.picture->pts = s.frames++;
  MIEN_TRY(s.encode(*s.video, *s.video_stream, s.picture.get()));
  if (s.audio) MIEN_TRY(s.write_sound(s.samples_so_far(), false));
  return {};
}

Result<void> VideoWriter::finish() {
  State& s = *state_;
  if (s.frames == 0)
    return fail(ErrorCode::bad_usage, "a video needs at least one frame", s.path.string(),
                "nothing was written");
  MIEN_TRY(s.encode(*s.video, *s.video_stream, nullptr));
  if (s.audio) {
    MIEN_TRY(s.write_sound(s.samples_so_far(), true));
    MIEN_TRY(s.encode(*s.audio, *s.audio_stream, nullptr));
  }
  MIEN_TRY(s.check(av_write_trailer(s.file.get()), "the file cannot be ended"));
  MIEN_TRY(s.check(avio_closep(&s.file->pb), "the file cannot be closed"));
  std::error_code code;
  fs::permissions(s.unfinished, fs::perms::group_read | fs::perms::others_read, fs::perm_options::add, code);
  fs::rename(s.unfinished, s.path, code);
  if (code) return fail(ErrorCode::io, code.message(), s.path.string(), "nothing was written");
  s.unfinished.clear();
  return {};
}

}  // namespace mien::media
