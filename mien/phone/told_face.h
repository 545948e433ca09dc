#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "mien/core/rotation.h"
#include "mien/phone/shape_set.h"
#include "mien/sensor/protocol.h"

namespace mien::phone {

/// A weight or confidence that was not told.
inline constexpr float kUntold = -1;
/// Weights are nominally 0 to 1; programs go a little beyond, by so much at most.
inline constexpr float kBeyond = 0.5F;
/// Coordinates of a head, each way, m.
inline constexpr float kMostHead_m = 100;

/// How the sender came by what it tells. Numbers are part of the packet and of takes: never reused.
enum class Origin : std::uint8_t {
  untold = 0,
  measured = 1,   ///< Its cameras or sensors see what it tells.
  predicted = 2,  ///< It concludes from other things.
  audio = 3,      ///< From sound.
  held = 4,       ///< It sees the face no more, and repeats what it told last.
};
inline constexpr std::uint8_t kOriginCount = 5;

/// A head's pose in the sender's world: right-handed, +Y up, any heading; head axes as frame H.
struct ToldHead {
  Vec3f position_m = Vec3f::Zero();  ///< Zero unless position_known; within kMostHead_m.
  bool position_known = false;
  std::array<float, 4> rotation = {1, 0, 0, 0};  ///< q_world_head w,x,y,z, of length 1 within 1 %.
  float confidence = kUntold;                    ///< 0 to 1, or kUntold.
  bool operator==(const ToldHead&) const = default;
};

/// What another program says of a face at one moment.
struct ToldFace {
  ToldFace() {
    weights.fill(kUntold);
    confidence.fill(kUntold);
  }
  ShapeSet set = ShapeSet::ict53;
  Origin origin = Origin::untold;
  /// In the set's order, -kBeyond to 1 + kBeyond, or kUntold; kUntold behind the set's last.
  std::array<float, kMostShapes> weights;
  /// 0 to 1, or kUntold; kUntold where the weight is.
  std::array<float, kMostShapes> confidence;
  std::optional<ToldHead> head;
  bool operator==(const ToldFace&) const = default;

  [[nodiscard]] std::size_t told() const;  ///< How many weights.
};

/// Whether every number is finite and in its range, and nothing told that cannot be.
[[nodiscard]] bool is_sound(const ToldFace& face);

/// Weights or confidences in one sample.
inline constexpr std::size_t kPartShapes = sensor::kMaxSampleValues - 3;
inline constexpr std::size_t kMostParts = 2 * ((kMostShapes + kPartShapes - 1) / kPartShapes) + 1;

/// A sound face as samples, in this order, and returns how many; sensor, sequence and time of all are the
/// caller's, and the same. Parts in which nothing is told are left out.
///
/// - SampleKind::weights: set, origin, number of the first shape (a multiple of kPartShapes), then the
///   weights from there on, kPartShapes or up to the set's last;
/// - SampleKind::weights_confidence: likewise;
/// - SampleKind::head_pose: position, m (3), q_world_head w,x,y,z (4), confidence, origin, and 1 where the
///   position is known, else 0.
std::size_t samples_of(const ToldFace& face, std::span<sensor::Sample, kMostParts> out);

/// Puts what one such sample says into a face: of its set, unless nothing of the face is told yet. False, and
/// nothing is changed, for a sample of another kind or set, or with a number out of its range.
bool add_sample(const sensor::Sample& sample, ToldFace& face);

/// When a face was told: all its samples share it.
struct ToldWhen {
  std::uint32_t sequence = 0;
  DeviceTime time;
  bool estimated = false;  ///< The wire carries no time.
};

/// A sound face as readings of a device's first sensor; one of which nothing is told says that it is alive,
/// one that is held that it sees no face.
void add_readings(const ToldFace& face, std::uint64_t device, const ToldWhen& when, sensor::Inbox& inbox);

}  // namespace mien::phone
