#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "mien/sensor/clock_model.h"
#include "mien/speech/sound_block.h"
#include "mien/speech/speech_tracker.h"
#include "mien/synthetic/speech/spoken_passage.h"
#include "mien/tracker/tracker.h"

namespace mien::lab {

/// A microphone before somebody who speaks, and who listens to it, as one tracker of the modality "speech".
/// It is of no rig: its blocks come by hear(), on a clock of its own that is exact.
class PassageMicrophone final : public tracker::Tracker {
 public:
  /// At which moment of the sound it answers.
  enum class Asked : std::uint8_t {
    as_told,   ///< That which tick() names: as shaping::Retiming has it.
    at_frame,  ///< The frame that hear() named, whatever tick() does: without retiming.
  };

  /// `begin`: when the passage's first sample is heard, on the reference's time line: before or after its
  /// first frame where sound is early or late. Errors: none.
  [[nodiscard]] static Result<std::unique_ptr<PassageMicrophone>> create(
      const synthetic::SpokenPassage& passage, DeviceTime begin, speech::SpeechTracker::MakeListener make,
      Asked asked);

  /// Listens up to this frame: to be called before its tick(). Times rise from call to call.
  void hear(DeviceTime frame);

  [[nodiscard]] std::string_view modality() const override { return listener_->modality(); }
  void add(HostTime, const sensor::Sample&) override {}
  void forget(std::uint16_t) override {}
  tracker::TickResult tick(DeviceTime frame, const sensor::TimeLines&, face::OutputFrame& out) override;
  [[nodiscard]] tracker::Guidance guidance() const override { return listener_->guidance(); }
  void guide(tracker::Step, DeviceTime, DeviceTime) override {}
  void cancel_guidance() override {}
  [[nodiscard]] tracker::CalibrationState calibration_state() const override {
    return listener_->calibration_state();
  }
  [[nodiscard]] std::string calibration() const override { return {}; }
  [[nodiscard]] std::vector<sensor::Score> scores() const override { return {}; }
  [[nodiscard]] Result<void> restore(std::string_view json) override { return listener_->restore(json); }
  [[nodiscard]] std::optional<double> heading_sigma_rad(std::uint16_t) const override { return {}; }

 private:
  PassageMicrophone(std::vector<speech::Block> blocks, DeviceTime begin,
                    std::unique_ptr<speech::SpeechTracker> listener, Asked asked)
      : blocks_(std::move(blocks)), begin_(begin), listener_(std::move(listener)), asked_(asked) {}

  std::vector<speech::Block> blocks_;
  DeviceTime begin_;
  std::unique_ptr<speech::SpeechTracker> listener_;
  Asked asked_;
  sensor::TimeLines lines_{1, std::uint16_t{0}};
  std::size_t next_ = 0;  // Block.
  DeviceTime frame_;
};

}  // namespace mien::lab
