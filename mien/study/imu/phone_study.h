#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/face/motion.h"
#include "mien/model/model_file.h"
#include "mien/virtual/phone/phone_faults.h"

namespace mien::study {

/// How well a phone's time is found, and what is learnt from it: virtual phones before virtual wearers of
/// IMUs.
struct PhoneStudyRequest {
  std::filesystem::path rig;
  model::ModelFile model;             ///< A live one.
  std::size_t sync_seeds = 20;        ///< Takes whose time is found.
  double sync_s = 120;                ///< Of each, s.
  std::size_t strangers = 10;         ///< Virtual wearers who are learnt.
  double stranger_s = 240;            ///< Of each: learnt from the first half, tried on the second, s.
  std::vector<double> curve_s = {};   ///< Also learnt from so much alone, by the first two strangers, s.
  std::vector<face::Motion> motions;  ///< Recordings, learnt and tried in the same way.
  std::string face = "builtin";       ///< On which recordings are performed.
  std::uint64_t seed = 1;
};

/// One take whose time was found.
struct PhoneSyncRow {
  std::uint64_t seed = 0;
  std::optional<std::string> refused;  ///< Why it was not found; the rest is nothing then.
  double error_s = 0;  ///< Of the truth's time in the take's middle: what is found less what is.
  double sigma_s = 0;  ///< As it was stated.
  double drift_error_ppm = 0, drift_sigma_ppm = 0;
  double agreement = 0;
};

/// Errors of the live model and of the one that learnt, on the same frames.
struct LearntErrors {
  double pve_before_mm = 0, pve_after_mm = 0;
  double mse_before = 0, mse_after = 0;
};

/// One wearer who was learnt in one take and tried in another: the second half of the same motion, with
/// sensors that were put on anew (another seed of placement, mounting and all faults).
struct PhoneLearnRow {
  std::string who;
  std::string devices;  ///< "lab" or "device".
  double learnt_s = 0;  ///< How long the phone told what was learnt from.
  std::optional<std::string> refused;
  bool taken = false;                              ///< Else the model stayed as it was.
  LearntErrors all;                                ///< All sensors there.
  double mse_lost_before = 0, mse_lost_after = 0;  ///< One sensor lost: mean over which.
  double worst_lost = 0;                           ///< Over which: greatest share of its error before.
  std::optional<double> pve_perfect_mm;            ///< After learning from a phone without a fault.
};

struct PhoneStudy {
  std::vector<PhoneSyncRow> sync;
  std::vector<PhoneLearnRow> learnt;
  std::vector<PhoneLearnRow> curve;
};

/// A phone that loses a tenth of its frames, and the face for four seconds, once; else as people have them.
[[nodiscard]] virt::PhoneFaults hard_phone();

/// Errors: those of the stage's and the model's readers, cancelled.
[[nodiscard]] Result<PhoneStudy> study_phone(const PhoneStudyRequest& request, const Progress& progress);

}  // namespace mien::study
