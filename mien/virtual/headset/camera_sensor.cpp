#include "mien/virtual/headset/camera_sensor.h"

#include <algorithm>
#include <cmath>

namespace mien::virt {
namespace {

constexpr std::size_t kNoise = 1U << 16U;
/// The blur is given for pictures of this width.
constexpr double kUsualWidth = 240;
/// Exposure control looks no farther than these factors.
constexpr double kMostGain = 40, kLeastGain = 1.0 / 40;
/// Grease spreads light over this share of the picture's width.
constexpr double kSpread = 0.08;

}  // namespace

CameraSensor::CameraSensor(const HeadsetFaults& faults, PictureSize size, float distance_m, float pixel,
                           double usual, Random random)
    : faults_(faults), size_(size), random_(random.fork("pictures")) {
  Random lens = random.fork("lens"), sensor = random.fork("sensor");
  const double vignetting = lens.uniform(faults.vignetting[0], faults.vignetting[1]);
  const double half = 0.5 * std::hypot(size.width, size.height);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      const double r = std::hypot(x + 0.5 - 0.5 * size.width, y + 0.5 - 0.5 * size.height);
      const double tangent = r * double{pixel}, cosine2 = 1 / (1 + tangent * tangent);
      const double corner = r / half;
      vignette_.push_back(static_cast<float>(cosine2 * cosine2 * (1 - vignetting * corner * corner)));
    }

  const double scale = size.width / kUsualWidth;
  const double focus_m = 1e-3 * lens.uniform(faults.focus_mm[0], faults.focus_mm[1]);
  const double aperture_m = 1e-3 * lens.uniform(faults.aperture_mm[0], faults.aperture_mm[1]);
  // Half the blur circle, as a Gaussian of equal spread (a disc's is half its radius an axis).
  const double circle = 0.25 * aperture_m * std::abs(1 / double{distance_m} - 1 / focus_m) / double{pixel};
  const double sigma = std::hypot(scale * lens.uniform(faults.blur_px[0], faults.blur_px[1]), circle);
  if (sigma > 0.1) {
    double sum = 0;
    for (int k = 0; k <= static_cast<int>(std::ceil(2.5 * sigma)); ++k) {
      kernel_.push_back(static_cast<float>(std::exp(-0.5 * k * k / (sigma * sigma))));
      sum += (k == 0 ? 1 : 2) * double{kernel_.back()};
    }
    for (float& weight : kernel_) weight /= static_cast<float>(sum);
  }
  smear_ = static_cast<float>(lens.uniform(faults.smear[0], faults.smear[1]));

  target_ = sensor.uniform(faults.target[0], faults.target[1]);
  full_gain_ = target_ / (kAmplified * std::max(usual, 1e-9));
  const double gamma = sensor.uniform(faults.gamma[0], faults.gamma[1]);
  for (std::size_t i = 0; i < developed_.size(); ++i)
    developed_[i] = static_cast<std::uint8_t>(
        std::lround(255 * std::pow(static_cast<double>(i) / (developed_.size() - 1), gamma)));
  const auto pixels = static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
  for (std::size_t p = 0; p < pixels; ++p)
    if (sensor.chance(faults.hot_pixels))
      hot_.push_back({p, static_cast<std::uint8_t>(128 + sensor.below(128))});
  for (std::size_t i = 0; i < kNoise; ++i) noise_.push_back(static_cast<float>(sensor.normal()));
  memory_.resize(pixels);
}

void CameraSensor::blur(std::span<float> picture) {
  const int w = size_.width, h = size_.height, reach = static_cast<int>(kernel_.size()) - 1;
  const auto row = [&](int y) { return static_cast<std::size_t>(y) * static_cast<std::size_t>(w); };
  for (int y = 0; y < h; ++y) {
    const float* from = picture.data() + row(y);
    float* to = memory_.data() + row(y);
    for (int x = 0; x < w; ++x) to[x] = kernel_[0] * from[x];
    for (int k = 1; k <= reach; ++k) {
      const float weight = kernel_[static_cast<std::size_t>(k)];
      const int edge = std::min(k, w);
      for (int x = 0; x < edge; ++x) to[x] += weight * from[0];
      for (int x = edge; x < w; ++x) to[x] += weight * from[x - k];
      for (int x = 0; x < w - edge; ++x) to[x] += weight * from[x + k];
      for (int x = w - edge; x < w; ++x) to[x] += weight * from[w - 1];
    }
  }
  for (int y = 0; y < h; ++y) {
    float* to = picture.data() + row(y);
    for (int x = 0; x < w; ++x) to[x] = kernel_[0] * memory_[row(y) + static_cast<std::size_t>(x)];
    for (int k = 1; k <= reach; ++k) {
      const float weight = kernel_[static_cast<std::size_t>(k)];
      const float* above = memory_.data() + row(std::max(0, y - k));
      const float* below = memory_.data() + row(std::min(h - 1, y + k));
      for (int x = 0; x < w; ++x) to[x] += weight * (above[x] + below[x]);
    }
  }
}

