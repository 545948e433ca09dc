#include "mien/train/view_augmentation.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace mien::train {
namespace {

// One sigma of what another mounting does, and how much of the views is changed how.
constexpr double kShift = 0.03, kTurnRad = 0.05, kScale = 0.05;
constexpr double kGamma = 0.25, kBlurred = 0.2, kNoisy = 0.5, kMostNoise = 6, kPatched = 0.15;
/// Sides of a patch, shares of the view's.
constexpr double kLeastPatch = 0.08, kMostPatch = 0.3;

/// As another mounting shows it; what lies outside is the nearest edge.
void move(const ViewLook& look, std::span<std::uint8_t> view, int side, std::vector<std::uint8_t>& memory) {
  memory.assign(view.begin(), view.end());
  const double middle = 0.5 * (side - 1);
  const double dx = middle + look.right * side, dy = middle + look.down * side;
  const auto c = static_cast<float>(look.scale * std::cos(look.turn_rad)),
             s = static_cast<float>(look.scale * std::sin(look.turn_rad));
  const int last = side - 1;
  const auto at = [&](int x, int y) {
    return static_cast<float>(
        memory[static_cast<std::size_t>(std::clamp(y, 0, last) * side + std::clamp(x, 0, last))]);
  };
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const auto u = static_cast<float>(x - middle), v = static_cast<float>(y - middle);
      const float fx = c * u - s * v + static_cast<float>(dx), fy = s * u + c * v + static_cast<float>(dy);
      const int x0 = static_cast<int>(std::floor(fx)), y0 = static_cast<int>(std::floor(fy));
      const float a = fx - static_cast<float>(x0), b = fy - static_cast<float>(y0);
      view[static_cast<std::size_t>(y * side + x)] =
          static_cast<std::uint8_t>((1 - b) * ((1 - a) * at(x0, y0) + a * at(x0 + 1, y0)) +
                                    b * ((1 - a) * at(x0, y0 + 1) + a * at(x0 + 1, y0 + 1)) + 0.5F);
    }
}

void blur(std::span<std::uint8_t> view, int side, std::vector<std::uint8_t>& memory) {
  memory.assign(view.begin(), view.end());
  for (int y = 1; y + 1 < side; ++y)
    for (int x = 1; x + 1 < side; ++x) {
      const auto p = static_cast<std::size_t>(y * side + x), row = static_cast<std::size_t>(side);
      view[p] = static_cast<std::uint8_t>(
          (4 * memory[p] + 2 * (memory[p - 1] + memory[p + 1] + memory[p - row] + memory[p + row]) +
           memory[p - row - 1] + memory[p - row + 1] + memory[p + row - 1] + memory[p + row + 1] + 8) /
          16);
    }
}

}  // namespace

ViewLook draw_look(Random& random) {
  ViewLook look;
  look.turn_rad = random.normal(0, kTurnRad);
  look.scale = random.log_normal(kScale);
  look.right = random.normal(0, kShift);
  look.down = random.normal(0, kShift);
  look.gamma = random.log_normal(kGamma);
  look.is_blurred = random.chance(kBlurred);
  return look;
}

void show_as(const ViewLook& look, std::span<std::uint8_t> view, int side,
             std::vector<std::uint8_t>& memory) {
  move(look, view, side, memory);
  if (look.is_blurred) blur(view, side, memory);
  std::array<std::uint8_t, 256> shown{};
  for (std::size_t i = 0; i < shown.size(); ++i)
    shown[i] =
        static_cast<std::uint8_t>(std::lround(255 * std::pow(static_cast<double>(i) / 255, look.gamma)));
  for (std::uint8_t& pixel : view) pixel = shown[pixel];
}

void spoil_view(std::span<std::uint8_t> view, int side, Random& random) {
  if (random.chance(kNoisy)) {
    // Even noise of the same spread is as good here, and takes one draw for eight pixels.
    const auto most = static_cast<int>(1 + random.uniform(0, kMostNoise) * 1.7);
    for (std::size_t p = 0; p < view.size(); p += 8) {
      std::uint64_t bits = random.bits();
      for (std::size_t k = p; k < std::min(view.size(), p + 8); ++k, bits >>= 8U)
        view[k] = static_cast<std::uint8_t>(
            std::clamp(int{view[k]} + (static_cast<int>(bits & 255U) - 128) * most / 128, 0, 255));
    }
  }
  if (random.chance(kPatched)) {
    const auto size = [&] { return static_cast<int>(side * random.uniform(kLeastPatch, kMostPatch)); };
    const int width = size(), height = size();
    const auto left = static_cast<int>(random.below(static_cast<std::uint64_t>(side - width)));
    const auto top = static_cast<int>(random.below(static_cast<std::uint64_t>(side - height)));
    const auto level = static_cast<std::uint8_t>(random.below(256));
    for (int y = top; y < top + height; ++y) std::fill_n(view.begin() + y * side + left, width, level);
  }
}

}  // namespace mien::train
