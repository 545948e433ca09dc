#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "mien/core/random.h"
#include "mien/face/profile.h"
#include "mien/render/infrared_scene.h"
#include "mien/virtual/headset/camera_sensor.h"
#include "mien/virtual/headset/headset_faults.h"
#include "mien/virtual/headset/headset_wearer.h"

namespace mien::virt {

/// What keeps a headset from seeing a face, on request. What cannot be seen then is part of the truth.
enum class HeadsetFailure : std::uint8_t {
  none,
  hand,  ///< Before the mouth.
  cup,
  mask,
  moustache,  ///< So thick that it hangs over the lips.
  poor_seat,  ///< Donned 8 mm and 8 degrees off.
  smear,      ///< Grease on every lens.
  sun,        ///< From the side, through the gap at the cheek.
  dark,       ///< The lamps are out, but for a little light from outside.
  covered,    ///< One camera's lens, by a thumb.
};
inline constexpr std::size_t kHeadsetFailures = 10;
[[nodiscard]] std::string_view failure_name(HeadsetFailure failure);
[[nodiscard]] std::optional<HeadsetFailure> failure_named(std::string_view name);

/// Whether what the network sees of each camera is square, as a simulator of network views shows it. Errors:
/// out_of_range, which names the camera.
[[nodiscard]] Result<void> check_network_views(const sensor::Rig& rig);

/// A face at one moment.
struct HeadsetPose {
  face::BlendshapeWeights weights;
  float tongue_out = 0;
  bool operator==(const HeadsetPose&) const = default;
};

/// What is true of a picture's moment beside weights and tongue.
struct HeadsetTruth {
  std::array<Eigen::Vector2f, 2> gaze_rad;  ///< Yaw to the performer's left, pitch upwards; left, right eye.
  std::array<float, 2> openness{};          ///< Gap between the lids, 1 as in the neutral, 0 closed.
  std::array<float, 2> pupil_mm{};          ///< Diameter.
  /// Of the upper and of the lower face: false while a failure hides more of it than kMostHidden, a mean over
  /// its views (hidden_share), or blurs it by grease.
  std::array<bool, 2> is_visible{true, true};
};

/// A headset's cameras before a moving face. The same wearer, random stream and calls give the same pictures.
/// Not thread-safe; several may run side by side. The wearer outlives it.
class HeadsetSimulator {
 public:
  /// `network_view`: 0 gives whole pictures of each camera's own size; else what the network sees of them
  /// (the rig's crop, neither turned nor mirrored), so many pixels wide and high.
  HeadsetSimulator(const HeadsetWearer& wearer, const HeadsetFaults& faults, const Random& random,
                   int network_view = 0, HeadsetFailure failure = HeadsetFailure::none);
  ~HeadsetSimulator();

  /// Taken off and put on again: another seat, drawn.
  void put_on();
  /// Or exactly here, for studies of shifts.
  void sit(const HeadsetSeat& seat);
  [[nodiscard]] HeadsetSeat seat() const { return seat_; }

  /// From now on the failure it was made for happens, or no longer.
  void fail(bool happens) { fails_ = happens; }

  [[nodiscard]] PictureSize size(std::size_t camera) const { return views_[camera].size; }
  [[nodiscard]] std::size_t cameras() const { return views_.size(); }

  /// A picture of every camera at once: `first` is the face when their first rows are exposed, `last` when
  /// the last ones are, rolling_ms later. `out`: of each camera its pixels, grey, row by row. Seat, slip,
  /// sway and pupils go on from the last call's time; times do not run backwards. Cost: mien bench headset.
  HeadsetTruth shoot(double time_s, const HeadsetPose& first, const HeadsetPose& last,
                     std::span<const std::span<std::uint8_t>> out);

 private:
  struct View {
    PictureSize size;
    render::Lens lens;  // Before it is seated.
    CameraSensor sensor;
    std::vector<float> radiance;
    std::vector<std::uint32_t> watched;  // Vertices of the face.
  };
  struct Seated;
  void wait_until(double time_s);
  [[nodiscard]] HeadsetSeat seat_with(const face::BlendshapeWeights& weights) const;
  void place_obstacles(double time_s);
  [[nodiscard]] std::array<bool, 2> seen_halves(std::span<const render::Lens> lenses,
                                                std::span<const std::span<std::uint8_t>> pictures) const;
  [[nodiscard]] std::array<float, 2> lid_gaps(std::span<const Vec3f> vertices_m) const;

  const HeadsetWearer* wearer_;
  HeadsetFaults faults_;
  HeadsetFailure failure_;
  bool fails_ = false;
  std::vector<View> views_;
  std::vector<render::InfraredLamp> lamps_;
  std::size_t covered_ = 0;  // Which camera, where one is.
  struct Grease {
    float usual = 0, much = 0;
  };
  std::vector<Grease> grease_;  // Of each camera, where the failure is smear.
  std::optional<render::InfraredScene> scene_;
  render::InfraredScene::Canvas canvas_;
  std::vector<Vec3f> first_m_, last_m_, things_m_;
  struct Obstacle;
  std::unique_ptr<Obstacle> obstacle_;
  std::array<float, 2> neutral_gap_{};
  double ambient_ = 0;  // W/m^2.
  HeadsetSeat seat_, sway_;
  HeadsetSeat poor_;  // Added to the seat by the failure.
  std::array<double, 3> breath_phase_{};
  double now_s_ = 0;
  bool begun_ = false;
  Random seats_, slips_, sways_;
};

}  // namespace mien::virt
