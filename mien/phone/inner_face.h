#pragma once

#include <array>

#include "mien/face/output_frame.h"
#include "mien/phone/told_face.h"

namespace mien::phone {

/// Confidence of what a sender tells without saying how sure it is of it: ours, since nobody measured other
/// programs. It is what MergeSettings::sure asks for by default, so that the order of the trackers decides.
inline constexpr float kDefaultConfidence = 0.5F;

/// A told face in our shapes: the 53, and tongueOut at face::kShapeCount.
struct InnerFace {
  std::array<float, face::kInnerCount> weights{};     ///< 0 to 1; 0 where not known.
  std::array<float, face::kInnerCount> confidence{};  ///< 0 to 1.
  std::array<bool, face::kInnerCount> known{};
};

/// By the set's table (face::ProfileMap::to_ict), of weights held to 0 to 1. An inner shape is known where
/// one is told of those that it is made of; where others of these are not told, its weight is theirs who are,
/// and its confidence as much smaller as their part of its shares is. What the set cannot tell is not known.
/// No allocation. Thread-safe.
[[nodiscard]] InnerFace inner_face(const ToldFace& face);

/// What a frame says of values of this origin: measured, predicted (also of an untold one: who does not say
/// that it measures is not believed to), audio or held.
[[nodiscard]] face::Provenance provenance_of(Origin origin);
/// Confidence of a value that was told with this one, or with none (kUntold); 0 of one that is held.
[[nodiscard]] float confidence_of(float told, Origin origin);

}  // namespace mien::phone
