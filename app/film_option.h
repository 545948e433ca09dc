#pragma once

#include <span>
#include <string>

#include "app/command.h"
#include "mien/core/error.h"
#include "mien/model/features.h"
#include "mien/solve/phone_truth.h"
#include "mien/take/take.h"

namespace mien::app {

/// Whose sound says about when a phone's file was recorded.
struct FilmOption {
  std::string film;  ///< Empty: what lies beside the file.
  bool no_sound = false;
};

void add_film_options(const Command& command, FilmOption& option);

/// The film that Live Link Face left beside a file: NAME.mov beside NAME.csv, NAME_cal.csv and NAME_raw.csv;
/// empty where there is none.
[[nodiscard]] std::string film_beside(const std::string& csv);

/// Compares the sound of a file's film with the take's, for track.sound. `csv`: the file that was named,
/// empty for the take's own truth, which has no film. Says on stderr in a line why there is none: no helper,
/// a take without sound, sounds that do not match, and a film beside the file that cannot be read. One that
/// was named and cannot be read is an error. `features`: what solve::take_features() gave. Errors: bad_usage
/// (a film without a file), read_film_sound's.
[[nodiscard]] Result<void> add_sound_guess(const take::Take& take,
                                           std::span<const model::FeatureFrame> features,
                                           const std::string& csv, const FilmOption& option,
                                           solve::PhoneTrack& track);

}  // namespace mien::app
