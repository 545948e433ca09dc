#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/random.h"
#include "mien/face/profile.h"
#include "mien/tracker/shape_confidence.h"

namespace mien::synthetic {

/// What a tracker answered to one person, and what the face did: of equal size, 60 frames a second.
struct Watched {
  std::vector<face::BlendshapeWeights> answer;  ///< As they are shown: after any filter.
  std::vector<tracker::Coverage> coverage;      ///< What was there of what each shape is read from.
  std::vector<face::BlendshapeWeights> truth;
};

/// A person before the sensors of one modality and its model. Each modality's folder derives one. Immutable,
/// so safe to share between threads.
class WatchedPerson {
 public:
  virtual ~WatchedPerson() = default;
  [[nodiscard]] virtual std::size_t sensor_count() const = 0;
  /// The tracker's answer from its first frame on, without `lost` of the sensors (at most all), which are
  /// drawn. Errors: the tracker's.
  [[nodiscard]] virtual Result<Watched> watch(std::size_t lost, const Random& random) const = 0;
};

/// People of one kind, and what they are called.
struct WatchedGroup {
  std::string who;
  std::vector<std::shared_ptr<const WatchedPerson>> people;
};

/// A person whose sensors all kinds of things befall, one after another. Each modality's folder derives one.
/// Immutable, so safe to share between threads.
class FaultyPerson {
 public:
  virtual ~FaultyPerson() = default;
  /// What the tracker answered under a fault, by its number in FaultyGroup::faults.
  using See = std::function<void(std::size_t fault, const Watched&)>;
  /// The same performance under each fault in turn, simulated as it is asked for: nothing of it is kept.
  /// Errors: the simulator's and the tracker's.
  [[nodiscard]] virtual Result<void> watch_each(const See& see) const = 0;
};

/// People of one kind under the same faults; the first of these is none.
struct FaultyGroup {
  std::string who;
  std::vector<std::string> faults;
  std::vector<std::shared_ptr<const FaultyPerson>> people;
};

}  // namespace mien::synthetic
