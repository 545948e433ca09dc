#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/face/face.h"
#include "mien/face/motion.h"
#include "mien/model/features.h"
#include "mien/model/model_file.h"
#include "mien/phone/time_alignment.h"
#include "mien/sensor/rig.h"
#include "mien/solve/sound_guess.h"
#include "mien/take/take.h"
#include "mien/tracker/learn_correction.h"

namespace mien::solve {

/// What a phone told while a take was recorded, on its own clock.
struct PhoneTrack {
  /// Named after where it comes from. Where nothing was told for longer than kLongestPhoneGap there is no
  /// face.
  face::Motion motion;
  DeviceTime begin;  ///< Its first frame, on the phone's clock; a file's counts from there.
  std::optional<phone::AlignmentPrior> prior;  ///< By arrivals; none from a file.
  std::optional<double> start_s;               ///< A file's first time code, s after 00:00:00:00.
  std::optional<SoundGuess> sound;  ///< By its film's sound, where somebody compared that with the take's.
  /// What was left out because the phone's clock jumped: all but the longest stretch between jumps, s.
  double left_out_s = 0;
};

/// Between two frames of a phone what it tells is interpolated over at most this, s.
inline constexpr double kLongestPhoneGapS = 0.15;

/// Of the rig's truth sensor, the first that told anything. `samples`: all of a session, by entry. `begin`:
/// the time of the first frame of features, from which the sensors' time counts. Errors: not_found (no truth
/// in the rig, none that told).
[[nodiscard]] Result<PhoneTrack> phone_track(const sensor::Rig& rig,
                                             std::span<const take::StoredSample> samples, DeviceTime begin);
/// Of a Live Link Face CSV. Errors: face::load_motion's. `warnings`: as there.
[[nodiscard]] Result<PhoneTrack> phone_track(const std::filesystem::path& csv,
                                             std::vector<std::string>* warnings);

/// From where the search for a phone's time began.
enum class FirstGuess : std::uint8_t {
  none,      ///< Every offset was tried.
  arrivals,  ///< When the phone's packets and the sensors' came.
  sound,     ///< What its film and the take's microphone heard (guess_by_sound).
  taps,      ///< Three on the chin, which both saw (phone::prior_by_taps).
};

/// What a phone told, as truth beside a take's frames.
struct PhoneTruth {
  phone::TimeAlignment alignment;
  FirstGuess guess = FirstGuess::none;
  /// By how much the motion is later than the track's sound has it, s: a phone's lag, less a microphone's.
  std::optional<double> after_sound_s;
  /// One a tick. `evaluated`: with a face, and after the calibration. Weights are what the phone told, less
  /// what it told of the neutral hold, 0 to 1.
  std::vector<take::TruthFrame> frames;
  /// What was taken off for the neutral hold; nothing where there was none, or the phone did not see it.
  std::optional<face::BlendshapeWeights> rest;
};

/// Aligns the track with a session's features (phone::align) and reads it at their times. A track without a
/// prior is aligned by its sound first, then by taps, where there is such; where these are refused, every
/// offset is tried.
/// `events`: the session's, of which the calibration's steps count. `features`: what take_features() gave.
/// Errors: phone::align's.
[[nodiscard]] Result<PhoneTruth> phone_truth(std::span<const take::Event> events,
                                             std::span<const model::FeatureFrame> features,
                                             const PhoneTrack& track);

/// What a phone taught of one wearer.
struct LearntFromPhone {
  phone::TimeAlignment alignment;
  tracker::LearntCorrection learnt;
};

/// Learns what a live model's answers lack for a take's wearer (tracker::learn_correction) from what a phone
/// told meanwhile, and stores it in `file` where it helps. `features`: what take_features() gave. `face`:
/// whose skin counts. Errors: the take's, phone_truth's and learn_correction's.
[[nodiscard]] Result<LearntFromPhone> learn_from_phone(const take::Take& take,
                                                       std::span<const model::FeatureFrame> features,
                                                       const PhoneTrack& track, const face::Face& face,
                                                       model::ModelFile& file, const Progress& progress);

}  // namespace mien::solve
