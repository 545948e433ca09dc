#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "mien/core/newest.h"
#include "mien/phone/inner_face.h"
#include "mien/sensor/rig.h"
#include "mien/tracker/tracker.h"

namespace mien::phone {

/// Tracker of the modality "weights": what other programs say of the face. Each sensor's answer stands
/// between its newest sample not after the frame and the next (weights and position linearly, rotation along
/// the shortest turn), or is the newest where there is no next. Of several sensors the one that is surest of
/// a shape, or of the head, gives it, the first of equals.
///
/// Provenance is what the sender says of itself (provenance_of), confidence its own or kDefaultConfidence;
/// what is not told is neutral. The head's position counts from where the sensor first told one, or would be
/// had its sender not begun anew. Eye directions follow from the eyeLook shapes (shaping/eyes.h). Nothing to
/// calibrate. No allocation.
class WeightsTracker final : public tracker::Tracker {
 public:
  /// A sensor without a sample for so long is not present.
  static constexpr Duration kPresent = std::chrono::milliseconds(200);

  /// Errors: mismatch (a rig without sensors of the kind "weights").
  [[nodiscard]] static Result<std::unique_ptr<WeightsTracker>> create(const sensor::Rig& rig);

  [[nodiscard]] std::string_view modality() const override { return "weights"; }
  void add(HostTime arrival, const sensor::Sample& sample) override;
  void forget(std::uint16_t sensor) override;
  tracker::TickResult tick(DeviceTime frame, const sensor::TimeLines& lines, face::OutputFrame& out) override;

 private:
  struct Seen {
    DeviceTime time;
    std::uint32_t sequence = 0;
    ToldFace face;
  };
  /// What a frame stands between; `after` is null where nothing newer is there.
  struct Around {
    const Seen* before = nullptr;
    const Seen* after = nullptr;
    float share = 0;  // Of the way to `after`.
  };
  /// One sensor's newest faces.
  struct Channel {
    std::uint16_t sensor = 0;
    Newest<Seen, 32> faces;
    std::optional<Vec3f> origin_m;  // What counts as position 0.
    Vec3f newest_m = Vec3f::Zero();
    bool begun_anew = false;  // The sender did, and its next position says where it is now.
    /// `before` null: none within kPresent.
    [[nodiscard]] Around around(DeviceTime time) const;
    /// Takes a told position into account.
    void place(const ToldHead& head);
  };
  [[nodiscard]] static InnerFace shapes_at(const Around& around);
  /// Where the head is told, and surer than what stands there.
  static void put_head(const Around& around, const Channel& channel, face::OutputFrame& out);
  explicit WeightsTracker(std::vector<Channel> channels) : channels_(std::move(channels)) {}

  std::vector<Channel> channels_;
};

}  // namespace mien::phone
