#pragma once

#include <gtest/gtest.h>
#include <zlib.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <vector>

#include "mien/core/bytes.h"
#include "tests/project_path.h"

// Packets of Live Link Face that a phone and a known tool have sent. The recordings are not part of this
// project: where they are missing a test says so.
namespace mien {

inline std::filesystem::path livelink_packets() {
  const char* const named = std::getenv("MIEN_LIVELINK_PACKETS");
  return named != nullptr ? named : project_path("../shared/data/livelink_packets");
}

inline std::vector<std::byte> unzipped(const std::filesystem::path& path) {
  std::vector<std::byte> bytes;
  const gzFile file = gzopen(path.c_str(), "rb");
  EXPECT_NE(file, nullptr) << path;
  if (file == nullptr) return bytes;
  std::array<std::byte, 65536> piece;
  for (int size = 0; (size = gzread(file, piece.data(), piece.size())) > 0;)
    bytes.insert(bytes.end(), piece.begin(), piece.begin() + size);
  gzclose(file);
  return bytes;
}

/// Version, count, then each packet behind its size.
inline std::vector<std::vector<std::byte>> captured_packets(const std::filesystem::path& path) {
  const auto bytes = unzipped(path);
  ByteReader reader(bytes);
  EXPECT_EQ(reader.big<std::uint8_t>(), 6);
  const auto count = reader.big<std::uint32_t>();
  std::vector<std::vector<std::byte>> packets;
  for (std::uint32_t i = 0; i < count && reader.ok(); ++i) {
    const auto one = reader.take(reader.big<std::uint32_t>());
    packets.emplace_back(one.begin(), one.end());
  }
  EXPECT_EQ(reader.left(), 0u);
  return packets;
}

}  // namespace mien
