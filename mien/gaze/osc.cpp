#include "mien/gaze/osc.h"

#include <fmt/format.h>

#include <optional>

#include "mien/core/bytes.h"

namespace mien::gaze {
namespace {

constexpr std::string_view kBundle("#bundle\0", 8);
constexpr std::size_t kTimeTagBytes = 8;
const char* const kOsc = "OSC datagram";

/// A string that ends with 00 and fills words of four bytes.
Result<std::string_view> read_text(ByteReader& reader, std::span<const std::byte> rest) {
  const std::string_view text = as_text(rest.last(reader.left()));
  const std::size_t length = text.find('\0');
  if (length == std::string_view::npos) return fail(ErrorCode::truncated, "a string does not end", kOsc);
  static_cast<void>(reader.take(length / 4 * 4 + 4));
  if (!reader.ok()) return fail(ErrorCode::truncated, "a string's padding is cut short", kOsc);
  return text.substr(0, length);
}

Result<void> read_blob(ByteReader& reader) {
  // Compared before the padding is added: a length near 2^32 would wrap.
  const auto length = reader.big<std::uint32_t>();
  if (length > reader.left()) return fail(ErrorCode::truncated, "a blob is longer than its datagram", kOsc);
  static_cast<void>(reader.take((length + 3U) / 4U * 4U));
  return {};
}

/// The value of a type tag that is a number; none of another.
std::optional<double> read_number(char tag, ByteReader& reader) {
  switch (tag) {
    case 'i':
      return reader.big<std::int32_t>();
    case 'f':
      return reader.big<float>();
    case 'h':
      return static_cast<double>(reader.big<std::int64_t>());
    case 'd':
      return reader.big<double>();
    default:
      return std::nullopt;
  }
}

Result<void> pass_over(char tag, ByteReader& reader, std::span<const std::byte> rest) {
  switch (tag) {
    case 's':
    case 'S': {
      MIEN_TRY(read_text(reader, rest));
      return {};
    }
    case 'b':
      return read_blob(reader);
    case 't':
      static_cast<void>(reader.take(kTimeTagBytes));
      return {};
    case 'c':
    case 'r':
    case 'm':
      static_cast<void>(reader.take(4));
      return {};
    case 'T':
    case 'F':
    case 'N':
    case 'I':
    case '[':
    case ']':
      return {};
    default:
      return fail(ErrorCode::malformed, "a type tag that OSC does not have", kOsc);
  }
}

Result<void> read_message(std::span<const std::byte> bytes, OscListener& listener) {
  ByteReader reader(bytes);
  OscMessage message;
  MIEN_TRY_ASSIGN(message.address, read_text(reader, bytes));
  if (!message.address.starts_with('/')) return fail(ErrorCode::malformed, "no address", kOsc);
  MIEN_TRY_ASSIGN(const std::string_view tags, read_text(reader, bytes));
  if (!tags.starts_with(',')) return fail(ErrorCode::malformed, "no type tags", kOsc);
  message.types = tags.substr(1);
  message.numeric = true;
  for (const char tag : tags.substr(1)) {
    if (const auto number = read_number(tag, reader)) {
      if (message.count < kMostNumbers) message.numbers[message.count] = *number;
    } else {
      message.numeric = false;
      MIEN_TRY(pass_over(tag, reader, bytes));
    }
    ++message.count;
  }
  if (!reader.ok()) return fail(ErrorCode::truncated, "arguments are cut short", kOsc);
  if (reader.left() > 0) return fail(ErrorCode::malformed, "more arguments than type tags", kOsc);
  return listener.hear(message);
}

Result<void> read_element(std::span<const std::byte> bytes, int depth, OscListener& listener) {
  if (bytes.size() % 4 != 0) return fail(ErrorCode::malformed, "no whole words of four bytes", kOsc);
  if (!as_text(bytes).starts_with(kBundle)) return read_message(bytes, listener);
  if (depth >= kMostBundles)
    return fail(ErrorCode::malformed, fmt::format("bundles in more than {} levels", kMostBundles), kOsc);
  ByteReader reader(bytes);
  static_cast<void>(reader.take(kBundle.size() + kTimeTagBytes));
  while (reader.left() > 0) {
    const auto size = reader.big<std::uint32_t>();
    if (!reader.ok() || size > reader.left())
      return fail(ErrorCode::truncated, "an element is longer than its bundle", kOsc);
    MIEN_TRY(read_element(reader.take(size), depth + 1, listener));
  }
  if (!reader.ok()) return fail(ErrorCode::truncated, "a bundle without its time tag", kOsc);
  return {};
}

}  // namespace

bool is_osc(std::span<const std::byte> datagram) {
  const std::string_view text = as_text(datagram);
  return text.starts_with(kBundle) || (text.starts_with('/') && text.find('\0') != std::string_view::npos);
}

Result<void> read_osc(std::span<const std::byte> datagram, OscListener& listener) {
  return read_element(datagram, 0, listener);
}

}  // namespace mien::gaze
