#include "mien/phone/shape_set.h"

#include <array>

#include "mien/core/bytes.h"

namespace mien::phone {
namespace {

std::uint32_t checksum_of_names(ShapeSet set) {
  ByteWriter names;
  for (std::size_t i = 0; i < count_of(set); ++i) {
    names.append(shape_name(set, i));
    names.little('\n');
  }
  return crc32(names.bytes());
}

}  // namespace

std::optional<ShapeSet> shape_set(std::uint8_t number) {
  return number < kShapeSetCount ? std::optional(static_cast<ShapeSet>(number)) : std::nullopt;
}

const face::ProfileMap* map_of(ShapeSet set) {
  using face::OutsideProfile;
  switch (set) {
    case ShapeSet::ict53:
      return nullptr;
    case ShapeSet::arkit52:
      return &face::profile_map(OutsideProfile::arkit52);
    case ShapeSet::openxr_fb_63:
      return &face::profile_map(OutsideProfile::openxr_fb_63);
    case ShapeSet::openxr_fb_70:
      return &face::profile_map(OutsideProfile::openxr_fb_70);
    case ShapeSet::refa_64:
      return &face::profile_map(OutsideProfile::refa_64);
    case ShapeSet::unified:
      return &face::profile_map(OutsideProfile::unified);
  }
  return nullptr;
}

std::string_view name_of(ShapeSet set) {
  const face::ProfileMap* const map = map_of(set);
  return map == nullptr ? "ict53" : map->name;
}

std::size_t count_of(ShapeSet set) {
  const face::ProfileMap* const map = map_of(set);
  return map == nullptr ? face::kInnerCount : map->shapes.size();
}

std::string_view shape_name(ShapeSet set, std::size_t i) {
  const face::ProfileMap* const map = map_of(set);
  return map == nullptr ? face::inner_name(i) : map->shapes[i];
}

std::uint32_t names_checksum(ShapeSet set) {
  static const auto checksums = [] {
    std::array<std::uint32_t, kShapeSetCount> all{};
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = checksum_of_names(static_cast<ShapeSet>(i));
    return all;
  }();
  return checksums[static_cast<std::size_t>(set)];
}

}  // namespace mien::phone
