#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace mien::sensor {

struct DeviceKey;
struct PictureView;

/// The longest payload, bytes: a picture, or 20 ms of sound. What does not fit into a datagram's 1,472 bytes
/// and a sample's 16 numbers stands beside them as one.
inline constexpr std::size_t kMaxPayload = std::size_t{256} << 10U;

/// A payload as a log has it. Refers to bytes that somebody else owns; the function that hands it on
/// documents how long they are valid.
struct Payload {
  std::span<const std::byte> bytes;  ///< 1 to kMaxPayload; empty: there is no payload.
  /// The hash of the reducer whose result the bytes are (Reducer::hash()); empty: they are raw.
  std::string_view reducer;
};

/// 64 lower-case hexadecimal digits: SHA-256, as Sha256::hex() writes it.
inline constexpr std::size_t kReducerHashDigits = 64;
[[nodiscard]] inline bool is_reducer_hash(std::string_view text) {
  return text.size() == kReducerHashDigits && std::ranges::all_of(text, [](char digit) {
           return (digit >= '0' && digit <= '9') || (digit >= 'a' && digit <= 'f');
         });
}

/// Makes of a raw payload what is logged and tracked instead of it (of a picture its features), so that no
/// picture is kept. A pure function of the two spans and of what the hash stands for: no state from call to
/// call but what change_view() and bind() tell, no clock, the same bits on every run. No allocation in
/// reduce() after the first calls. Thread: one at a time.
class Reducer {
 public:
  virtual ~Reducer() = default;
  /// Of everything that the result depends on: the method, its version, its model file. As is_reducer_hash()
  /// has it; the same until change_view() or bind() changes what the result depends on. Valid until then.
  [[nodiscard]] virtual std::string_view hash() const = 0;
  /// Writes the result to the front of `out`, which has kMaxPayload bytes, and returns its length: 1 to
  /// kMaxPayload. None where the payload is not what the datagram describes: the datagram is then malformed.
  [[nodiscard]] virtual std::optional<std::size_t> reduce(std::span<const std::byte> datagram,
                                                          std::span<const std::byte> payload,
                                                          std::span<std::byte> out) = 0;
  /// From the next call on this camera of the rig is seen so (PictureView, as check_crop and check_turn take
  /// it): the result and the hash are those of a reducer that was made for such a rig. One without a use for
  /// it passes it over.
  virtual void change_view([[maybe_unused]] std::uint16_t sensor, [[maybe_unused]] const PictureView& view) {}
  /// From the next call on this device is bound to that sensor of the rig, and neither to another; likewise.
  virtual void bind([[maybe_unused]] std::uint16_t sensor, [[maybe_unused]] const DeviceKey& device) {}
};

}  // namespace mien::sensor
