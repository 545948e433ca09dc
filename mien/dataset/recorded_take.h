#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/time.h"
#include "mien/dataset/dataset.h"
#include "mien/dataset/take_videos.h"
#include "mien/dataset/weight_histogram.h"
#include "mien/phone/time_alignment.h"
#include "mien/session/recorded_lines.h"
#include "mien/take/take.h"

namespace mien::dataset {

/// Whose a take is and with which sensors, before anything in it is computed.
struct TakeIdentity {
  /// Who consented; of a virtual performer, who need not, "virtual:SEED" as the header has it, whose
  /// seed tells them apart.
  std::string performer;
  /// What of the take is the dataset's. None: a virtual performer's, all of it is.
  std::optional<session::RecordedPart> part;
  std::vector<std::string> sensors;  ///< Those on the face, in the order of features.
};
/// Errors: the take's; not_found (nobody consented); unsupported (the sensors do not sit on the skin).
[[nodiscard]] Result<TakeIdentity> identify_take(const take::Take& take);

/// A phone's time beside the sensors'.
struct TakeSync {
  phone::TimeAlignment alignment;
  double left_out_s = 0;  ///< Of what it told, because its clock jumped.
};

/// How much there is of a label.
struct LabelAmount {
  std::size_t lines = 0;
  double seconds = 0;  ///< Of its frames that count.
};
/// By the label.
using LabelAmounts = std::map<std::string, LabelAmount>;

/// How the time of the part of a take that is the dataset's is spent, s. A frame is in one of them only, the
/// first that it fits.
struct TakeSeconds {
  double without_face = 0;        ///< No truth: the phone lost the face, did not tell, or was not there yet.
  double before_calibration = 0;  ///< Of a virtual performer: the prologue, and easing in.
  double poor = 0;                ///< In lines that were poor.
  double unfelt = 0;              ///< No sensor's rotation is there.
  double brief = 0;               ///< Would count, but for less than kShortestStretchFrames at a time.
  double counted = 0;             ///< All others.

  [[nodiscard]] double all() const {
    return without_face + before_calibration + poor + unfelt + brief + counted;
  }
  TakeSeconds& operator+=(const TakeSeconds& other);
};

/// A take at a glance, for people and for datasheets. Labels and what the header says are excerpt()s of it,
/// 60 letters each; consent is as it stands in the take.
struct TakeOverview {
  std::filesystem::path path;
  std::string performer;
  std::optional<session::Consent> consent;  ///< None of a virtual performer, who performed into the take.
  std::string software, created_utc, rig, devices;  ///< By the take's header.
  bool finished = true;                             ///< False: cut off, or still being recorded.
  TakeSeconds seconds;
  double sound_s = 0;             ///< Sound in that part.
  std::vector<TakeVideo> videos;  ///< Beside it.
  /// None: the truth is the performer's own, at the frames' times.
  std::optional<TakeSync> sync;
  std::size_t good_lines = 0, poor_lines = 0;
  LabelAmounts blocks, emotions, languages;            ///< Of the good lines.
  std::array<ShapeRange, face::kShapeCount> ranges{};  ///< Of the truth, over the frames that count.
};

/// What there is of takes together.
struct TakeTotals {
  TakeSeconds seconds;
  double sound_s = 0;
  std::size_t good_lines = 0, poor_lines = 0;
  LabelAmounts blocks, emotions, languages;

  void add(const TakeOverview& take);
};

/// Frames that count, without a gap between them.
struct CountedStretch {
  DeviceTime begin;  ///< Of its first frame.
  /// As training has them (never `lab`: a take's noise is in it). The performer's number is 0, the skin's
  /// slopes are unknown.
  Sequence sequence;
  /// A frame each: the line that was shown, in RecordedTake::lines; -1: none.
  std::vector<std::int32_t> line;
};

/// A stretch that counts is at least two seconds long: what is shorter holds no window of the networks', and
/// begins and ends where a face is found and lost again.
inline constexpr std::size_t kShortestStretchFrames = 120;

/// What a take gives to a dataset.
struct RecordedTake {
  TakeOverview overview;
  std::vector<session::RecordedLine> lines;  ///< Of a block, and that count (lines_that_count).
  DeviceTime first_frame;                    ///< Of the whole take.
  std::vector<CountedStretch> stretches;     ///< In the order of time; at least one.
  WeightHistogram weights;                   ///< Over all of these.
};

/// Reads a take of a dataset: its features at 60 Hz, and the truth beside them, which is its own (of a
/// virtual performer, or imported) or else what a phone told, aligned with the sensors (phone_truth). A frame
/// counts where there is a face and a sensor, after the calibration, in the part that the performer consented
/// to, and outside lines that were poor. Errors, `what` being the sentence that says why the take is left
/// out: identify_take's; not_found (no truth, too little seen together, nothing that counts); mismatch (the
/// phone is another's). Cost: a minute of a take in about a second of one core.
[[nodiscard]] Result<RecordedTake> read_recorded_take(const take::Take& take);

/// Frames [first, first + count) of a sequence of `sensors` sensors.
[[nodiscard]] Sequence cut_sequence(const Sequence& sequence, std::size_t sensors, std::size_t first,
                                    std::size_t count);

}  // namespace mien::dataset
