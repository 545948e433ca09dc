#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/eyewear/light_model.h"
#include "mien/eyewear/marker_network.h"
#include "mien/sensor/rig.h"
#include "mien/synthetic/watched.h"

namespace mien::lab {

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
