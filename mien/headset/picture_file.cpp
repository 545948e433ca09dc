#include "mien/headset/picture_file.h"

#include <fmt/format.h>
#include <turbojpeg.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <string_view>

namespace mien::headset {
namespace {

Result<void> check_size(int width, int height, const std::string& where) {
  if (width >= 1 && height >= 1 && width <= kMaxFileSide && height <= kMaxFileSide &&
      static_cast<std::size_t>(width) * static_cast<std::size_t>(height) <= kMaxFilePixels)
    return {};
  return fail(ErrorCode::out_of_range, fmt::format("a picture of {} x {}", width, height), where,
              fmt::format("sides are 1 to {} pixels, {} million of them in all", kMaxFileSide,
                          kMaxFilePixels / 1'000'000));
}

/// Netpbm's text between the numbers: blanks, and comments from # to the end of the line.
class NetpbmReader {
 public:
  explicit NetpbmReader(std::string_view text) : text_(text) {}

  /// The next number, of at most six digits; none where there is no such.
  std::optional<int> number() {
    skip();
    int value = 0;
    std::size_t digits = 0;
    for (; at_ < text_.size() && text_[at_] >= '0' && text_[at_] <= '9'; ++at_, ++digits) {
      if (digits == 6) return std::nullopt;
      value = 10 * value + (text_[at_] - '0');
    }
    if (digits == 0) return std::nullopt;
    return value;
  }
  /// Behind the one blank that ends a header.
  std::string_view rest() {
    if (at_ < text_.size() && is_blank(text_[at_])) ++at_;
    return text_.substr(at_);
  }

 private:
  static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }
  void skip() {
    while (at_ < text_.size() && (is_blank(text_[at_]) || text_[at_] == '#')) {
      if (text_[at_] == '#') at_ = std::min(text_.size(), text_.find('\n', at_));
      if (at_ < text_.size()) ++at_;
    }
  }

