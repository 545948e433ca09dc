#include "mien/study/media/video_reader.h"

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
#include <libavutil/opt.h>
#include <libswscale/swscale.h>
}

namespace mien::media {
namespace fs = std::filesystem;
namespace {

constexpr int kMostSide = 8192;
constexpr const char* kFormats = "mov,mp4,m4a,3gp,3g2,mj2,matroska,webm,avi,mpegts,mpeg";
/// Packets of other streams, or without a picture, before a film is given up.
constexpr int kMostWithout = 100'000;

struct Close {
  void operator()(AVFormatContext* p) const { avformat_close_input(&p); }
  void operator()(AVCodecContext* p) const { avcodec_free_context(&p); }
  void operator()(AVFrame* p) const { av_frame_free(&p); }
  void operator()(AVPacket* p) const { av_packet_free(&p); }
  void operator()(SwsContext* p) const { sws_freeContext(p); }
};
template <class T>
using Held = std::unique_ptr<T, Close>;

std::string words(int code) {
  std::array<char, AV_ERROR_MAX_STRING_SIZE> text{};
  av_strerror(code, text.data(), text.size());
  return text.data();
}

std::int64_t pictures_of(const AVFormatContext& file, const AVStream& stream) {
  if (stream.nb_frames > 0) return stream.nb_frames;
  const double rate_hz = av_q2d(stream.avg_frame_rate);
  if (file.duration <= 0 || !(rate_hz > 0)) return 0;
  return std::llround(static_cast<double>(file.duration) / AV_TIME_BASE * rate_hz);
}

}  // namespace

struct VideoReader::State {
  std::string path;
  Held<AVFormatContext> file;
  Held<AVCodecContext> decoder;
  Held<AVFrame> frame{av_frame_alloc()};
  Held<AVPacket> packet{av_packet_alloc()};
  Held<SwsContext> converter;
  int stream = -1;
  int format = -1;  // Of the pictures that the converter takes.
  int width = 0, height = 0;
  std::int64_t about = 0;
  std::vector<std::uint8_t> grey;
  bool drained = false;

  [[nodiscard]] std::unexpected<Error> refused(ErrorCode code, std::string what) const {
    return fail(code, std::move(what), path, "convert it to MP4 with H.264");
  }

  /// Fills the decoder until it has a picture. False: there are no more.
  Result<bool> decode() {
    for (int without = 0; without < kMostWithout; ++without) {
      const int got = avcodec_receive_frame(decoder.get(), frame.get());
      if (got == 0) return true;
      if (got == AVERROR_EOF) return false;
      if (got != AVERROR(EAGAIN))
        return refused(ErrorCode::malformed, "a picture does not decode: " + words(got));
      if (drained) return false;
      const int read = av_read_frame(file.get(), packet.get());
      if (read < 0) {
        if (read != AVERROR_EOF) return refused(ErrorCode::malformed, "it breaks off: " + words(read));
        drained = true;
        avcodec_send_packet(decoder.get(), nullptr);
        continue;
      }
      const int sent = packet->stream_index == stream ? avcodec_send_packet(decoder.get(), packet.get()) : 0;
      av_packet_unref(packet.get());
      // A broken picture leaves a gap that nobody would see in the count: say so instead.
      if (sent < 0) return refused(ErrorCode::malformed, "a picture does not decode: " + words(sent));
    }
    return refused(ErrorCode::malformed, "it goes on without pictures");
  }

