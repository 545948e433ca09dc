#pragma once

#include <functional>
#include <memory>
#include <span>

#include "mien/core/error.h"
#include "mien/speech/sound_block.h"

namespace mien::speech {

/// Sound of any rate, in pieces of any length, to blocks of 16 kHz: band-limited (libsamplerate's medium
/// sinc, which is 24 ms late where rates differ), clipped to the 16 bits. What is not finite is silence. One
/// stream, one thread.
class BlockMaker {
 public:
  /// Errors: out_of_range (a rate outside 1 kHz to 768 kHz); internal.
  [[nodiscard]] static Result<BlockMaker> create(int rate_hz);
  BlockMaker(BlockMaker&&) noexcept;
  BlockMaker& operator=(BlockMaker&&) noexcept;
  ~BlockMaker();

  using Take = std::function<void(const Block&)>;
  /// Samples from -1 to 1; calls `take` for every block that they complete.
  void push(std::span<const float> samples, const Take& take);
  /// The sound is over: what is left comes, filled up with silence.
  void finish(const Take& take);

 private:
  struct Resampler;
  explicit BlockMaker(std::unique_ptr<Resampler> resampler);
  void convert(std::span<const float> samples, bool last, const Take& take);

  std::unique_ptr<Resampler> resampler_;
};

}  // namespace mien::speech
