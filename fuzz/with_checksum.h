#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "mien/core/bytes.h"

/// Calls `check` with an input as it is, and once more with its last four bytes, the checksum, put right:
/// hardly any input would get past it otherwise.
template <class Check>
void with_checksum(const std::uint8_t* data, std::size_t size, Check check) {
  const auto bytes = std::as_bytes(std::span(data, size));
  check(bytes);
  if (size < 4) return;
  mien::ByteWriter writer;
  writer.append(bytes.first(size - 4));
  writer.little(mien::crc32(bytes.first(size - 4)));
  check(writer.bytes());
}
