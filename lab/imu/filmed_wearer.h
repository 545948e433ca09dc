#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/face/motion.h"
#include "mien/model/features.h"
#include "mien/sensor/rig.h"
#include "mien/solve/phone_truth.h"
#include "mien/virtual/phone/phone_faults.h"
#include "mien/virtual/session.h"
#include "mien/virtual/virtual_clock.h"

namespace mien::lab {

/// Who wears IMUs, and what looks on.
struct WearerRequest {
  face::Motion motion;
  std::string face = "builtin";    ///< As builtin_face::load_face takes it.
  std::filesystem::path rig;       ///< Its file.
  std::string devices = "device";  ///< As virt::StageRequest has it, and so are these two.
  double unlike = 0;
  std::uint64_t seed = 1;
  std::optional<virt::PhoneFaults> phone;  ///< None: no phone looks on.
};

/// A performance, with a phone beside it or without, as a session received it.
struct FilmedWearer {
  sensor::Rig rig;
  virt::VirtualSession session;
  std::vector<model::FeatureFrame> features;  ///< One a tick of the session.
  virt::VirtualClock reference, phone;
  double phone_lag_s = 0;  ///< How much older the face is that the phone tells than its frame says.
};

/// The same request gives the same bits. Errors: those of the stage and the devices.
[[nodiscard]] Result<FilmedWearer> film_wearer(const WearerRequest& request);

/// What the phone told, aligned by what the sensors felt: the true times are not asked. Errors: phone_track's
/// and phone_truth's.
[[nodiscard]] Result<solve::PhoneTruth> truth_of(const FilmedWearer& filmed);

}  // namespace mien::lab
