#include "mien/face/ict_cache.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "mien/core/bytes.h"
#include "mien/core/files.h"
#include "mien/core/sha256.h"

namespace mien::face {
namespace fs = std::filesystem;
namespace {

inline constexpr std::string_view kMagic = "MIENICT\n";
/// Raise it whenever the layout below changes, or what the import makes of the same files.
inline constexpr std::uint32_t kVersion = 2;

// The cache never leaves the machine that wrote it, so plain arrays go as they lie in memory; the version
// word, read in native order, refuses a file from a machine of the other byte order.
static_assert(sizeof(Vec3f) == 12 && sizeof(std::array<std::uint32_t, 3>) == 12);

void put_text(ByteWriter& out, std::string_view text) {
  out.little(static_cast<std::uint32_t>(text.size()));
  out.append(text);
}

template <class T>
void put_all(ByteWriter& out, const std::vector<T>& values) {
  out.little(static_cast<std::uint32_t>(values.size()));
  out.append(std::as_bytes(std::span(values)));
}

std::string take_text(ByteReader& in) {
  const auto bytes = in.take(in.little<std::uint32_t>());
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Never more than the bytes that are there: take() gives none when fewer are left.
template <class T>
void take_all(ByteReader& in, std::vector<T>& values) {
  const auto bytes = in.take(sizeof(T) * in.little<std::uint32_t>());
  values.resize(bytes.size() / sizeof(T));
  if (!bytes.empty()) std::memcpy(static_cast<void*>(values.data()), bytes.data(), bytes.size());
}

bool all_finite(std::span<const Vec3f> vectors) {
  return std::ranges::all_of(vectors, [](const Vec3f& v) { return v.allFinite(); });
}

/// The checksum tells chance damage; this tells a file that someone made up.
bool is_sound(const IctModel& model) {
  const Face& face = model.face;
  const auto inside = [n = face.neutral_m.size()](std::uint32_t vertex) { return vertex < n; };
  if (!all_finite(face.neutral_m)) return false;
  for (const auto& triangle : face.triangles)
    if (!std::ranges::all_of(triangle, inside)) return false;
  std::size_t triangles = 0;
  for (const Part& part : face.parts) {
    if (part.first_triangle != triangles) return false;
    triangles += part.triangle_count;
  }
  if (triangles != face.triangles.size() || face.shapes.size() != kShapeCount) return false;
  for (std::size_t k = 0; k < kShapeCount; ++k) {
    const Shape& s = face.shapes[k];
    if (s.name != kShapeNames[k] || s.vertex.size() != s.delta_m.size() || !all_finite(s.delta_m))
      return false;
    if (!std::ranges::all_of(s.vertex, inside)) return false;
  }
  if (!std::ranges::all_of(face.landmarks, inside)) return false;
  for (const Region& region : face.regions)
    if (!std::ranges::all_of(region.vertex, inside)) return false;
  for (const Eyeball& eye : face.eyes)
    if (std::uint64_t{eye.first_vertex} + eye.vertex_count > face.neutral_m.size() ||
        !eye.centre_m.allFinite())
      return false;
  return std::ranges::all_of(model.identities, [&](const IctIdentity& identity) {
    return identity.delta_m.size() == face.neutral_m.size() && all_finite(identity.delta_m);
  });
}

}  // namespace

std::string fingerprint(std::span<const fs::path> files) {
  Sha256 hash;
  for (const fs::path& file : files) {
    std::error_code code;
    const auto size = fs::file_size(file, code);
    const auto changed = fs::last_write_time(file, code);
    const std::string line =
        fmt::format("{}\t{}\t{}\n", file.string(), size, code ? 0 : changed.time_since_epoch().count());
    hash.add(std::as_bytes(std::span(line)));
  }
  return hash.hex();
}

fs::path cache_path(const fs::path& folder, const IctOptions& options) {
  const fs::path base = options.cache_folder.empty() ? cache_folder() : options.cache_folder;
  if (base.empty()) return {};
  // One file a folder: what the folder becomes later takes the place of what it was.
  Sha256 hash;
  const std::string path = folder.string();
  hash.add(std::as_bytes(std::span(path)));
  return base /
         fmt::format("ict-{}{}.bin", hash.hex().substr(0, 16), options.identities ? "-identities" : "");
}

std::vector<std::byte> encode_cache(const IctModel& model, std::string_view key) {
  const Face& face = model.face;
  ByteWriter out;
  out.append(kMagic);
  out.append(std::as_bytes(std::span(&kVersion, 1)));
  put_text(out, key);
  put_text(out, face.name);
  put_all(out, face.neutral_m);
  put_all(out, face.triangles);
  out.little(static_cast<std::uint32_t>(face.parts.size()));
  for (const Part& part : face.parts) {
    put_text(out, part.name);
    out.little(static_cast<std::uint8_t>(part.material));
    out.little(part.first_triangle);
    out.little(part.triangle_count);
  }
  out.little(static_cast<std::uint32_t>(face.shapes.size()));
  for (const Shape& s : face.shapes) {
    put_text(out, s.name);
    put_all(out, s.vertex);
    put_all(out, s.delta_m);
  }
  for (const std::uint32_t vertex : face.landmarks) out.little(vertex);
  out.little(static_cast<std::uint32_t>(face.regions.size()));
  for (const Region& region : face.regions) {
    put_text(out, region.name);
    put_all(out, region.vertex);
  }
  for (const Eyeball& eye : face.eyes) {
    out.little(eye.first_vertex);
    out.little(eye.vertex_count);
    for (int axis = 0; axis < 3; ++axis) out.little(eye.centre_m[axis]);
  }
  out.little(static_cast<std::uint32_t>(model.identities.size()));
  for (const IctIdentity& identity : model.identities) {
    put_text(out, identity.name);
    put_all(out, identity.delta_m);
  }
  out.little(crc32(out.bytes()));
  return out.release();
}

std::optional<IctModel> decode_cache(std::span<const std::byte> bytes, std::string_view key) {
  if (bytes.size() < kMagic.size() + 8) return std::nullopt;
  const auto content = bytes.first(bytes.size() - 4);
  if (ByteReader(bytes.last(4)).little<std::uint32_t>() != crc32(content)) return std::nullopt;
  ByteReader in(content);
  const auto magic = in.take(kMagic.size());
  if (std::memcmp(magic.data(), kMagic.data(), kMagic.size()) != 0) return std::nullopt;
  std::uint32_t version = 0;
  std::memcpy(&version, in.take(sizeof(version)).data(), sizeof(version));
  if (version != kVersion || take_text(in) != key) return std::nullopt;

  IctModel model;
  Face& face = model.face;
  face.name = take_text(in);
  face.origin = Origin::ict;
  take_all(in, face.neutral_m);
  take_all(in, face.triangles);
  for (auto left = in.little<std::uint32_t>(); left > 0 && in.ok(); --left) {
    Part& part = face.parts.emplace_back();
    part.name = take_text(in);
    part.material = static_cast<Material>(std::min(in.little<std::uint8_t>(), std::uint8_t{12}));
    part.first_triangle = in.little<std::uint32_t>();
    part.triangle_count = in.little<std::uint32_t>();
  }
  for (auto left = in.little<std::uint32_t>(); left > 0 && in.ok(); --left) {
    Shape& s = face.shapes.emplace_back();
    s.name = take_text(in);
    take_all(in, s.vertex);
    take_all(in, s.delta_m);
  }
  for (std::uint32_t& vertex : face.landmarks) vertex = in.little<std::uint32_t>();
  face.has_landmarks = true;
  for (auto left = in.little<std::uint32_t>(); left > 0 && in.ok(); --left) {
    Region& region = face.regions.emplace_back();
    region.name = take_text(in);
    take_all(in, region.vertex);
  }
  for (Eyeball& eye : face.eyes) {
    eye.first_vertex = in.little<std::uint32_t>();
    eye.vertex_count = in.little<std::uint32_t>();
    for (int axis = 0; axis < 3; ++axis) eye.centre_m[axis] = in.little<float>();
  }
  for (auto left = in.little<std::uint32_t>(); left > 0 && in.ok(); --left) {
    IctIdentity& identity = model.identities.emplace_back();
    identity.name = take_text(in);
    take_all(in, identity.delta_m);
  }
  if (!in.ok() || in.left() != 0 || !is_sound(model)) return std::nullopt;
  return model;
}

}  // namespace mien::face
