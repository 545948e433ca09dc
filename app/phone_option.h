#pragma once

#include <span>
#include <string>

#include "app/command.h"
#include "mien/core/error.h"
#include "mien/model/features.h"
#include "mien/solve/phone_truth.h"
#include "mien/take/take.h"

namespace mien::app {

/// Whether a take has sensors on the skin, by which a phone's time is found. Errors: unsupported.
[[nodiscard]] Result<void> check_aligns(const take::Take& take);

/// How a phone's file is read, and whose sound says about when it was recorded.
struct PhoneReading {
  bool raw = false;  ///< The file that is named, even where a calibrated one lies beside it.
  std::string film;  ///< Empty: what lies beside the file.
  bool no_sound = false;

  /// --raw, --film and --no-sound.
  void add_to(const Command& command);

  /// What a phone told: the CSV `file`, or the take's own truth where that is empty. Where Live Link Face
  /// left a calibrated file beside it ("NAME_cal.csv" beside "NAME.csv"), that is read instead, unless `raw`.
  /// That, and what was survived in a file, is said on stderr.
  ///
  /// The sound of the file's film is compared with the take's, for track.sound. A line on stderr says why
  /// there is none: no helper, a take without sound, sounds that do not match, and a film beside the file
  /// that cannot be read. One that was named and cannot be read is an error. `features`: what
  /// solve::take_features() gave. Errors: solve::phone_track's, bad_usage (a film without a file),
  /// read_film_sound's.
  [[nodiscard]] Result<solve::PhoneTrack> open(const take::Take& take,
                                               std::span<const model::FeatureFrame> features,
                                               const std::string& file) const;
};

/// Which phone tells what a face did: --truth, and how its file is read.
class PhoneOption {
 public:
  /// `does`: what --truth is for, a sentence that both kinds of truth follow.
  void add_to(const Command& command, const std::string& does);

  [[nodiscard]] bool given() const { return !truth_.empty(); }
  /// As it was typed: "phone", or a file's name.
  [[nodiscard]] const std::string& truth() const { return truth_; }
  /// The phone's file; empty: it was recorded in the take.
  [[nodiscard]] std::string file() const { return truth_ == "phone" ? std::string() : truth_; }
  /// What it told. Errors: PhoneReading::open's.
  [[nodiscard]] Result<solve::PhoneTrack> open(const take::Take& take,
                                               std::span<const model::FeatureFrame> features) const {
    return reading_.open(take, features, file());
  }

 private:
  std::string truth_;
  PhoneReading reading_;
};

}  // namespace mien::app
