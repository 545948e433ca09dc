#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "mien/core/error.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
}

namespace mien::media {

/// What FFmpeg says of an error's code.
[[nodiscard]] std::string ffmpeg_words(int code);

struct CloseFilm {
  void operator()(AVFormatContext* p) const { avformat_close_input(&p); }
  void operator()(AVCodecContext* p) const { avcodec_free_context(&p); }
  void operator()(AVFrame* p) const { av_frame_free(&p); }
  void operator()(AVPacket* p) const { av_packet_free(&p); }
};
template <class T>
using HeldFilm = std::unique_ptr<T, CloseFilm>;

/// A film's file, one of its streams, and that stream's decoder. For readers of pictures and of sound, whose
/// words it speaks. Not thread-safe.
struct FilmFile {
  const char* piece;   ///< What does not decode: "a picture".
  const char* pieces;  ///< What it goes on without: "pictures".
  const char* fix;     ///< What to do with a film that is refused.
  int most_without;    ///< Packets of other streams, or without a piece, before it is given up.

  std::string path = {};
  HeldFilm<AVFormatContext> file = {};
  HeldFilm<AVCodecContext> decoder = {};
  HeldFilm<AVFrame> frame{av_frame_alloc()};
  HeldFilm<AVPacket> packet{av_packet_alloc()};
  int stream = -1;
  bool drained = false;

  [[nodiscard]] std::unexpected<Error> refused(ErrorCode code, std::string what) const;
  /// Only this file is opened, and only as one of these formats: a playlist that names others is refused.
  /// Errors: not_found, malformed.
  [[nodiscard]] Result<void> open(const std::filesystem::path& named, const char* formats);
  /// The decoder of `stream`, on one thread. Errors: unsupported.
  [[nodiscard]] Result<void> start(const AVCodec* codec);
  /// Fills `frame` with the next piece. False: there are no more. Errors: malformed.
  [[nodiscard]] Result<bool> decode();
};

}  // namespace mien::media
