#pragma once

#include <optional>

#include "mien/core/error.h"
#include "mien/core/time.h"
#include "mien/core/wav.h"
#include "mien/phone/sound_offset.h"
#include "mien/phone/time_alignment.h"
#include "mien/take/take.h"

namespace mien::solve {

/// What a take's microphone heard. Times are the sensors', s, from the first frame of features on.
struct TakeSound {
  Sound sound;
  double begin_s = 0;    ///< Of its first sample.
  double drift_ppm = 0;  ///< By how much its clock is slow.
};

/// The sound that was recorded beside the take, or else the blocks that its session logged, of the microphone
/// with most of them and, where its clock jumped, of the longest stretch; what was lost is silence. Its clock
/// stands on the sensors' by the earliest arrivals of both, so that it is late by what a microphone's way
/// takes longer. `begin`: the time of the first frame. Errors: not_found (no sound), the take's.
[[nodiscard]] Result<TakeSound> take_sound(const take::Take& take, DeviceTime begin);

/// The sound of a film, from the film's time 0 on.
struct FilmSound {
  Sound sound;
  std::optional<double> start_s;  ///< What its time code says then, s after 00:00:00:00.
};

/// Where a phone's time is on the sensors', by the sound of its film.
struct SoundGuess {
  phone::SoundOffset at;     ///< First the sensors' time, the other that of the phone's track.
  bool by_timecode = false;  ///< Else film and track are taken to begin at once.
  double begin_sigma_s = 0;  ///< How far that may be off.

  [[nodiscard]] phone::AlignmentPrior prior() const;
};

/// `track_start_s`: the time code of the track's first row, as FilmSound has it. A film whose time code is
/// farther than ten seconds from it is on another clock, and taken to begin with the track. Errors:
/// phone::sound_offset's.
[[nodiscard]] Result<SoundGuess> guess_by_sound(const TakeSound& heard, const FilmSound& film,
                                                std::optional<double> track_start_s);

}  // namespace mien::solve
