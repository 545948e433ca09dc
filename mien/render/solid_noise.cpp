#include "mien/render/solid_noise.h"

#include <algorithm>
#include <array>
#include <vector>

namespace mien::render {
namespace {

constexpr int kPeriod = 8, kEntries = 4;  // Units, and table entries in one of them.
constexpr int kSide = kPeriod * kEntries;

/// solid_noise() on a grid, made to repeat: near its end each noise fades into that of before its beginning.
class NoiseTable {
 public:
  NoiseTable() : entry_(static_cast<std::size_t>(kSide) * kSide * kSide) {
    for (int z = 0; z < kSide; ++z)
      for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) {
          const Vec3f p =
              Vec3f(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)) / kEntries;
          entry_[at(x, y, z)] = {repeating(p, Vec3f::Zero()), repeating(p, Vec3f(31, 7, 3)),
                                 repeating(p, Vec3f(5, 47, 19)), 0};
        }
  }

  [[nodiscard]] Vec3f operator()(const Vec3f& p) const {
    const Vec3f q = p * kEntries;
    const Vec3f base = q.array().floor();
    const Vec3f f = q - base;
    const std::array<int, 3> low = {static_cast<int>(base.x()), static_cast<int>(base.y()),
                                    static_cast<int>(base.z())};
    const auto along_x = [&](int dy, int dz) -> Entry {
      const Entry& a = entry_[at(low[0], low[1] + dy, low[2] + dz)];
      const Entry& b = entry_[at(low[0] + 1, low[1] + dy, low[2] + dz)];
      return a + f.x() * (b - a);
    };
    const Entry near_low = along_x(0, 0), near_high = along_x(1, 0), far_low = along_x(0, 1),
                far_high = along_x(1, 1);
    const Entry near = near_low + f.y() * (near_high - near_low),
                far = far_low + f.y() * (far_high - far_low);
    return (near + f.z() * (far - near)).head<3>();
  }

 private:
  using Entry = Eigen::Array4f;
  static std::size_t at(int x, int y, int z) {
    constexpr int kMask = kSide - 1;
    return static_cast<std::size_t>(((z & kMask) * kSide + (y & kMask)) * kSide + (x & kMask));
  }
  /// Over the last unit along each axis, from the noise there to that a period before.
  static float repeating(const Vec3f& p, const Vec3f& offset) {
    float sum = 0;
    const auto share = [&](Eigen::Index axis) { return std::max(0.0F, p[axis] - (kPeriod - 1)); };
    for (int corner = 0; corner < 8; ++corner) {
      float weight = 1;
      Vec3f q = p + offset;
      for (Eigen::Index axis = 0; axis < 3; ++axis) {
        const bool before = (corner >> axis & 1) != 0;
        weight *= before ? share(axis) : 1 - share(axis);
        if (before) q[axis] -= kPeriod;
      }
      if (weight > 0) sum += weight * solid_noise(q);
    }
    return sum;
  }
  std::vector<Entry> entry_;
};

}  // namespace

Vec3f solid_noises(const Vec3f& p) {
  static const NoiseTable kTable;
  return kTable(p);
}

}  // namespace mien::render
