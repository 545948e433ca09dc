#include "mien/media/film_file.h"

#include <array>
#include <system_error>
#include <utility>

namespace mien::media {

std::string ffmpeg_words(int code) {
  std::array<char, AV_ERROR_MAX_STRING_SIZE> text{};
  av_strerror(code, text.data(), text.size());
  return text.data();
}

std::unexpected<Error> FilmFile::refused(ErrorCode code, std::string what) const {
  return fail(code, std::move(what), path, fix);
}

Result<void> FilmFile::open(const std::filesystem::path& named, const char* formats) {
  path = named.string();
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(named, ignored))
    return fail(ErrorCode::not_found, "there is no such film", path);
  av_log_set_level(AV_LOG_QUIET);
  AVDictionary* options = nullptr;
  av_dict_set(&options, "protocol_whitelist", "file", 0);
  av_dict_set(&options, "format_whitelist", formats, 0);
  AVFormatContext* opened = nullptr;
  // With its protocol, so that no part of a name is taken for one.
  const int code = avformat_open_input(&opened, ("file:" + path).c_str(), nullptr, &options);
  av_dict_free(&options);
  if (code < 0) return refused(ErrorCode::malformed, "it is no film: " + ffmpeg_words(code));
  file.reset(opened);
  if (const int found = avformat_find_stream_info(opened, nullptr); found < 0)
    return refused(ErrorCode::malformed, "it is no film: " + ffmpeg_words(found));
  return {};
}

Result<void> FilmFile::start(const AVCodec* codec) {
  const AVStream& chosen = *file->streams[stream];
  decoder.reset(avcodec_alloc_context3(codec));
  avcodec_parameters_to_context(decoder.get(), chosen.codecpar);
  decoder->pkt_timebase = chosen.time_base;
  decoder->thread_count = 1;
  if (const int started = avcodec_open2(decoder.get(), codec, nullptr); started < 0)
    return refused(ErrorCode::unsupported, "its codec does not start: " + ffmpeg_words(started));
  return {};
}

Result<bool> FilmFile::decode() {
  for (int without = 0; without < most_without; ++without) {
    const int got = avcodec_receive_frame(decoder.get(), frame.get());
    if (got == 0) return true;
    if (got == AVERROR_EOF) return false;
    if (got != AVERROR(EAGAIN))
      return refused(ErrorCode::malformed, std::string(piece) + " does not decode: " + ffmpeg_words(got));
    if (drained) return false;
    const int read = av_read_frame(file.get(), packet.get());
    if (read < 0) {
      if (read != AVERROR_EOF) return refused(ErrorCode::malformed, "it breaks off: " + ffmpeg_words(read));
      drained = true;
      avcodec_send_packet(decoder.get(), nullptr);
      continue;
    }
    const int sent = packet->stream_index == stream ? avcodec_send_packet(decoder.get(), packet.get()) : 0;
    av_packet_unref(packet.get());
    // A broken piece leaves a gap that nobody would see in the count: say so instead.
    if (sent < 0)
      return refused(ErrorCode::malformed, std::string(piece) + " does not decode: " + ffmpeg_words(sent));
  }
  return refused(ErrorCode::malformed, std::string("it goes on without ") + pieces);
}

}  // namespace mien::media
