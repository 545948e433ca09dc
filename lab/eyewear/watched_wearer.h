#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/core/random.h"
#include "mien/eyewear/light_model.h"
#include "mien/eyewear/marker_network.h"
#include "mien/face/face.h"
#include "mien/face/motion.h"
#include "mien/sensor/rig.h"
#include "mien/synthetic/eyewear/worn_glasses.h"
#include "mien/synthetic/watched.h"
#include "mien/virtual/eyewear/eyewear_faults.h"

namespace mien::lab {

/// What the glasses of one wearer saw after the first minute, and what the face did: of equal size, 60 frames
/// a second.
struct LightPerson {
  std::vector<eyewear::LightFrame> light;
  std::vector<face::BlendshapeWeights> truth;
};

/// What befalls a wearer after the first minute.
struct WornLater {
  enum class Remount : std::uint8_t { no, uncalibrated, calibrated };
  /// Whether the glasses are taken off and put on again, and whether a neutral hold follows.
  Remount remount = Remount::no;
  synthetic::WornGlasses::Spoil spoil;  ///< Of the performance's samples; empty: nothing.
};

/// A wearer in glasses with these faults: the first minute, what befalls then, the performance. Errors:
/// seat_eyewear's.
[[nodiscard]] Result<LightPerson> wear_glasses(const face::Motion& motion, const face::Face& face,
                                               const sensor::Rig& rig, const virt::EyewearFaults& faults,
                                               const WornLater& later, const Random& random);

/// Virtual wearers of a seed of their own, who are drawn and move as those on whom IMUs' models are measured
/// do: shares explained by one and by the other are of the same faces. Each has a first minute of
/// calibration. Errors: those of the rig's faults; cancelled. Cost: a fiftieth of their time.
[[nodiscard]] Result<std::vector<LightPerson>> watch_wearers(int people, double seconds, std::uint64_t seed,
                                                             const sensor::Rig& rig, const Progress& progress,
                                                             unsigned threads);

/// People unlike those of training (draw_shifted_person), likewise.
[[nodiscard]] Result<std::vector<LightPerson>> watch_shifted_wearers(int people, double seconds,
                                                                     std::uint64_t seed,
                                                                     const sensor::Rig& rig,
                                                                     const Progress& progress,
                                                                     unsigned threads);

/// A recorded performance on a face that wears the rig's glasses. Errors: seat_eyewear's, the faults'.
[[nodiscard]] Result<LightPerson> watch_wearer(const face::Motion& motion, const face::Face& face,
                                               const sensor::Rig& rig, const Random& random);

/// As virtual wearers of a seed are drawn.
struct Wearer {
  face::Face face;
  face::Motion motion;
};
[[nodiscard]] Wearer draw_wearer(double seconds, const Random& root);

/// These people before this model. `sensors`: names of the lights' entries. Errors: mismatch (a model of
/// other sensors or markers).
[[nodiscard]] Result<synthetic::WatchedGroup> watched_by(const eyewear::MarkerNetworkFile& model,
                                                         const eyewear::MarkedFace& marked,
                                                         const std::vector<std::string>& sensors,
                                                         std::string who, std::vector<LightPerson> people);

/// Virtual wearers of the rig's glasses before this model, each calibrated in a first minute, under every
/// fault that the simulators know: none; a network that loses, delays and doubles packets, a board that is
/// silent for two seconds and a sensor that says the same throughout, all in the performance alone; glasses
/// put on another way since the calibration, without a neutral hold and with one; and glasses, skin and light
/// that are worse than the rig says from the beginning, by factors that faulty_wearer.cpp lists. A packet
/// that is spoilt or cut short is refused for its checksum, and so is lost. `shifted` as in faulty_people().
/// Errors: those of the rig's faults; mismatch (a model of other sensors or markers). Cost, once they are
/// watched: some 40 s of one core a person and minute.
[[nodiscard]] Result<synthetic::FaultyGroup> faulty_wearers(const eyewear::MarkerNetworkFile& model,
                                                            const eyewear::MarkedFace& marked,
                                                            const sensor::Rig& rig, std::string who,
                                                            int people, double seconds, bool shifted,
                                                            std::uint64_t seed);

}  // namespace mien::lab
