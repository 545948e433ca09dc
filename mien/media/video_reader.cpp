#include "mien/media/video_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

extern "C" {
#include <libavutil/opt.h>
#include <libswscale/swscale.h>
}

#include "mien/media/film_file.h"

namespace mien::media {
namespace fs = std::filesystem;
namespace {

constexpr int kMostSide = 8192;
constexpr const char* kFormats = "mov,mp4,m4a,3gp,3g2,mj2,matroska,webm,avi,mpegts,mpeg";
/// Packets of other streams, or without a picture, before a film is given up.
constexpr int kMostWithout = 100'000;

struct CloseScaler {
  void operator()(SwsContext* p) const { sws_freeContext(p); }
};

std::int64_t pictures_of(const AVFormatContext& file, const AVStream& stream) {
  if (stream.nb_frames > 0) return stream.nb_frames;
  const double rate_hz = av_q2d(stream.avg_frame_rate);
  if (file.duration <= 0 || !(rate_hz > 0)) return 0;
  return std::llround(static_cast<double>(file.duration) / AV_TIME_BASE * rate_hz);
}

}  // namespace

struct VideoReader::State : FilmFile {
  State() : FilmFile{"a picture", "pictures", "convert it to MP4 with H.264", kMostWithout} {}

  std::unique_ptr<SwsContext, CloseScaler> converter;
  int format = -1;  // Of the pictures that the converter takes.
  int width = 0, height = 0;
  std::int64_t about = 0;
  std::vector<std::uint8_t> grey;

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
  MIEN_TRY(state->open(path, kFormats));
  AVFormatContext* const opened = state->file.get();
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
  MIEN_TRY(state->start(codec));
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