  Result<void> convert() {
    if (!converter || frame->format != format) {
      format = frame->format;
      converter.reset(sws_alloc_context());
      // Full range out, whatever range the film has.
      for (const auto& [name, value] : {std::pair<const char*, int>{"srcw", frame->width},
                                        {"srch", frame->height},
                                        {"src_format", format},
                                        {"src_range", frame->color_range == AVCOL_RANGE_JPEG ? 1 : 0},
                                        {"dstw", width},
                                        {"dsth", height},
                                        {"dst_format", AV_PIX_FMT_GRAY8},
                                        {"dst_range", 1},
                                        {"sws_flags", SWS_AREA | SWS_ACCURATE_RND}})
        av_opt_set_int(converter.get(), name, value, 0);
      if (sws_init_context(converter.get(), nullptr, nullptr) < 0)
        return refused(ErrorCode::unsupported, "its colours cannot be converted");
    }
    std::uint8_t* out[] = {grey.data()};
    const int strides[] = {width};
    if (sws_scale(converter.get(), frame->data, frame->linesize, 0, frame->height, out, strides) != height)
      return refused(ErrorCode::malformed, "a picture cannot be converted");
    return {};
  }
};

VideoReader::VideoReader(std::unique_ptr<State> state) : state_(std::move(state)) {}
VideoReader::VideoReader(VideoReader&&) noexcept = default;
VideoReader& VideoReader::operator=(VideoReader&&) noexcept = default;
VideoReader::~VideoReader() = default;

Result<VideoReader> VideoReader::open(const fs::path& path, int most_width, int most_height) {
  auto state = std::make_unique<State>();
  state->path = path.string();
  std::error_code ignored;
  if (!fs::is_regular_file(path, ignored))
    return fail(ErrorCode::not_found, "there is no such film", path.string());
  av_log_set_level(AV_LOG_QUIET);
  AVDictionary* options = nullptr;
  av_dict_set(&options, "protocol_whitelist", "file", 0);
  av_dict_set(&options, "format_whitelist", kFormats, 0);
  AVFormatContext* opened = nullptr;
  // With its protocol, so that no part of a name is taken for one.
  const int code = avformat_open_input(&opened, ("file:" + path.string()).c_str(), nullptr, &options);
  av_dict_free(&options);
  if (code < 0) return state->refused(ErrorCode::malformed, "it is no film: " + words(code));
  state->file.reset(opened);
  if (const int found = avformat_find_stream_info(opened, nullptr); found < 0)
    return state->refused(ErrorCode::malformed, "it is no film: " + words(found));
  const AVCodec* codec = nullptr;
  state->stream = av_find_best_stream(opened, AVMEDIA_TYPE_VIDEO, -1, -1, &codec, 0);
  if (state->stream < 0 || codec == nullptr)
    return state->refused(
        state->stream == AVERROR_DECODER_NOT_FOUND ? ErrorCode::unsupported : ErrorCode::malformed,
        "it has no pictures that this machine's FFmpeg reads");
  const AVStream& stream = *opened->streams[state->stream];
  const AVCodecParameters& parameters = *stream.codecpar;
  if (parameters.width < 1 || parameters.height < 1 || parameters.width > kMostSide ||
      parameters.height > kMostSide)
    return state->refused(ErrorCode::out_of_range,
                          fmt::format("its pictures are {} x {}", parameters.width, parameters.height));
  state->decoder.reset(avcodec_alloc_context3(codec));
  avcodec_parameters_to_context(state->decoder.get(), &parameters);
  state->decoder->thread_count = 1;
  if (const int started = avcodec_open2(state->decoder.get(), codec, nullptr); started < 0)
    return state->refused(ErrorCode::unsupported, "its codec does not start: " + words(started));
  const double shrink = std::min({1.0, static_cast<double>(most_width) / parameters.width,
                                  static_cast<double>(most_height) / parameters.height});
  state->width = std::max(1, static_cast<int>(std::lround(parameters.width * shrink)));
  state->height = std::max(1, static_cast<int>(std::lround(parameters.height * shrink)));
  state->grey.resize(static_cast<std::size_t>(state->width) * static_cast<std::size_t>(state->height));
  state->about = pictures_of(*opened, stream);
  return VideoReader(std::move(state));
}

int VideoReader::width() const {
  return state_->width;
}
int VideoReader::height() const {
  return state_->height;
}
std::int64_t VideoReader::about() const {
  return state_->about;
}

Result<std::optional<std::span<const std::uint8_t>>> VideoReader::next() {
  MIEN_TRY_ASSIGN(const bool more, state_->decode());
  if (!more) return std::nullopt;
  const AVCodecParameters& told = *state_->file->streams[state_->stream]->codecpar;
  if (state_->frame->width != told.width || state_->frame->height != told.height)
    return state_->refused(ErrorCode::mismatch, "the size of its pictures changes");
  MIEN_TRY(state_->convert());
  return std::span<const std::uint8_t>(state_->grey);
}

}  // namespace mien::media
