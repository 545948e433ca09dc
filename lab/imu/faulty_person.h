#pragma once

#include <cstdint>
#include <string>

#include "mien/core/error.h"
#include "mien/model/model_file.h"
#include "mien/sensor/rig.h"
#include "mien/synthetic/watched.h"

namespace mien::lab {

/// Virtual people who wear the rig's IMUs in the *device* profile, before this model, under every fault that
/// the simulator knows: none; the network's and the nodes' (LossCondition), each at the most that the study
/// of losses looks at; and sensors that are worse, or worn worse, than the rig says (virt::DeviceFaults), by
/// factors that faulty_person.cpp lists. Every second one of them, where `shifted`, and else none, is unlike
/// those of training (draw_shifted_person); the others wear, move and have skin as those of training.
/// Errors: those of the rig's faults; the model's (mismatch). Cost, once they are watched: some 40 s of one
/// core a person and minute.
[[nodiscard]] Result<synthetic::FaultyGroup> faulty_people(const model::ModelFile& model,
                                                           const sensor::Rig& rig, std::string who,
                                                           int people, double seconds, bool shifted,
                                                           std::uint64_t seed);

}  // namespace mien::lab