void CameraSensor::spread(std::span<float> picture) {
  // The means of blocks, interpolated: what grease makes of a picture has no detail.
  const int step = std::max(2, static_cast<int>(std::lround(kSpread * size_.width)));
  const int across = (size_.width + step - 1) / step, down = (size_.height + step - 1) / step;
  const auto place = [&](int x, int y) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(size_.width) + static_cast<std::size_t>(x);
  };
  std::ranges::fill(memory_, 0.0F);
  const auto block = [&](int bx, int by) -> float& {
    return memory_[static_cast<std::size_t>(std::clamp(by, 0, down - 1) * across +
                                            std::clamp(bx, 0, across - 1))];
  };
  for (int by = 0; by < down; ++by)
    for (int bx = 0; bx < across; ++bx) {
      float sum = 0;
      int count = 0;
      for (int y = by * step; y < std::min(size_.height, (by + 1) * step); ++y)
        for (int x = bx * step; x < std::min(size_.width, (bx + 1) * step); ++x, ++count)
          sum += picture[place(x, y)];
      block(bx, by) = sum / static_cast<float>(std::max(1, count));
    }
  for (int y = 0; y < size_.height; ++y)
    for (int x = 0; x < size_.width; ++x) {
      const float u = (static_cast<float>(x) + 0.5F) / static_cast<float>(step) - 0.5F;
      const float v = (static_cast<float>(y) + 0.5F) / static_cast<float>(step) - 0.5F;
      const int bx = static_cast<int>(std::floor(u)), by = static_cast<int>(std::floor(v));
      const float a = u - static_cast<float>(bx), b = v - static_cast<float>(by);
      const float veil = (1 - b) * ((1 - a) * block(bx, by) + a * block(bx + 1, by)) +
                         b * ((1 - a) * block(bx, by + 1) + a * block(bx + 1, by + 1));
      float& pixel = picture[place(x, y)];
      pixel += smear_ * (veil - pixel);
    }
}

void CameraSensor::expose(double time_s, std::span<float> radiance, std::span<std::uint8_t> out) {
  for (std::size_t p = 0; p < radiance.size(); ++p) radiance[p] *= vignette_[p];
  if (!kernel_.empty()) blur(radiance);
  if (smear_ > 0) spread(radiance);

  // Every fifth place tells how bright the brightest tenth is.
  seen_.clear();
  for (std::size_t p = 0; p < radiance.size(); p += 5) seen_.push_back(radiance[p]);
  const auto tenth = seen_.begin() + static_cast<std::ptrdiff_t>(seen_.size() * 9 / 10);
  std::ranges::nth_element(seen_, tenth);
  const double wanted = target_ / std::max(double{*tenth}, 1e-9);
  if (gain_ == 0) {
    gain_ = wanted;
  } else {
    const double step = 1 - std::exp(-std::max(0.0, time_s - exposed_s_) / faults_.exposure_s);
    gain_ *= std::pow(std::clamp(wanted / gain_, kLeastGain, kMostGain), step);
  }
  exposed_s_ = time_s;

  const std::size_t from = random_.below(kNoise), stride = 2 * random_.below(kNoise / 2) + 1;
  const double amplified = std::max(1.0, gain_ / full_gain_);
  const auto read = static_cast<float>(amplified * faults_.read_noise / 255);
  const auto shot = static_cast<float>(amplified / faults_.full_well), gain = static_cast<float>(gain_);
  constexpr float kSteps = 4096;
  for (std::size_t p = 0; p < radiance.size(); ++p) {
    const float light = std::min(gain * radiance[p], 4.0F);
    const float noise = std::sqrt(shot * light + read * read) * noise_[(from + stride * p) % kNoise];
    out[p] = developed_[static_cast<std::size_t>(std::clamp(light + noise, 0.0F, 1.0F) * kSteps + 0.5F)];
  }
  for (const HotPixel& hot : hot_) out[hot.place] = std::max(out[hot.place], hot.value);
}

}  // namespace mien::virt
