#include "mien/headset/jpeg_gate.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>

#include "mien/core/bytes.h"
#include "mien/headset/jpeg_marker.h"
#include "mien/sensor/payload.h"

namespace mien::headset {
namespace {

using Fault = PictureFault;
/// A fault, or none.
using MaybeFault = std::optional<PictureFault>;

constexpr std::size_t kMostTables = 4;
constexpr std::size_t kQuantisationSteps = 64;
constexpr std::size_t kHuffmanLengths = 16;
constexpr std::size_t kMostHuffmanCodes = 256;
constexpr int kMostSampling = 4;

struct Component {
  std::uint8_t id = 0;
  std::uint8_t quantisation = 0;
};

class Gate {
 public:
  explicit Gate(std::span<const std::byte> picture) : all_(picture), left_(picture) {}
  std::expected<JpegHeader, Fault> check();

 private:
  /// The code behind the next FF; none where the picture ends before it.
  std::optional<std::byte> next_code();
  MaybeFault segment(std::byte code, std::span<const std::byte> content);
  MaybeFault frame(std::byte code, std::span<const std::byte> content);
  MaybeFault quantisation(std::span<const std::byte> content);
  MaybeFault huffman(std::span<const std::byte> content);
  MaybeFault scan(std::span<const std::byte> content) const;
  /// Goes to the marker that ends the coded data.
  MaybeFault coded();

