#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/time.h"
#include "mien/face/gaze_targets.h"
#include "mien/face/output_frame.h"
#include "mien/model/correction.h"
#include "mien/model/features.h"
#include "mien/sensor/calibration.h"
#include "mien/sensor/clock_model.h"
#include "mien/sensor/picture_view.h"
#include "mien/sensor/sample.h"
#include "mien/tracker/prompted_expression.h"
#include "mien/tracker/shape_confidence.h"

namespace mien::tracker {

/// What a performer does for a calibration. A modality that has no use for a step passes it over.
enum class Step : std::uint8_t {
  none,
  neutral,  ///< Face and head still, upright, looking ahead.
  nod,      ///< Face still, the head nods; begins downwards.
  shake,    ///< Face still, the head shakes about the vertical.
};
[[nodiscard]] std::string_view step_name(Step step);
/// The step of that name, as events of takes have it; none for any other.
[[nodiscard]] Step step_named(std::string_view name);

/// How far a calibration is, for people.
struct CalibrationState {
  enum class Phase : std::uint8_t {
    watching,  ///< None yet: the tracker watches for the steps, whenever the performer does them.
    guided,    ///< Steps that were asked for run.
    done,      ///< One is in force.
  };
  Phase phase = Phase::watching;
  Step step = Step::none;  ///< The step that runs, or that is waited for.
  std::string_view hint;   ///< Why the last attempt failed, else empty; refers to static storage.
};

/// What a guided calibration asks of the performer for a modality, whatever else it asks: a full one goes on
/// with expressions, through which guide_range() leads.
struct Guidance {
  Duration neutral = std::chrono::seconds(3);
  bool gestures = true;        ///< The head nods and shakes.
  bool learns_wearer = false;  ///< It can learn its wearer from expressions (guide_expression()).
  bool learns_gaze = false;    ///< It can learn from targets what it finds where eyes look (guide_gaze()).
};

/// So long after the last expression a wearer is learnt: a fixed time, so that a replay gives the same bits
/// however quick the machine is. The work itself takes a second or two.
inline constexpr Duration kWearerLearnt = std::chrono::seconds(6);
/// Guidance is over so much later, when frames have been answered by it.
inline constexpr Duration kWearerShown = std::chrono::milliseconds(500);

/// When a step of the calibration in force was performed, on the reference's time line.
struct PerformedStep {
  Step step;
  DeviceTime begin, end;
};

/// What became of a calibration at a tick.
struct CalibrationEvent {
  enum class Kind : std::uint8_t {
    calibrated,  ///< One is in force that was not before: by guidance, or of the tracker's own accord.
    judged,      ///< The one in force was scored anew (a shake checks it).
    withdrawn,   ///< Guidance failed: what was in force before its first step is in force again.
  };
  Kind kind = Kind::calibrated;
  std::string_view modality;  ///< Whose: Tracker::modality() of the tracker that has it.
  /// The steps that the tracker found of its own accord since its last event; guided ones are known to who
  /// guided.
  std::vector<PerformedStep> found;
};

/// How sure a tracker is of a sensor's rotation.
struct SensorCertainty {
  double sigma_rad = 0;   ///< Standard deviation of its angle's error: what drift since the calibration left.
  bool left_out = false;  ///< It is too uncertain: frames are answered without it.
};

/// What a rest came to (Tracker::rest()): sensors by their numbers in the rig.
struct RestOutcome {
  std::vector<std::uint16_t> corrected;
  std::vector<std::uint16_t> moved;   ///< Moved, or the face did, and were not corrected.
  std::vector<std::uint16_t> absent;  ///< Were missing for more than half of it.
};

/// What a tick returns beside the frame.
struct TickResult {
  /// How many sensors were there: 0 asks whoever shapes to hold and to ease to neutral, a change to ease
  /// over.
  std::size_t sensors_present = 0;
  std::vector<CalibrationEvent> calibration;  ///< Nearly always empty.
  /// What these sensors explain of each shape: by this trackers of one face are compared (shaping::Merge).
  /// None where nobody measured it; then they are compared by the frame's confidence.
  std::optional<Explained> explained = {};
  /// What is heard; none of a tracker that does not listen.
  struct Hearing {
    bool speaks = false;  ///< Somebody does.
    /// By how much it is asked for later than the frame, since sound lags behind the face.
    Duration later{};
    /// By how much what was told is older than what was asked for: nobody has heard the rest yet.
    Duration behind{};
  };
  std::optional<Hearing> hearing = {};
  /// Of a rest that ended at this frame.
  std::optional<RestOutcome> rested = {};
};

/// One modality's way from samples to output frames; the only face that the live session sees of it. A pure
/// function of the calls, in their order: live and replay give the same bits. Thread: one at a time. No
/// allocation in add and tick after start-up, but where a calibration is made.
class Tracker {
 public:
  virtual ~Tracker() = default;
  /// The kind of its sensors, as rigs name it; what its calibrations are called in a take.
  [[nodiscard]] virtual std::string_view modality() const = 0;

