#include "mien/sensor/arrival_hold.h"

#include <algorithm>
#include <limits>

namespace mien::sensor {
namespace {

constexpr Duration kWindow = std::chrono::milliseconds(200);
constexpr Duration kBin = std::chrono::milliseconds(4);
/// Later than this is late: exponential delays of 10 ms are so in a fifth of all packets, a good Wi-Fi's in
/// few.
constexpr Duration kLate = std::chrono::milliseconds(15);
/// Later than this is a stall or a clock's trouble, for which no hold is long enough.
constexpr Duration kStalled = std::chrono::milliseconds(250);
/// A window, and the second, are late with a share of one in so many.
constexpr std::uint32_t kOneIn = 5;
constexpr std::size_t kLateWindows = 3;
constexpr double kQuantile = 0.95;
/// By which the hold falls, a window.
constexpr Duration kFall = std::chrono::milliseconds(1);

}  // namespace

void ArrivalHold::count(const Packet& packet, Window& window) {
  if (packet.late > kStalled || window.all == std::numeric_limits<std::uint32_t>::max()) return;
  const auto bin = static_cast<std::size_t>(std::max(packet.late, Duration::zero()) / kBin);
  ++window.packets[std::min(bin, kBins - 1)];
  ++window.all;
  if (packet.late > kLate) ++window.late;
}

std::optional<Duration> ArrivalHold::vote(const Sensor& sensor) {
  std::uint64_t all = 0, late = 0;
  std::size_t late_windows = 0;
  for (const Window& window : sensor.windows) {
    all += window.all;
    late += window.late;
    if (window.late > 1 && window.late >= window.all / kOneIn) ++late_windows;
  }
  if (late_windows < kLateWindows || late * kOneIn < all) return std::nullopt;
  const auto needed = static_cast<std::uint64_t>(kQuantile * static_cast<double>(all)) + 1;
  std::uint64_t sum = 0;
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    for (const Window& window : sensor.windows) sum += window.packets[bin];
    if (sum >= needed) return std::min(static_cast<std::int64_t>(bin + 1) * kBin, kMost);
  }
  return kMost;
}

void ArrivalHold::close_window() {
  Duration most{}, second{};
  for (Sensor& sensor : sensors_) {
    if (const auto asked = vote(sensor)) {
      second = std::max(second, std::min(most, *asked));
      most = std::max(most, *asked);
    }
    std::ranges::copy_backward(sensor.windows.begin(), sensor.windows.end() - 1, sensor.windows.end());
    sensor.windows.front() = {};
  }
  now_ = std::max({second, now_ - kFall, Duration::zero()});
  longest_ = std::max(longest_, now_);
}

void ArrivalHold::add(std::uint16_t sensor, std::uint32_t sequence, HostTime arrival, Duration late) {
  const std::int64_t window = arrival.time_since_epoch() / kWindow;
  if (!begun_) window_ = window;
  begun_ = true;
  // What is silent for a second leaves nothing in the windows.
  for (std::int64_t passed = std::min<std::int64_t>(window - window_, kWindows); passed > 0; --passed)
    close_window();
  window_ = std::max(window_, window);

  Sensor& one = sensors_[sensor];
  if (one.packet && one.packet->sequence == sequence && one.packet->arrival == arrival) {
    one.packet->late = std::min(one.packet->late, late);
    return;
  }
  if (one.packet) count(*one.packet, one.windows.front());
  one.packet = Packet{sequence, arrival, late};
}

}  // namespace mien::sensor
