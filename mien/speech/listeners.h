#pragma once

#include <vector>

#include "mien/speech/articulator.h"
#include "mien/speech/listener.h"
#include "mien/speech/log_mel.h"
#include "mien/speech/phone_decoder.h"
#include "mien/speech/speech_network.h"

namespace mien::speech {

/// The learned way: a recurrent network on log-mel frames. Lips that are closed with a probability of kClosed
/// or more are closed (mouthClose is jawOpen); below it they come together in proportion.
class LearnedListener final : public Listener {
 public:
  /// Raising it misses closures, lowering it closes lips for other sounds. Chosen on validation voices
  /// (docs/experiments/speech.md).
  static constexpr float kClosed = 0.5F;

  /// A network's answers tremble; so smoothed they come 25 ms later. Chosen on validation voices likewise.
  static constexpr double kSmoothing = 80;

  explicit LearnedListener(SpeechNetwork network)
      : network_(std::move(network)), confidence_(network_.file().confidence) {}
  [[nodiscard]] const tracker::ShapeConfidence* confidence() const override {
    return network_.file().confidence ? &confidence_ : nullptr;
  }
  [[nodiscard]] double smoothing() const override { return kSmoothing; }
  Heard push(DeviceTime time, const Block& block) override;
  void reset() override;

 private:
  LogMel mel_;
  SpeechNetwork network_;
  tracker::ShapeConfidence confidence_;
  HeardMouth mouth_;
};

/// The faithful way: phones of PocketSphinx, visemes, coarticulation. It answers for kDelay before the
/// block's end, when a phone that has just been told is in its middle; lips that closed are known when they
/// part.
class PhoneListener final : public Listener {
 public:
  static constexpr Duration kDelay = std::chrono::milliseconds(60);

  explicit PhoneListener(PhoneDecoder decoder) : decoder_(std::move(decoder)) {}
  Heard push(DeviceTime time, const Block& block) override;
  void reset() override;

 private:
  PhoneDecoder decoder_;
  Articulator articulator_;
  std::vector<TimedSound> sounds_;
  std::uint64_t blocks_ = 0;
};

}  // namespace mien::speech
