#include "mien/live/video_message.h"

#include <fmt/format.h>

#include <algorithm>

#include "mien/core/bytes.h"

namespace mien::live {
namespace {

constexpr std::string_view kVideoMagic = "MVID";
constexpr std::uint8_t kVideoVersion = 1;
const char* const kVideo = "video of the page";
/// A page of this program's own version sends none of it.
const char* const kLoadPageAnew = "load the page anew";

/// Whether a file may begin so, as far as there is something of it: WebM by EBML's magic, MP4 by a box "ftyp"
/// behind the box's length.
bool may_begin(VideoContainer container, std::span<const std::byte> data) {
  const bool webm = container == VideoContainer::webm;
  const std::string_view wanted = webm ? "\x1A\x45\xDF\xA3" : "ftyp";
  const std::string_view there = as_text(data.subspan(webm ? 0 : std::min<std::size_t>(data.size(), 4)));
  return there.substr(0, wanted.size()) == wanted.substr(0, there.size());
}

}  // namespace

std::string_view container_name(VideoContainer container) {
  return container == VideoContainer::webm ? "webm" : "mp4";
}

bool is_video_message(std::span<const std::byte> bytes) {
  return as_text(bytes).starts_with(kVideoMagic);
}

Result<VideoMessage> parse_video_message(std::span<const std::byte> bytes) {
  if (bytes.size() <= kVideoHeadBytes)
    return fail(ErrorCode::truncated, fmt::format("{} bytes", bytes.size()), kVideo, kLoadPageAnew);
  if (!is_video_message(bytes))
    return fail(ErrorCode::malformed, "it does not begin as video", kVideo, kLoadPageAnew);
  ByteReader reader(bytes.subspan(kVideoMagic.size()));
  if (const auto version = reader.little<std::uint8_t>(); version != kVideoVersion)
    return fail(ErrorCode::unsupported, fmt::format("version {}", version), kVideo, kLoadPageAnew);
  const auto container = reader.little<std::uint8_t>();
  if (container != static_cast<std::uint8_t>(VideoContainer::webm) &&
      container != static_cast<std::uint8_t>(VideoContainer::mp4))
    return fail(ErrorCode::unsupported, fmt::format("a container of the number {}", container), kVideo,
                kLoadPageAnew);
  if (reader.little<std::uint16_t>() != 0)
    return fail(ErrorCode::malformed, "a reserved byte is set", kVideo, kLoadPageAnew);
  VideoMessage message;
  message.container = static_cast<VideoContainer>(container);
  message.sequence = reader.little<std::uint32_t>();
  message.age_ms = reader.little<std::uint32_t>();
  message.data = bytes.subspan(kVideoHeadBytes);
  if (message.data.size() > kMaxVideoChunk)
    return fail(ErrorCode::out_of_range,
                fmt::format("a chunk of {:.1f} MB", 1e-6 * static_cast<double>(message.data.size())), kVideo,
                fmt::format("send chunks of at most {} MB, of a second each", kMaxVideoChunk >> 20U));
  if (message.sequence == 0 && !may_begin(message.container, message.data))
    return fail(ErrorCode::malformed,
                fmt::format("its first chunk is no {}", container_name(message.container)), kVideo,
                kLoadPageAnew);
  return message;
}

std::vector<std::byte> encode_video_message(const VideoMessage& message) {
  ByteWriter writer;
  writer.append(kVideoMagic);
  writer.little(kVideoVersion);
  writer.little(static_cast<std::uint8_t>(message.container));
  writer.little(std::uint16_t{0});
  writer.little(message.sequence);
  writer.little(message.age_ms);
  writer.append(message.data);
  return writer.release();
}

}  // namespace mien::live