  /// A decoded sample of one of its own sensors as it arrives. Order of calls is the log's order.
  virtual void add(HostTime arrival, const sensor::Sample& sample) = 0;
  /// The same of a sample with a payload, raw or reduced, at most sensor::kMaxPayload bytes, which is valid
  /// during the call. A modality without payloads takes the sample alone.
  virtual void add_with_payload(HostTime arrival, const sensor::Sample& sample,
                                [[maybe_unused]] std::span<const std::byte> payload) {
    add(arrival, sample);
  }
  /// The sensor's next samples are another device's: nothing that was learned of the one before holds.
  virtual void forget(std::uint16_t sensor) = 0;
  /// The sensor is a camera, and is seen so from its next sample on: what was learned of what it saw before
  /// does not hold, as in forget(). A modality without cameras passes it over.
  virtual void change_view([[maybe_unused]] std::uint16_t sensor,
                           [[maybe_unused]] const sensor::PictureView& view) {}

  /// The answer at a frame of the grid: every field of `out`. Neutral, with that provenance, until there is a
  /// calibration. `lines`: every sensor's clock, and the time line on which `frame` stands.
  virtual TickResult tick(DeviceTime frame, const sensor::TimeLines& lines, face::OutputFrame& out) = 0;

  /// The features from which the last tick's frame was estimated, as a model of features reads them; null of
  /// a modality without them. Valid until the next tick.
  [[nodiscard]] virtual const model::FeatureFrame* features() const { return nullptr; }

  // Of a modality with something to calibrate; the others leave all of this as it is.

  /// What it wants of a guided calibration.
  [[nodiscard]] virtual Guidance guidance() const { return {.neutral = Duration::zero(), .gestures = false}; }
  /// A guided step runs on the frames [begin, end); given before the tick of its begin. The last step's end
  /// puts the calibration in force.
  virtual void guide([[maybe_unused]] Step step, [[maybe_unused]] DeviceTime begin,
                     [[maybe_unused]] DeviceTime end) {}
  /// The same of expressions that move the whole face, one after the other: a range of motion. It follows the
  /// steps. A modality that has no use for it passes it over.
  virtual void guide_range([[maybe_unused]] DeviceTime begin, [[maybe_unused]] DeviceTime end) {}
  /// One of the expressions that a calibration asks for which learns its wearer too; given beforehand, in
  /// their order, before the first begins. What is learnt comes into force kWearerLearnt after the last one's
  /// end. A modality that has no use for it passes it over.
  virtual void guide_expression([[maybe_unused]] const PromptedExpression& asked) {}
  /// The eyes rest on a target on the frames [begin, end). All of a calibration's targets are given before
  /// the first begins, after the steps; the last one's end puts in force what was learnt. A modality that has
  /// no use for them passes them over.
  virtual void guide_gaze([[maybe_unused]] const face::GazeTarget& target, [[maybe_unused]] DeviceTime begin,
                          [[maybe_unused]] DeviceTime end) {}
  /// Ends guidance; what was in force before its first step is in force again.
  virtual void cancel_guidance() {}

  /// How long its performer would have to rest now for rest(); zero where that would correct nothing.
  [[nodiscard]] virtual Duration wants_rest() const { return {}; }
  /// The performer has been asked to rest, face and head as in the calibration's neutral, on the frames
  /// [begin, end); given before the tick of its begin. What has drifted since the calibration is corrected by
  /// it before the first frame at or after `end`. An empty rest ends one that was asked for before. A
  /// modality that has no use for it passes it over.
  virtual void rest([[maybe_unused]] DeviceTime begin, [[maybe_unused]] DeviceTime end) {}

  /// Until it is Phase::done, users are asked to calibrate.
  [[nodiscard]] virtual CalibrationState calibration_state() const {
    return {.phase = CalibrationState::Phase::done};
  }
  /// The calibration in force as JSON, as a take keeps it; empty when there is none.
  [[nodiscard]] virtual std::string calibration() const { return {}; }
  [[nodiscard]] virtual std::vector<sensor::Score> scores() const { return {}; }
  /// Puts an earlier one in force. Gives no calibration event. Errors: malformed, mismatch (another rig's).
  [[nodiscard]] virtual Result<void> restore([[maybe_unused]] std::string_view json) {
    return fail(ErrorCode::mismatch, "a tracker of " + std::string(modality()) + " has no calibration",
                "calibration");
  }
  /// Answers are corrected for the wearer by this from now on, until another is given or a calibration is
  /// restored that has none; it is a part of calibration(). Errors: unsupported (a modality whose model is
  /// not corrected), not_found (nothing is calibrated).
  [[nodiscard]] virtual Result<void> correct([[maybe_unused]] const model::Correction& correction) {
    return fail(ErrorCode::unsupported, "nothing here is corrected for its wearer", "session",
                "it takes sensors on the skin and a model such as models/live.safetensors");
  }

  /// Standard deviation of a sensor's heading, rad; none where it has no heading.
  [[nodiscard]] virtual std::optional<double> heading_sigma_rad([[maybe_unused]] std::uint16_t sensor) const {
    return {};
  }
  /// At the last tick; none of a sensor that was missing, is not calibrated, or whose rotation is no matter.
  [[nodiscard]] virtual std::optional<SensorCertainty> certainty(
      [[maybe_unused]] std::uint16_t sensor) const {
    return {};
  }
  /// How often an estimate of drift began anew because its covariance was none: defects of this program.
  [[nodiscard]] virtual std::uint64_t faults() const { return 0; }
};

}  // namespace mien::tracker
