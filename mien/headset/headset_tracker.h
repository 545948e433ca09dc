#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/newest.h"
#include "mien/headset/answer.h"
#include "mien/headset/confidence_gain.h"
#include "mien/headset/feature_record.h"
#include "mien/headset/feature_reducer.h"
#include "mien/headset/gaze_learner.h"
#include "mien/headset/headset_camera.h"
#include "mien/headset/headset_model.h"
#include "mien/headset/moment_features.h"
#include "mien/headset/neutral_face.h"
#include "mien/headset/picture_statistics.h"
#include "mien/headset/wearer_calibration.h"
#include "mien/sensor/rig.h"
#include "mien/tracker/jitter_filter.h"
#include "mien/tracker/tracker.h"

namespace mien::headset {

/// Tracker of the modality "camera": at each frame the newest features of each camera of a headset
/// (FeatureRecord), and what they are from the wearer's own face at rest where that is known, through the
/// model's memory, or moment by moment where it has none. Pictures that come as such it reduces itself, to
/// the same bits. A camera whose newest picture is older than kPresent, or stands still (FrozenPictures), is
/// missing: the network knows a token for that. Frames without any camera are forgotten, and so is what was
/// before them. A memory's weights follow what is found as far as it is sure of it (ConfidenceGain), and pass
/// the filter that all causal networks' do (tracker::JitterFilter).
///
/// It answers without a calibration too. Confidence of regions and of the eyes' directions is the memory's
/// judgement (HeadsetModel::probability); a shape has its region's, less where the camera that sees its side
/// is missing. Without a memory that of a shape says which of the cameras that see it are there, and that of
/// regions is unknown. Shapes that a camera sees are measured; others, and the eight that follow the eyes,
/// predicted. Eye directions are those last seen while both lids are closed. No head.
///
/// What targets taught of the eyes' directions (GazeLearner) belongs to the neutral that they were read
/// against. A later neutral keeps its gains, and drops its offset.
///
/// No allocation in add and tick, but where a calibration is made.
class HeadsetTracker final : public tracker::Tracker {
 public:
  static constexpr Duration kPresent = std::chrono::milliseconds(100);
  /// A picture so much later than a frame is taken for it: half a frame, so that the picture is the nearest.
  static constexpr Duration kAhead = std::chrono::microseconds(8333);
  static constexpr Duration kNeutral = std::chrono::seconds(3), kRest = std::chrono::seconds(2);

  /// Errors: FeatureReducer::create's.
  [[nodiscard]] static Result<std::unique_ptr<HeadsetTracker>> create(
      const sensor::Rig& rig, std::shared_ptr<const HeadsetModel> model);

  [[nodiscard]] std::string_view modality() const override { return "camera"; }
  /// Nothing: a picture is its payload.
  void add(HostTime, const sensor::Sample&) override {}
  void add_with_payload(HostTime arrival, const sensor::Sample& sample,
                        std::span<const std::byte> payload) override;
  void forget(std::uint16_t sensor) override;
  void change_view(std::uint16_t sensor, const sensor::PictureView& view) override;
  tracker::TickResult tick(DeviceTime frame, const sensor::TimeLines& lines, face::OutputFrame& out) override;
  /// Three seconds of neutral; no gestures; targets for the eyes where a camera sees one.
  [[nodiscard]] tracker::Guidance guidance() const override;
  void guide(tracker::Step step, DeviceTime begin, DeviceTime end) override;
  /// Nothing is learnt from it; until its end guidance can be cancelled.
  void guide_range(DeviceTime begin, DeviceTime end) override;
  void guide_gaze(const face::GazeTarget& target, DeviceTime begin, DeviceTime end) override;
  void cancel_guidance() override;
  /// Two seconds once there is a neutral. A rest replaces it, of the cameras that gave pictures in half of
  /// it: a headset that has slipped shows the face at rest otherwise. Nothing is replaced where the face
  /// moved.
  [[nodiscard]] Duration wants_rest() const override;
  void rest(DeviceTime begin, DeviceTime end) override;
  /// Done where nothing is calibrated yet, too: nobody is asked for anything before a face is shown.
  [[nodiscard]] tracker::CalibrationState calibration_state() const override;
  [[nodiscard]] std::string calibration() const override;
  [[nodiscard]] std::vector<sensor::Score> scores() const override;
  [[nodiscard]] Result<void> restore(std::string_view json) override;

