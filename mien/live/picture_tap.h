#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "mien/sensor/picture_view.h"
#include "mien/sensor/protocol.h"

namespace mien::live {

/// The way of what one camera sees from its feed's thread to the page: one view, made when it was asked for,
/// and wiped as it is taken. Neither side waits for the other: a feed that is not asked does nothing, and one
/// that is slow is asked no second time. No lock, no allocation.
class PictureTap {
 public:
  /// Pixels of a view, either way.
  static constexpr int kSide = 96;
  using Pixels = std::array<std::uint8_t, std::size_t{kSide} * kSide>;  ///< Grey, row by row from the top.

  struct Wish {
    std::uint16_t sensor = 0;  ///< Of the rig: the place that the camera is bound to.
    sensor::PictureView part;
    bool operator==(const Wish&) const = default;
  };
  struct View {
    std::uint16_t sensor = 0;
    Pixels pixels{};
  };

  explicit PictureTap(const sensor::DeviceKey& device) : device_(sensor::format_device(device)) {}

  // Network thread.
  /// As links name it (session::Report::Link::device).
  [[nodiscard]] const std::string& device() const { return device_; }
  /// A view of the camera's next picture is wanted. Nothing changes while one is still to come or to be
  /// taken.
  void ask(const Wish& wish) {
    if (state_.load(std::memory_order_acquire) != State::idle) return;
    wish_ = wish;
    state_.store(State::asked, std::memory_order_release);
  }
  /// The view that was asked for, once it is there.
  [[nodiscard]] std::optional<View> take() {
    if (state_.load(std::memory_order_acquire) != State::made) return std::nullopt;
    View view{.sensor = wish_.sensor, .pixels = pixels_};
    pixels_.fill(0);
    state_.store(State::idle, std::memory_order_release);
    return view;
  }

  // Feed's thread.
  /// Gives a picture a chance to be seen: where a view is asked for `make` is called with what is wanted and
  /// writes it; where that gives false, the next picture is looked at.
  template <class Make>
  void offer(const Make& make) {
    if (state_.load(std::memory_order_acquire) != State::asked) return;
    if (make(std::as_const(wish_), std::span<std::uint8_t>(pixels_)))
      state_.store(State::made, std::memory_order_release);
  }

 private:
  /// Who may touch the wish and the pixels: the network's thread, but for `asked`.
  enum class State : std::uint8_t { idle, asked, made };

  std::string device_;
  std::atomic<State> state_ = State::idle;
  Wish wish_;
  Pixels pixels_{};
};

}  // namespace mien::live
