#include "mien/headset/network_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "mien/headset/grey_levels.h"
#include "mien/headset/jpeg_gate.h"

namespace mien::headset {
namespace {

constexpr int kMaxSide = 512;
constexpr float kNoContrast = 0.5F;
/// Pixels of a picture that one of the view has at least, either way. Lower: a picture that is decoded at
/// half its size does more often, for half the time; the view is softer.
constexpr double kLeastPixels = 0.9;

/// Where in the view the first pixel of what was cut out stands, and the ones to its right and below it.
struct Layout {
  std::ptrdiff_t origin, right, down;
};

Layout layout_of(std::ptrdiff_t side, int quarter_turns, bool mirror) {
  const std::array<Layout, 4> layouts = {
      {{0, 1, side}, {side - 1, side, -1}, {side * side - 1, -1, -side}, {side * (side - 1), -side, 1}}};
  Layout layout = layouts[static_cast<std::size_t>(quarter_turns)];
  if (!mirror) return layout;
  layout.origin += side - 1 - 2 * (layout.origin % side);
  (quarter_turns % 2 == 0 ? layout.right : layout.down) *= -1;
  return layout;
}

std::uint8_t step_of(float share) {
  return static_cast<std::uint8_t>(share * 255 + 0.5F);
}

}  // namespace

std::pair<int, int> least_size(const NetworkViewSettings& settings) {
  const auto pixels = [&](double share) {
    return static_cast<int>(std::ceil(kLeastPixels * settings.side / share));
  };
  return {pixels(settings.right - settings.left), pixels(settings.bottom - settings.top)};
}

Result<NetworkView> NetworkView::create(const NetworkViewSettings& settings) {
  const auto bad = [](const char* what, const char* fix) {
    return fail(ErrorCode::out_of_range, what, "a camera's view", fix);
  };
  if (settings.side < 1 || settings.side > kMaxSide) return bad("its side", "1 to 512 pixels");
  if (settings.quarter_turns < 0 || settings.quarter_turns > 3)
    return bad("its turns", "0 to 3 quarter turns");
  // Written so that numbers that are none are refused.
  for (const auto& [from, to] :
       {std::pair(settings.left, settings.right), std::pair(settings.top, settings.bottom)})
    if (!(from >= 0 && to <= 1 && to - from >= 0.01))
      return bad("what is cut out of the picture", "shares of it, 0 to 1, a hundredth at least");
  return NetworkView(settings);
}

NetworkView::NetworkView(const NetworkViewSettings& settings)
    : settings_(settings),
      columns_(static_cast<std::size_t>(settings.side)),
      rows_(columns_.size()),
      row_(kMaxPictureWidth),
      view_(columns_.size() * columns_.size()),
      steps_(view_.size()) {}

void NetworkView::cover(int pixels, double from, double to, std::span<Cover> covers) {
  const double begin = from * pixels;
  const double step = (to - from) * pixels / static_cast<double>(covers.size());
  for (std::size_t i = 0; i < covers.size(); ++i) {
    const double first = begin + static_cast<double>(i) * step;
    const double last = begin + static_cast<double>(i + 1) * step;
    Cover& one = covers[i];
    one.first = std::clamp(static_cast<int>(std::floor(first)), 0, pixels - 1);
    const int end = std::clamp(static_cast<int>(std::ceil(last)), one.first + 1, pixels);
    one.count = end - one.first;
    one.middle_share = static_cast<float>(1 / step);
    one.first_share = one.count == 1 ? 1.0F : static_cast<float>((one.first + 1 - first) / step);
    one.last_share = one.count == 1 ? 0.0F : static_cast<float>((last - (end - 1)) / step);
  }
}

void NetworkView::average(const GreyPicture& picture) {
  if (picture.width != width_ || picture.height != height_) {
    width_ = picture.width;
    height_ = picture.height;
    cover(width_, settings_.left, settings_.right, columns_);
    cover(height_, settings_.top, settings_.bottom, rows_);
  }
  const auto side = static_cast<std::ptrdiff_t>(settings_.side);
  const auto left = static_cast<std::size_t>(columns_.front().first);
  const auto right = static_cast<std::size_t>(columns_.back().first + columns_.back().count);
  const auto share_of = [](const Cover& cover, int i) {
    if (i == 0) return cover.first_share;
    return i + 1 == cover.count ? cover.last_share : cover.middle_share;
  };
  const Layout layout = layout_of(side, settings_.quarter_turns, settings_.mirror);
  for (std::ptrdiff_t y = 0; y < side; ++y) {
    const Cover& rows = rows_[static_cast<std::size_t>(y)];
    std::fill(row_.begin() + static_cast<std::ptrdiff_t>(left),
              row_.begin() + static_cast<std::ptrdiff_t>(right), 0.0F);
    for (int i = 0; i < rows.count; ++i) {
      const float share = share_of(rows, i) / 255;
      const std::uint8_t* const pixels =
          picture.pixels.data() + static_cast<std::size_t>(rows.first + i) * static_cast<std::size_t>(width_);
      for (std::size_t x = left; x < right; ++x) row_[x] += share * static_cast<float>(pixels[x]);
    }
    std::ptrdiff_t place = layout.origin + y * layout.down;
    for (const Cover& columns : columns_) {
      const float* const pixels = row_.data() + columns.first;
      float middle = 0;
      for (int i = 1; i + 1 < columns.count; ++i) middle += pixels[i];
      const float ends = columns.first_share * pixels[0] + columns.last_share * pixels[columns.count - 1];
      view_[static_cast<std::size_t>(place)] = std::clamp(ends + columns.middle_share * middle, 0.0F, 1.0F);
      place += layout.right;
    }
  }
}

void NetworkView::see(const GreyPicture& picture) {
  average(picture);
  std::ranges::transform(view_, steps_.begin(), step_of);
  GreyLevels levels;
  levels.add(steps_);
  const float dark = levels.percentile(2);
  const float contrast = levels.percentile(98) - dark;
  if (contrast < kLeastContrast) {
    std::ranges::fill(view_, kNoContrast);
    return;
  }
  const float stretch = 1 / contrast;
  for (float& pixel : view_) pixel = std::clamp((pixel - dark) * stretch, 0.0F, 1.0F);
}

void NetworkView::make(const GreyPicture& picture, std::span<float> view) {
  see(picture);
  std::ranges::copy(view_, view.begin());
}

void NetworkView::make(const GreyPicture& picture, std::span<std::uint8_t> view) {
  see(picture);
  std::ranges::transform(view_, view.begin(), step_of);
}

}  // namespace mien::headset
