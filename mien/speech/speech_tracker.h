#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "mien/sensor/rig.h"
#include "mien/speech/listener.h"
#include "mien/speech/spoken_mouth.h"
#include "mien/tracker/tracker.h"

namespace mien::speech {

/// Tracker of the modality "speech": mouth and jaw as they sound. While somebody speaks these shapes have the
/// provenance audio; in silence, and without sound, they are neutral, with that provenance, so that nobody
/// takes a quiet room for a closed mouth. Confidence, of shapes and of the two regions, is by the network's
/// table; 0 where it has none, of phones, and in silence. The other shapes, head and eyes are always neutral:
/// sound does not tell them. Of several microphones of a rig the first is listened to. Nothing to calibrate.
/// No allocation of its own; what a Listener does is its affair.
class SpeechTracker final : public tracker::Tracker {
 public:
  /// Without a block for so long there is no sound.
  static constexpr Duration kPresent = std::chrono::milliseconds(200);

  /// The listener is asked for at the first block, so that a session's first frame does not wait for it:
  /// whatever the hour, the same blocks give the same bits. Where it cannot be made nothing is heard
  /// (error()).
  using MakeListener = std::function<Result<std::unique_ptr<Listener>>()>;

  /// Errors: mismatch (a rig without sensors of the kind "speech").
  [[nodiscard]] static Result<std::unique_ptr<SpeechTracker>> create(const sensor::Rig& rig,
                                                                     MakeListener make);

  [[nodiscard]] std::string_view modality() const override { return "speech"; }
  /// A block that came without its samples is none.
  void add(HostTime, const sensor::Sample&) override {}
  void add_with_payload(HostTime arrival, const sensor::Sample& sample,
                        std::span<const std::byte> payload) override;
  void forget(std::uint16_t sensor) override;
  tracker::TickResult tick(DeviceTime frame, const sensor::TimeLines& lines, face::OutputFrame& out) override;

 private:
  SpeechTracker(std::uint16_t sensor, MakeListener make) : sensor_(sensor), make_(std::move(make)) {}
  void forget_all();

  std::uint16_t sensor_;
  MakeListener make_;  // Empty once it was asked.
  std::unique_ptr<Listener> listener_;
  SpokenMouth mouth_;
  std::optional<DeviceTime> last_block_;
};

}  // namespace mien::speech