 private:
  struct Seen {
    DeviceTime time;  // Middle of the exposure, the camera's clock.
    bool frozen = false;
    std::vector<float> features;
  };
  /// One camera's newest pictures.
  struct Channel {
    HeadsetCamera camera;
    Newest<Seen, 32> pictures;
    FrozenPictures frozen;
    /// The newest that is not later than kAhead after `time`; null where it is missing.
    [[nodiscard]] const Seen* at(DeviceTime time) const;
  };
  struct Hold {
    DeviceTime begin, end;
  };

  HeadsetTracker(std::vector<HeadsetCamera> cameras, std::shared_ptr<const HeadsetModel> model,
                 FeatureReducer reducer);
  /// What comes next has nothing to do with what was.
  void forget_moments();
  /// Features of the frame into moment_.
  void gather(DeviceTime frame, const sensor::TimeLines& lines);
  /// What the network makes of the moment beside `rest` into outputs_. `state`: what it remembers, unused
  /// where it has no memory.
  void ask(const MomentFeatures& moment, const RestFeatures& rest, model::CausalNetwork::State* state);
  /// The same of the moment that was read last.
  void ask_again(model::CausalNetwork::State* state);
  /// Puts a neutral in force; the gains of what targets taught stay.
  void use_neutral(NeutralFace neutral);
  /// Ends a rest before the frame at its end is answered; what it came to.
  void end_rest(DeviceTime frame, tracker::TickResult& result);
  /// A step of the guided hold; the event that it ends with.
  void lead(DeviceTime frame, const Answer& answer, tracker::TickResult& result);
  /// A step of what targets teach, with the answer that the neutral corrected; the event that it ends with.
  void lead_gaze(DeviceTime frame, const Answer& answer, tracker::TickResult& result);
  /// Guidance goes on until then at least; what was in force before it is kept.
  void guide_until(DeviceTime end);
  /// Of what was gathered in a hold. `before`: of the cameras that gave pictures in fewer than `least` of its
  /// frames; null: they are unknown. Leaves what the memory remembers of the face at rest in `state`.
  [[nodiscard]] NeutralFace make_neutral(const NeutralFace* before, std::size_t least,
                                         std::optional<model::CausalNetwork::State>& state);
  /// How many frames of a hold must be good for a neutral.
  [[nodiscard]] static std::size_t least_frames(const Hold& hold);
  /// All cameras that ever gave a picture do so now, and there is one.
  [[nodiscard]] bool is_complete(const Present& present) const;
  /// Adds a score for each eye camera: whether it shows an eye as it should, or mirrored.
  void judge_mirrored(NeutralFace& neutral) const;
  /// How sure the network is of what it has just been asked, into judged_.
  void judge();
  void write(const Answer& answer, face::OutputFrame& out);

  std::shared_ptr<const HeadsetModel> model_;
  model::ViewsNetwork::Workspace workspace_;
  FeatureReducer reducer_;
  std::vector<Channel> channels_;
  std::vector<std::byte> reduced_;  // Of a picture that came as such.
  MomentFeatures moment_;
  std::optional<model::CausalNetwork::State> state_;
  // Behind a memory.
  ConfidenceGain confidence_gain_;
  tracker::JitterFilter jitter_filter_;
  std::vector<float> condition_;  // What the network reads of the moment.
  std::array<float, kMemoryOutputs> outputs_{};
  /// How sure a memory is of the frame: of each region, and of the eyes' directions; without one kSeen of the
  /// latter.
  struct Judged {
    ConfidenceGain::Confidence regions{};
    float gaze = 0;
  } judged_;

  std::optional<WearerCalibration> in_force_, before_;
  NeutralMaker maker_;
  GazeLearner gaze_learner_;
  std::optional<Hold> hold_, rest_;  // Guided, and asked for by rest(); never both.
  std::optional<Present> awaited_;   // What was there when the hold began.
  std::optional<DeviceTime> guided_until_;
  std::string_view failure_;
  std::optional<std::array<Eigen::Vector2f, 2>> last_eyes_rad_;
};

}  // namespace mien::headset
