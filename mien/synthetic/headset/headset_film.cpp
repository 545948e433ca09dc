#include "mien/synthetic/headset/headset_film.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "mien/core/files.h"

namespace mien::synthetic {
namespace {

constexpr std::string_view kMagic = "mien headset film 2\n";
constexpr std::size_t kHashDigits = 64;
constexpr std::size_t kMostViews = 16, kMostSide = 512;

/// Before the frames; numbers are the machine's own, since films are not carried elsewhere.
struct Header {
  std::array<char, 24> magic{};
  std::array<char, kHashDigits> hash{};
  std::uint32_t views = 0, side = 0;
  std::uint64_t frames = 0;
};

}  // namespace

Result<HeadsetFilm> HeadsetFilm::open(const std::filesystem::path& path) {
  MIEN_TRY_ASSIGN(MappedFile mapped, MappedFile::open(path));
  HeadsetFilm film(std::move(mapped));
  const std::span<const std::byte> bytes = film.file_.bytes();
  Header header;
  if (bytes.size() < sizeof(header)) return fail(ErrorCode::malformed, "it is no film", path.string());
  std::memcpy(&header, bytes.data(), sizeof(header));
  if (std::string_view(header.magic.data(), kMagic.size()) != kMagic || header.views == 0 ||
      header.views > kMostViews || header.side == 0 || header.side > kMostSide)
    return fail(ErrorCode::malformed, "it is no film", path.string());
  film.views_ = header.views;
  film.side_ = header.side;
  film.hash_.assign(header.hash.data(), header.hash.size());
  const std::size_t frame = sizeof(FilmTruth) + film.views_ * film.side_ * film.side_;
  film.frames_ = (bytes.size() - sizeof(header)) / frame;
  if (film.frames_ != header.frames || bytes.size() != sizeof(header) + film.frames_ * frame)
    return fail(ErrorCode::malformed, "the film was cut off", path.string(),
                "remove it; it is rendered again");
  return film;
}

std::span<const std::byte> HeadsetFilm::frame_bytes(std::size_t frame) const {
  const std::size_t size = sizeof(FilmTruth) + views_ * side_ * side_;
  return file_.bytes().subspan(sizeof(Header) + frame * size, size);
}

std::span<const std::uint8_t> HeadsetFilm::view(std::size_t frame, std::size_t view) const {
  const std::span<const std::byte> bytes =
      frame_bytes(frame).subspan(sizeof(FilmTruth) + view * side_ * side_, side_ * side_);
  return {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()};
}

FilmTruth HeadsetFilm::truth(std::size_t frame) const {
  FilmTruth truth;
  std::memcpy(&truth, frame_bytes(frame).data(), sizeof(truth));
  return truth;
}

std::vector<HeadsetFilm::Donning> HeadsetFilm::donnings() const {
  std::vector<Donning> all;
  bool rests = false;
  for (std::size_t frame = 0; frame < frames_; ++frame) {
    const FilmTruth now = truth(frame);
    if (all.empty() || now.time_s == 0) {
      all.push_back({frame, frame, frame});
      rests = true;
    }
    rests = rests && now.neutral > 0;
    if (rests) all.back().rest_end = frame + 1;
    all.back().end = frame + 1;
  }
  return all;
}

Result<void> write_film(const std::filesystem::path& path, std::string_view hash, std::size_t views,
                        std::size_t side, std::span<const FilmFrame> frames) {
  Header header;
  std::ranges::copy(kMagic, header.magic.begin());
  std::ranges::copy(hash.substr(0, kHashDigits), header.hash.begin());
  header.views = static_cast<std::uint32_t>(views);
  header.side = static_cast<std::uint32_t>(side);
  header.frames = frames.size();
  std::vector<std::byte> bytes(sizeof(header));
  std::memcpy(bytes.data(), &header, sizeof(header));
  bytes.reserve(sizeof(header) + frames.size() * (sizeof(FilmTruth) + views * side * side));
  const auto add = [&](const void* data, std::size_t size) {
    const auto* first = static_cast<const std::byte*>(data);
    bytes.insert(bytes.end(), first, first + size);
  };
  for (const FilmFrame& frame : frames) {
    if (frame.views.size() != views ||
        !std::ranges::all_of(frame.views, [&](const auto& view) { return view.size() == side * side; }))
      return fail(ErrorCode::mismatch, "a frame has other views than its film", path.string());
    add(&frame.truth, sizeof(frame.truth));
    for (const auto& view : frame.views) add(view.data(), view.size());
  }
  return write_file(path, bytes);
}

}  // namespace mien::synthetic
