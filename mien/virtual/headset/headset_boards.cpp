#include "mien/virtual/headset/headset_boards.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "mien/render/image.h"
#include "mien/sensor/payload.h"
#include "mien/virtual/node.h"
#include "mien/virtual/reception.h"

namespace mien::virt {
namespace {

/// A board needs so long to compress a picture and to send 4 to 9 KB by radio, and sometimes longer (mean).
/// Of the whole picture, so it comes on top of what the rows take to be read.
constexpr std::array<double, 2> kWay_s = {0.003, 0.012};
constexpr double kRadio_s = 0.001;

/// The wearer with pictures of this width.
std::unique_ptr<const HeadsetWearer> with_width(const HeadsetWearer& wearer, int width) {
  auto own = std::make_unique<HeadsetWearer>(wearer);
  if (width <= 0) return own;
  for (FittedCamera& camera : own->cameras) {
    auto& [across, down] = camera.mount.size;
    down = std::max(1, static_cast<int>(std::lround(static_cast<double>(width) * down / across)));
    across = width;
  }
  return own;
}

}  // namespace

int jpeg_quality_of(double board) {
  return static_cast<int>(std::clamp(std::lround(103.875 - 2.125 * board), 5L, 97L));
}

HeadsetBoards::HeadsetBoards(const HeadsetWearer& wearer, const HeadsetFaults& faults, const Random& random,
                             const HeadsetFilming& filming)
    : wearer_(with_width(wearer, filming.width)),
      faults_(faults),
      simulator_(
          std::make_unique<HeadsetSimulator>(*wearer_, faults, random.fork("headset"), 0, filming.failure)),
      jitter_(random.fork("jitter")),
      quality_(jpeg_quality_of(random.fork("jpeg").uniform(faults.jpeg_quality[0], faults.jpeg_quality[1]))) {
  for (std::size_t c = 0; c < simulator_->cameras(); ++c) {
    const PictureSize size = simulator_->size(c);
    pixels_.emplace_back(static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height));
  }
  simulator_->put_on();
}

Result<HeadsetBoards> HeadsetBoards::put_on(const HeadsetWearer& wearer, const sensor::Rig& rig,
                                            const HeadsetFaults& faults, const Random& random,
                                            const HeadsetFilming& filming) {
  MIEN_TRY_ASSIGN(const std::vector<sensor::DeviceKey> devices, virtual_devices(rig));
  HeadsetBoards boards(wearer, faults, random, filming);
  std::vector<double> rates_hz;
  for (const FittedCamera& camera : wearer.cameras) {
    const double rate_hz = camera.mount.rate_hz;
    rates_hz.push_back(filming.rate_hz > 0 ? std::min(filming.rate_hz, rate_hz) : rate_hz);
  }
  boards.rate_hz_ = *std::ranges::max_element(rates_hz);
  for (std::size_t c = 0; c < wearer.cameras.size(); ++c) {
    const auto sensor = rig.find(wearer.cameras[c].name);
    if (!sensor)
      return fail(ErrorCode::not_found, fmt::format("the rig has no camera {}", wearer.cameras[c].name),
                  rig.name, "give the rig that the headset was made of");
    const sensor::DeviceKey device = devices[*sensor];
    VirtualClock clock;
    // Cameras of one board have its clock.
    const auto same = std::ranges::find_if(
        boards.cameras_, [&](const Camera& other) { return other.device.device == device.device; });
    if (same != boards.cameras_.end()) {
      clock = same->clock;
    } else {
      clock = VirtualClock::drawn(faults.clock_offset_s, faults.clock_drift_ppm, random.fork("clock", c));
    }
    boards.cameras_.push_back({.device = device,
                               .clock = clock,
                               .exposure_s = 1e-3 * wearer.cameras[c].mount.exposure_ms,
                               .share = rates_hz[c] / boards.rate_hz_,
                               .way_s = random.fork("way", c).uniform(kWay_s[0], kWay_s[1]),
                               .delay = random.fork("delay", c),
                               .loss = random.fork("loss", c),
                               .newest_s = -std::numeric_limits<double>::infinity()});
  }
  // On a little before the performance begins, as all boards; no clock shows less than zero.
  double first_s = -kDeviceMarginS;
  for (const Camera& camera : boards.cameras_) first_s = std::max(first_s, camera.clock.true_s(DeviceTime()));
  boards.shot_ = static_cast<std::int64_t>(std::ceil(first_s * boards.rate_hz_));
  return boards;
}

bool HeadsetBoards::takes_part(const Camera& camera) const {
  const double before = camera.share * static_cast<double>(shot_);
  return std::floor(before + camera.share) > std::floor(before);
}

std::optional<std::array<bool, 2>> HeadsetBoards::seen_in_failure() const {
  if (failing_shots_ == 0) return std::nullopt;
  return std::array{2 * seen_shots_[0] > failing_shots_, 2 * seen_shots_[1] > failing_shots_};
}

void HeadsetBoards::skip() {
  for (Camera& camera : cameras_) camera.sequence += takes_part(camera) ? 1 : 0;
  ++shot_;
}

Result<void> HeadsetBoards::shoot(const std::function<HeadsetMoment(double true_s)>& at,
                                  std::vector<BoardPicture>& out) {
  const double most_s = 0.4 / rate_hz_;
  const double begin_s =
      shot_s() + std::clamp(jitter_.normal(0, 1e-3 * faults_.period_jitter_ms), -most_s, most_s);
  const double rolling_s = 1e-3 * faults_.rolling_ms;
  const HeadsetMoment first = at(begin_s);
  std::vector<std::span<std::uint8_t>> views(pixels_.begin(), pixels_.end());
  simulator_->fail(first.fails);
  const HeadsetTruth truth = simulator_->shoot(begin_s, first.pose, at(begin_s + rolling_s).pose, views);
  if (first.fails) {
    ++failing_shots_;
    for (std::size_t half = 0; half < 2; ++half) seen_shots_[half] += truth.is_visible[half] ? 1 : 0;
  }
  for (std::size_t c = 0; c < cameras_.size(); ++c) {
    Camera& camera = cameras_[c];
    if (!takes_part(camera)) continue;
    BoardPicture picture{.camera = c, .sequence = camera.sequence++, .read_s = begin_s + camera.exposure_s};
    // Drawn for what is lost too, so that loss does not change what becomes of the others.
    camera.newest_s = std::max(
        camera.newest_s, picture.read_s + rolling_s + camera.way_s + camera.delay.exponential(kRadio_s));
    picture.arrival_s = camera.newest_s;
    if (camera.loss.chance(faults_.lost)) continue;
    const PictureSize size = simulator_->size(c);
    MIEN_TRY_ASSIGN(picture.jpeg, render::encode_jpeg(size.width, size.height, render::JpegPixels::grey,
                                                      quality_, pixels_[c]));
    // No board has memory for more either.
    if (picture.jpeg.size() <= sensor::kMaxPayload) out.push_back(std::move(picture));
  }
  ++shot_;
  return {};
}

}  // namespace mien::virt
