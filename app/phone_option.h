#pragma once

#include <span>
#include <string>

#include "app/command.h"
#include "app/film_option.h"
#include "mien/core/error.h"
#include "mien/model/features.h"
#include "mien/solve/phone_truth.h"
#include "mien/take/take.h"

namespace mien::app {

/// Whether a take has sensors on the skin, by which a phone's time is found. Errors: unsupported.
[[nodiscard]] Result<void> check_aligns(const take::Take& take);

/// What a phone told: the CSV `file`, or the take's own truth where that is empty. Where Live Link Face left
/// a calibrated file beside it ("NAME_cal.csv" beside "NAME.csv"), that is read instead, unless `as_named`.
/// That, and what was survived in a file, is said on stderr. `features`: what solve::take_features() gave.
/// Errors: solve::phone_track's.
[[nodiscard]] Result<solve::PhoneTrack> open_phone_track(const take::Take& take,
                                                         std::span<const model::FeatureFrame> features,
                                                         const std::string& file, bool as_named);

/// Which phone tells what a face did: --truth, and how its file is read.
class PhoneOption {
 public:
  /// `does`: what --truth is for, a sentence that both kinds of truth follow.
  void add_to(const Command& command, const std::string& does);

  [[nodiscard]] bool given() const { return !truth_.empty(); }
  /// As it was typed: "phone", or a file's name.
  [[nodiscard]] const std::string& truth() const { return truth_; }
  /// The phone's file; empty: it was recorded in the take.
  [[nodiscard]] std::string file() const;
  /// What it told, with a guess of its time by sound where its film can be heard. Errors: open_phone_track's,
  /// add_sound_guess's.
  [[nodiscard]] Result<solve::PhoneTrack> open(const take::Take& take,
                                               std::span<const model::FeatureFrame> features) const;

 private:
  std::string truth_;
  FilmOption film_;
  bool raw_ = false;
};

}  // namespace mien::app
