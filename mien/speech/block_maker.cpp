#include "mien/speech/block_maker.h"

#include <fmt/format.h>
#include <samplerate.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace mien::speech {
namespace {

constexpr int kLowest_hz = 1'000, kHighest_hz = 768'000;
/// Samples that are converted at a time.
constexpr std::size_t kPiece = 1024;

std::int16_t clipped(float sample) {
  return static_cast<std::int16_t>(std::lround(std::clamp(sample * kFullScale, -kFullScale, kFullScale - 1)));
}

}  // namespace

struct BlockMaker::Resampler {
  struct Free {
    void operator()(SRC_STATE* its) const { src_delete(its); }
  };
  std::unique_ptr<SRC_STATE, Free> state;  // None: the rate is ours.
  double ratio = 1;
  std::vector<float> out;
  Block block{};
  std::size_t filled = 0;

  void fill(std::span<const float> samples, const Take& take) {
    for (const float sample : samples) {
      block[filled++] = clipped(sample);
      if (filled < kBlockSamples) continue;
      filled = 0;
      take(block);
    }
  }
};

BlockMaker::BlockMaker(std::unique_ptr<Resampler> resampler) : resampler_(std::move(resampler)) {}
BlockMaker::BlockMaker(BlockMaker&&) noexcept = default;
BlockMaker& BlockMaker::operator=(BlockMaker&&) noexcept = default;
BlockMaker::~BlockMaker() = default;

Result<BlockMaker> BlockMaker::create(int rate_hz) {
  if (rate_hz < kLowest_hz || rate_hz > kHighest_hz)
    return fail(ErrorCode::out_of_range, fmt::format("sound of {} Hz", rate_hz), "sound",
                fmt::format("give {} to {} Hz", kLowest_hz, kHighest_hz));
  auto resampler = std::make_unique<Resampler>();
  if (rate_hz != kRateHz) {
    int error = 0;
    resampler->state.reset(src_new(SRC_SINC_MEDIUM_QUALITY, 1, &error));
    if (!resampler->state) return fail(ErrorCode::internal, src_strerror(error), "sound");
    resampler->ratio = static_cast<double>(kRateHz) / rate_hz;
    resampler->out.resize(static_cast<std::size_t>(std::ceil(resampler->ratio * kPiece)) + 64);
  }
  return BlockMaker(std::move(resampler));
}

void BlockMaker::convert(std::span<const float> samples, bool last, const Take& take) {
  Resampler& r = *resampler_;
  SRC_DATA data{};
  data.data_in = samples.data();
  data.input_frames = static_cast<long>(samples.size());
  data.data_out = r.out.data();
  data.output_frames = static_cast<long>(r.out.size());
  data.src_ratio = r.ratio;
  data.end_of_input = last ? 1 : 0;
  // The ratio and the buffers are this file's own, so it has nothing to refuse.
  do {
    if (src_process(r.state.get(), &data) != 0) return;
    r.fill(std::span(r.out).first(static_cast<std::size_t>(data.output_frames_gen)), take);
    data.data_in += data.input_frames_used;
    data.input_frames -= data.input_frames_used;
  } while (data.input_frames > 0 || (last && data.output_frames_gen > 0));
}

void BlockMaker::push(std::span<const float> samples, const Take& take) {
  std::array<float, kPiece> sound{};
  while (!samples.empty()) {
    const std::span<const float> piece = samples.first(std::min(samples.size(), kPiece));
    samples = samples.subspan(piece.size());
    std::ranges::transform(piece, sound.begin(),
                           [](float s) { return std::isfinite(s) ? std::clamp(s, -8.0F, 8.0F) : 0.0F; });
    const std::span<const float> mended = std::span(sound).first(piece.size());
    if (resampler_->state)
      convert(mended, false, take);
    else
      resampler_->fill(mended, take);
  }
}

void BlockMaker::finish(const Take& take) {
  if (resampler_->state) convert({}, true, take);
  Resampler& r = *resampler_;
  if (r.filled == 0) return;
  std::ranges::fill(std::span(r.block).subspan(r.filled), std::int16_t{0});
  r.filled = 0;
  take(r.block);
}

}  // namespace mien::speech