  std::string_view text_;
  std::size_t at_ = 2;  // Behind the magic.
};

/// Of 8 bits, as JPEG has it.
std::uint8_t luma(const std::array<int, 3>& rgb) {
  return static_cast<std::uint8_t>((19595 * rgb[0] + 38470 * rgb[1] + 7471 * rgb[2] + 32768) >> 16);
}

Result<PictureCopy> parse_netpbm(std::string_view text, const std::string& where) {
  const bool binary = text[1] >= '5', colour = text[1] == '3' || text[1] == '6';
  NetpbmReader reader(text);
  const auto width = reader.number(), height = reader.number(), most = reader.number();
  if (!width || !height || !most)
    return fail(ErrorCode::malformed, "a header of PGM or PPM without its three numbers", where);
  MIEN_TRY(check_size(*width, *height, where));
  if (*most < 1 || *most > 65'535)
    return fail(ErrorCode::out_of_range, fmt::format("its brightest level is {}", *most), where,
                "PGM and PPM have 1 to 65535");
  const std::size_t channels = colour ? 3 : 1, bytes_each = *most > 255 ? 2 : 1;
  const std::size_t pixels = static_cast<std::size_t>(*width) * static_cast<std::size_t>(*height);
  const std::string_view data = binary ? reader.rest() : std::string_view();
  // A number in text has at least one digit and a blank, but for the last one.
  const std::size_t there = binary ? data.size() / bytes_each : text.size() / 2;
  if (there < pixels * channels)
    return fail(ErrorCode::truncated, fmt::format("a picture of {} x {} that ends early", *width, *height),
                where);
  const auto level = [&](std::size_t i) -> std::optional<int> {
    std::optional<int> value;
    if (!binary)
      value = reader.number();
    else if (bytes_each == 1)
      value = static_cast<unsigned char>(data[i]);
    else
      value = (static_cast<unsigned char>(data[2 * i]) << 8) + static_cast<unsigned char>(data[2 * i + 1]);
    if (!value || *value > *most) return std::nullopt;
    return (*value * 255 + *most / 2) / *most;
  };
  PictureCopy picture{.width = *width, .height = *height, .pixels = {}};
  picture.pixels.reserve(pixels);
  for (std::size_t p = 0; p < pixels; ++p) {
    std::array<int, 3> rgb{};
    for (std::size_t c = 0; c < channels; ++c) {
      const auto value = level(p * channels + c);
      if (!value)
        return fail(ErrorCode::malformed, fmt::format("pixel {} is no level up to {}", p, *most), where);
      rgb[c] = *value;
    }
    picture.pixels.push_back(colour ? luma(rgb) : static_cast<std::uint8_t>(rgb[0]));
  }
  return picture;
}

Result<PictureCopy> parse_jpeg(std::span<const std::byte> bytes, const std::string& where) {
  const std::unique_ptr<void, int (*)(void*)> decoder(tjInitDecompress(), tjDestroy);
  if (!decoder) return fail(ErrorCode::internal, "libjpeg-turbo gives no decoder", where);
  const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
  int width = 0, height = 0, sampling = 0, colours = 0;
  const auto refused = [&] {
    return fail(ErrorCode::malformed,
                fmt::format("it does not decode ({})", std::string_view(tjGetErrorStr2(decoder.get()))),
                where);
  };
  if (tjDecompressHeader3(decoder.get(), data, bytes.size(), &width, &height, &sampling, &colours) != 0)
    return refused();
  MIEN_TRY(check_size(width, height, where));
  if (colours == TJCS_CMYK || colours == TJCS_YCCK)
    return fail(ErrorCode::unsupported, "a JPEG of the colours of print (CMYK)", where,
                "convert it to grey or RGB");
  PictureCopy picture{.width = width, .height = height, .pixels = {}};
  picture.pixels.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  // Its warnings are of broken data; a progressive picture of endless scans is refused.
  if (tjDecompress2(decoder.get(), data, bytes.size(), picture.pixels.data(), width, 0, height, TJPF_GRAY,
                    TJFLAG_STOPONWARNING | TJFLAG_ACCURATEDCT | TJFLAG_LIMITSCANS) != 0)
    return refused();
  return picture;
}

/// The pixels of a row or column that one of the scaled picture covers, and the share of the first and of the
/// last one that lies within.
struct Covered {
  int first = 0, last = 0;
  double first_share = 1, last_share = 1;
};

std::vector<Covered> covered_pixels(int from, int to) {
  std::vector<Covered> all(static_cast<std::size_t>(to));
  for (int i = 0; i < to; ++i) {
    const double begin = static_cast<double>(i) * from / to, end = static_cast<double>(i + 1) * from / to;
    Covered& cover = all[static_cast<std::size_t>(i)];
    cover.first = std::min(from - 1, static_cast<int>(std::floor(begin)));
    cover.last = std::clamp(static_cast<int>(std::ceil(end)) - 1, cover.first, from - 1);
    cover.first_share = std::min<double>(cover.first + 1, end) - begin;
    cover.last_share = end - cover.last;
  }
  return all;
}

double covered_share(const Covered& cover, int place) {
  if (place == cover.first) return cover.first_share;
  return place == cover.last ? cover.last_share : 1;
}

}  // namespace

Result<PictureCopy> parse_picture(std::span<const std::byte> bytes, const std::string& where) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (text.starts_with("\xFF\xD8")) return parse_jpeg(bytes, where);
  if (text.size() > 2 && text[0] == 'P' && std::string_view("2356").find(text[1]) != std::string_view::npos)
    return parse_netpbm(text, where);
  return fail(ErrorCode::unsupported, bytes.empty() ? "it is empty" : "neither a JPEG nor a PGM or PPM",
              where, "convert it to JPEG or PGM");
}

PictureCopy scaled_picture(const GreyPicture& picture, int width, int height) {
  PictureCopy out{.width = width, .height = height, .pixels = {}};
  if (width == picture.width && height == picture.height) {
    out.pixels.assign(picture.pixels.begin(), picture.pixels.end());
    return out;
  }
  out.pixels.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  const std::vector<Covered> columns = covered_pixels(picture.width, width),
                             rows = covered_pixels(picture.height, height);
  for (const Covered& row : rows)
    for (const Covered& column : columns) {
      double sum = 0, area = 0;
      for (int y = row.first; y <= row.last; ++y)
        for (int x = column.first; x <= column.last; ++x) {
          const double share = covered_share(row, y) * covered_share(column, x);
          sum +=
              share * picture.pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width) +
                                     static_cast<std::size_t>(x)];
          area += share;
        }
      out.pixels.push_back(static_cast<std::uint8_t>(sum / area + 0.5));
    }
  return out;
}

}  // namespace mien::headset