  std::span<const std::byte> all_;
  ByteReader left_;
  JpegHeader header_;
  std::array<Component, 3> components_{};
  std::array<bool, kMostTables> quantisations_{};
  std::array<std::array<bool, kMostTables>, 2> huffmans_{};  // Of DC and of AC.
};

std::expected<JpegHeader, Fault> Gate::check() {
  if (all_.size() > sensor::kMaxPayload) return std::unexpected(Fault::overlong);
  const auto begin = left_.take(2);
  if (begin.empty()) return std::unexpected(Fault::truncated);
  if (begin[0] != jpeg::kMark || begin[1] != jpeg::kStartOfPicture) return std::unexpected(Fault::not_a_jpeg);
  while (true) {
    if (left_.left() > 0 && all_[all_.size() - left_.left()] != jpeg::kMark)
      return std::unexpected(Fault::not_a_jpeg);
    const auto code = next_code();
    if (!code || *code == jpeg::kEndOfPicture) return std::unexpected(Fault::truncated);
    if (!jpeg::has_length(*code)) return std::unexpected(Fault::not_a_jpeg);
    const auto length = left_.big<std::uint16_t>();
    if (!left_.ok()) return std::unexpected(Fault::truncated);
    if (length < 2) return std::unexpected(Fault::not_a_jpeg);
    const auto content = left_.take(length - 2U);
    if (!left_.ok()) return std::unexpected(Fault::truncated);
    if (const MaybeFault fault = segment(*code, content)) return std::unexpected(*fault);
    if (*code != jpeg::kStartOfScan) continue;
    if (const MaybeFault fault = coded()) return std::unexpected(*fault);
    header_.bytes = all_.size() - left_.left();
    return header_;
  }
}

std::optional<std::byte> Gate::next_code() {
  std::byte code = jpeg::kMark;
  do {
    const auto one = left_.take(1);
    if (one.empty()) return std::nullopt;
    code = one.front();
  } while (code == jpeg::kMark);
  return code;
}

MaybeFault Gate::segment(std::byte code, std::span<const std::byte> content) {
  if (code == jpeg::kQuantisation) return quantisation(content);
  if (code == jpeg::kHuffmanTables) return huffman(content);
  if (code == jpeg::kStartOfScan) return scan(content);
  if (code == jpeg::kArithmeticConditions) return Fault::arithmetic;
  if (code == jpeg::kHierarchy) return Fault::hierarchical;
  if (code >= jpeg::kBaseline && code <= jpeg::kLastOfFrames) return frame(code, content);
  return std::nullopt;
}

MaybeFault Gate::frame(std::byte code, std::span<const std::byte> content) {
  if (header_.components != 0) return Fault::repeated_size;
  if (code == jpeg::kReserved) return Fault::not_a_jpeg;
  if (code >= jpeg::kArithmeticFrames) return Fault::arithmetic;
  if (code == jpeg::kProgressive) return Fault::progressive;
  if (code == jpeg::kLossless) return Fault::lossless;
  if (code != jpeg::kBaseline && code != jpeg::kExtended) return Fault::hierarchical;
  ByteReader reader(content);
  const auto bits = reader.little<std::uint8_t>();
  header_.height = reader.big<std::uint16_t>();
  header_.width = reader.big<std::uint16_t>();
  header_.components = reader.little<std::uint8_t>();
  if (!reader.ok()) return Fault::not_a_jpeg;
  if (bits != 8) return Fault::bits;
  if (header_.width == 0 || header_.height == 0) return Fault::no_size;
  if (header_.width > kMaxPictureWidth || header_.height > kMaxPictureHeight) return Fault::too_large;
  if (header_.components != 1 && header_.components != 3) return Fault::components;
  for (int i = 0; i < header_.components; ++i) {
    Component& component = components_[static_cast<std::size_t>(i)];
    component.id = reader.little<std::uint8_t>();
    const auto sampling = reader.little<std::uint8_t>();
    component.quantisation = reader.little<std::uint8_t>();
    for (const int factor : {sampling >> 4, sampling & 15})
      if (factor < 1 || factor > kMostSampling) return Fault::sampling;
    if (component.quantisation >= kMostTables) return Fault::tables;
    for (int j = 0; j < i; ++j)
      if (components_[static_cast<std::size_t>(j)].id == component.id) return Fault::components;
  }
  if (!reader.ok() || reader.left() != 0) return Fault::not_a_jpeg;
  return std::nullopt;
}

MaybeFault Gate::quantisation(std::span<const std::byte> content) {
  for (ByteReader reader(content); reader.left() > 0;) {
    const auto kind = reader.little<std::uint8_t>();
    const unsigned wide = kind >> 4U;
    const std::size_t table = kind & 15U;
    if (wide > 1 || table >= kMostTables) return Fault::not_a_jpeg;
    if (reader.take(kQuantisationSteps << wide).empty()) return Fault::not_a_jpeg;
    quantisations_[table] = true;
  }
  return std::nullopt;
}

MaybeFault Gate::huffman(std::span<const std::byte> content) {
  for (ByteReader reader(content); reader.left() > 0;) {
    const auto kind = reader.little<std::uint8_t>();
    const std::size_t of_ac = kind >> 4U;
    const std::size_t table = kind & 15U;
    if (of_ac > 1 || table >= kMostTables) return Fault::not_a_jpeg;
    std::size_t codes = 0;
    for (std::size_t i = 0; i < kHuffmanLengths; ++i) codes += reader.little<std::uint8_t>();
    if (!reader.ok() || codes > kMostHuffmanCodes || codes > reader.left()) return Fault::not_a_jpeg;
    static_cast<void>(reader.take(codes));
    huffmans_[of_ac][table] = true;
  }
  return std::nullopt;
}

MaybeFault Gate::scan(std::span<const std::byte> content) const {
  if (header_.components == 0) return Fault::no_size;
  ByteReader reader(content);
  if (reader.little<std::uint8_t>() != header_.components)
    return reader.ok() ? Fault::scans : Fault::not_a_jpeg;
  for (int i = 0; i < header_.components; ++i) {
    // A scan has them in the frame's order (T.81, B.2.3).
    const Component& component = components_[static_cast<std::size_t>(i)];
    const auto id = reader.little<std::uint8_t>();
    const auto tables = reader.little<std::uint8_t>();
    const std::size_t dc = tables >> 4U;
    const std::size_t ac = tables & 15U;
    if (!reader.ok() || id != component.id) return Fault::not_a_jpeg;
    if (dc >= kMostTables || ac >= kMostTables || !huffmans_[0][dc] || !huffmans_[1][ac] ||
        !quantisations_[component.quantisation])
      return Fault::tables;
  }
  // Spectral selection and approximation, which only a progressive picture has.
  const auto first = reader.little<std::uint8_t>();
  const auto last = reader.little<std::uint8_t>();
  const auto approximation = reader.little<std::uint8_t>();
  if (!reader.ok() || reader.left() != 0 || first != 0 || last != 63 || approximation != 0)
    return Fault::not_a_jpeg;
  return std::nullopt;
}

MaybeFault Gate::coded() {
  while (true) {
    const auto rest = all_.last(left_.left());
    const auto mark = std::ranges::find(rest, jpeg::kMark);
    static_cast<void>(left_.take(static_cast<std::size_t>(mark - rest.begin())));
    const auto code = next_code();
    if (!code || *code == jpeg::kStartOfPicture) return Fault::truncated;
    if (*code == jpeg::kStuffed || jpeg::is_restart(*code)) continue;
    if (*code == jpeg::kEndOfPicture) return std::nullopt;
    return jpeg::has_length(*code) ? Fault::scans : Fault::not_a_jpeg;
  }
}

}  // namespace

std::expected<JpegHeader, PictureFault> check_jpeg(std::span<const std::byte> picture) {
  return Gate(picture).check();
}

std::string_view name_of(PictureFault fault) {
  constexpr std::array<std::string_view, kPictureFaults> kNames = {
      "not a JPEG",  "truncated", "too long",   "too large",    "no size",       "repeated size",
      "progressive", "lossless",  "arithmetic", "hierarchical", "not of 8 bits", "components",
      "sampling",    "scans",     "tables",     "damaged"};
  return kNames[static_cast<std::size_t>(fault)];
}

}  // namespace mien::headset
