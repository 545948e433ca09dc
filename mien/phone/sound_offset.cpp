#include "mien/phone/sound_offset.h"

#include <fmt/format.h>

#include <unsupported/Eigen/FFT>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include "mien/core/median.h"
#include "mien/core/resample.h"

namespace mien::phone {
namespace {

/// Speech and its room have most below 4 kHz, and small microphones little below 150 Hz.
constexpr std::uint32_t kSoundRateHz = 8'000;
constexpr double kLowestHz = 150, kHighestHz = 3'600;

/// Envelopes: every 10 ms over 32 ms, in bands between these, Hz.
constexpr std::size_t kHop = 80, kWindow = 256;
constexpr double kEnvelopeRateHz = static_cast<double>(kSoundRateHz) / kHop;
constexpr std::array<double, 5> kBandEdges_hz = {kLowestHz, 500, 1'000, 2'000, kHighestHz};
constexpr std::size_t kBands = kBandEdges_hz.size() - 1;
/// Less their mean over so long around, s: how loud a room is, or made by who evens it, does not count.
constexpr double kMeanOver_s = 1;
/// Quieter than the loudest by this is silence: 60 dB of power.
constexpr double kSilence = 1e-6;
/// Root mean square below which nothing is heard: -80 dB of full scale.
constexpr double kLeastLoudness = 1e-4;
/// Two offsets farther apart than this are not one, s.
constexpr double kPeak_s = 0.5;

/// Blocks: how many at most, how long at most, and how far their own offsets may be from the envelopes', s:
/// 100 ppm over two hours, of which half lies on each side.
constexpr double kMostBlocks = 60, kLongestBlock_s = 4, kBlockReach_s = 0.4;
/// On the line is what is no farther from it, s: a wall's echo may be louder than the mouth.
constexpr double kOnLine_s = 0.003;
/// No crystals are farther apart, and they are rarely farther than the second, ppm.
constexpr double kMostSoundDrift_ppm = 500, kUsualSoundDrift_ppm = 50;
/// Of the blocks this many must lie on one line, and three.
constexpr double kLeastAgreeing = 0.3;
/// No block's offset is better than that, s: two samples.
constexpr double kBlockSigma_s = 2.5e-4;

using Spectrum = std::vector<std::complex<float>>;
using Envelope = std::array<std::vector<float>, kBands>;

/// Less the mean of kMeanOver_s around, of unit root mean square; zeros where it hardly changes.
void make_even(std::vector<float>& values) {
  const auto count = static_cast<std::ptrdiff_t>(values.size());
  std::vector<double> sums(values.size() + 1, 0);
  for (std::size_t i = 0; i < values.size(); ++i) sums[i + 1] = sums[i] + double{values[i]};
  constexpr auto kHalf = static_cast<std::ptrdiff_t>(0.5 * kMeanOver_s * kEnvelopeRateHz);
  double squares = 0;
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const std::ptrdiff_t from = std::max<std::ptrdiff_t>(0, i - kHalf), to = std::min(count, i + kHalf + 1);
    const double mean = (sums[static_cast<std::size_t>(to)] - sums[static_cast<std::size_t>(from)]) /
                        static_cast<double>(to - from);
    float& value = values[static_cast<std::size_t>(i)];
    value = static_cast<float>(double{value} - mean);
    squares += double{value} * double{value};
  }
  const double rms = std::sqrt(squares / static_cast<double>(std::max<std::ptrdiff_t>(1, count)));
  const double scale = rms > 1e-3 ? 1 / rms : 0;
  for (float& value : values) value = static_cast<float>(scale * double{value});
}

/// Logarithms of power in bands, every kHop samples.
Envelope envelope_of(std::span<const float> samples) {
  std::array<float, kWindow> window{};
  for (std::size_t i = 0; i < kWindow; ++i)
    window[i] = static_cast<float>(
        0.5 - 0.5 * std::cos(2 * std::numbers::pi * (static_cast<double>(i) + 0.5) / kWindow));
  std::array<std::size_t, kBandEdges_hz.size()> edges{};
  for (std::size_t e = 0; e < edges.size(); ++e)
    edges[e] = static_cast<std::size_t>(std::lround(kBandEdges_hz[e] * kWindow / kSoundRateHz));
  const std::size_t count = samples.size() < kWindow ? 0 : (samples.size() - kWindow) / kHop + 1;
  Envelope out;
  for (std::vector<float>& band : out) band.resize(count);
  Eigen::FFT<float> fft;
  std::vector<float> in(kWindow);
  Spectrum bins(kWindow);
  for (std::size_t f = 0; f < count; ++f) {
    for (std::size_t i = 0; i < kWindow; ++i) in[i] = window[i] * samples[f * kHop + i];
    fft.fwd(bins.data(), in.data(), static_cast<Eigen::Index>(kWindow));
    for (std::size_t b = 0; b < kBands; ++b) {
      float power = 0;
      for (std::size_t bin = edges[b]; bin < edges[b + 1]; ++bin) power += std::norm(bins[bin]);
      out[b][f] = power;
    }
  }
  for (std::vector<float>& band : out) {
    const float loudest = count == 0 ? 0 : *std::ranges::max_element(band);
    const float silence = std::max(1e-12F, static_cast<float>(kSilence * double{loudest}));
    for (float& power : band) power = std::log(power + silence);
    make_even(band);
  }
  return out;
}

/// Sums of squares of all bands before each place.
std::vector<double> energy_before(const Envelope& envelope) {
  std::vector<double> sums(envelope.front().size() + 1, 0);
  for (std::size_t f = 0; f + 1 < sums.size(); ++f) {
    sums[f + 1] = sums[f];
    for (const std::vector<float>& band : envelope) sums[f + 1] += double{band[f]} * double{band[f]};
  }
  return sums;
}

/// Sum over bands of each lag's products: place `lag` modulo the length is of the first's frame at the
/// other's first.
std::vector<float> correlation_of(const Envelope& first, const Envelope& other) {
  const std::size_t length = std::bit_ceil(first.front().size() + other.front().size());
  Eigen::FFT<float> fft;
  std::vector<float> in(length), out(length);
  Spectrum sum(length), a(length), b(length);
  const auto transform = [&](const std::vector<float>& band, Spectrum& into) {
    std::ranges::fill(in, 0.0F);
    std::ranges::copy(band, in.begin());
    fft.fwd(into.data(), in.data(), static_cast<Eigen::Index>(length));
  };
  for (std::size_t band = 0; band < kBands; ++band) {
    transform(first[band], a);
    transform(other[band], b);
    for (std::size_t i = 0; i < length; ++i) sum[i] += a[i] * std::conj(b[i]);
  }
  fft.inv(out.data(), sum.data(), static_cast<Eigen::Index>(length));
  return out;
}

/// An offset, and how far it stands out.
struct Peak {
  double offset_s = 0;
  double score = 0;
};

/// The best of all offsets by the envelopes.
std::optional<Peak> coarse_offset(const Envelope& first, const Envelope& other) {
  const std::vector<float> correlation = correlation_of(first, other);
  const std::vector<double> first_before = energy_before(first), other_before = energy_before(other);
  const auto first_size = static_cast<std::ptrdiff_t>(first.front().size());
  const auto other_size = static_cast<std::ptrdiff_t>(other.front().size());
  constexpr auto kLeast = static_cast<std::ptrdiff_t>(0.9 * kLeastSoundS * kEnvelopeRateHz);
  // As a correlation times the root of how much there is: by chance all offsets are alike.
  const auto strength = [&](std::ptrdiff_t lag) {
    const std::ptrdiff_t begin = std::max<std::ptrdiff_t>(0, lag),
                         end = std::min(first_size, lag + other_size);
    if (end - begin < kLeast) return 0.0;
    const auto energy = [&](const std::vector<double>& before, std::ptrdiff_t shift) {
      return before[static_cast<std::size_t>(end - shift)] - before[static_cast<std::size_t>(begin - shift)];
    };
    const double energies = energy(first_before, 0) * energy(other_before, lag);
    const auto place =
        static_cast<std::size_t>(lag < 0 ? lag + static_cast<std::ptrdiff_t>(correlation.size()) : lag);
    if (!(energies > 1e-6)) return 0.0;
    return double{correlation[place]} * std::sqrt(static_cast<double>(end - begin) / energies);
  };
  const std::ptrdiff_t least = kLeast - other_size, most = first_size - kLeast;
  std::ptrdiff_t best = least;
  double best_strength = 0;
  for (std::ptrdiff_t lag = least; lag <= most; ++lag)
    if (const double now = strength(lag); now > best_strength) best = lag, best_strength = now;
  if (!(best_strength > 0)) return std::nullopt;
  // By chance at least as strong as one standard deviation, so that a score is finite.
  double second = 1;
  for (std::ptrdiff_t lag = least; lag <= most; ++lag)
    if (std::abs(static_cast<double>(lag - best)) > kPeak_s * kEnvelopeRateHz)
      second = std::max(second, strength(lag));
  return Peak{static_cast<double>(best) / kEnvelopeRateHz, best_strength / second};
}

/// When a block was heard by the first, and by how much that is later than by the other's time, s.
struct BlockOffset {
  double time_s = 0;
  double offset_s = 0;
};

/// Cross-correlation with phase transform of pieces, each of which has the same length.
class PhaseTransform {
 public:
  /// `block`: samples of the other's piece; the first's has twice `reach` more.
  PhaseTransform(std::size_t block, std::size_t reach)
      : block_(block), reach_(reach), length_(std::bit_ceil(block + 2 * reach)) {}

  /// By how many samples the other's piece, `at` within it, is later in the first than `expected`; none
  /// where nothing is heard. Pieces reach beyond neither.
  std::optional<double> lag(std::span<const float> first, std::span<const float> other, std::ptrdiff_t at,
                            std::ptrdiff_t expected) {
    const auto reach = static_cast<std::ptrdiff_t>(reach_), block = static_cast<std::ptrdiff_t>(block_);
    in_.assign(length_, 0.0F);
    // Where the first ends sooner the piece has silence.
    for (std::ptrdiff_t i = 0; i < block + 2 * reach; ++i)
      if (const std::ptrdiff_t place = expected - reach + i;
          place >= 0 && place < static_cast<std::ptrdiff_t>(first.size()))
        in_[static_cast<std::size_t>(i)] = first[static_cast<std::size_t>(place)];
    a_.resize(length_);
    fft_.fwd(a_.data(), in_.data(), static_cast<Eigen::Index>(length_));
    in_.assign(length_, 0.0F);
    for (std::ptrdiff_t i = 0; i < block; ++i) {
      const double window = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * (static_cast<double>(i) + 0.5) /
                                                 static_cast<double>(block));
      in_[static_cast<std::size_t>(i)] =
          static_cast<float>(window * double{other[static_cast<std::size_t>(at + i)]});
    }
    b_.resize(length_);
    fft_.fwd(b_.data(), in_.data(), static_cast<Eigen::Index>(length_));
    const auto bin = [&](double frequency_hz) {
      return static_cast<std::size_t>(frequency_hz / kSoundRateHz * static_cast<double>(length_));
    };
    const std::size_t lowest = bin(kLowestHz), highest = bin(kHighestHz);
    for (std::size_t i = 0; i < length_; ++i) {
      const std::size_t frequency = std::min(i, length_ - i);
      if (frequency < lowest || frequency > highest) {
        a_[i] = 0;
        continue;
      }
      a_[i] *= std::conj(b_[i]);
      const float magnitude = std::abs(a_[i]);
      a_[i] = magnitude > 1e-20F ? a_[i] / magnitude : 0;
    }
    fft_.inv(in_.data(), a_.data(), static_cast<Eigen::Index>(length_));
    // A microphone may be wired the other way round.
    const auto height = [&](std::size_t i) { return std::abs(in_[i]); };
    std::size_t best = 1;
    for (std::size_t i = 1; i < 2 * reach_; ++i)
      if (height(i) > height(best)) best = i;
    if (!(height(best) > 0)) return std::nullopt;
    const float before = height(best - 1), middle = height(best), after = height(best + 1);
    const float bend = before - 2 * middle + after;
    const double between = bend < 0 ? std::clamp(0.5 * double{(before - after) / bend}, -0.5, 0.5) : 0.0;
    return static_cast<double>(best) + between - static_cast<double>(reach_);
  }

 private:
  std::size_t block_, reach_, length_;
  Eigen::FFT<float> fft_;
  std::vector<float> in_;
  Spectrum a_, b_;
};

/// Each block's own offset, from the loudest piece of each of so many equal parts.
std::vector<BlockOffset> block_offsets(std::span<const float> first, std::span<const float> other,
                                       double coarse_s) {
  const auto place = [](double time_s) {
    return static_cast<std::ptrdiff_t>(std::lround(time_s * kSoundRateHz));
  };
  const std::ptrdiff_t shift = place(coarse_s);
  const std::ptrdiff_t begin = std::max<std::ptrdiff_t>(0, -shift);
  const std::ptrdiff_t end =
      std::min(static_cast<std::ptrdiff_t>(other.size()), static_cast<std::ptrdiff_t>(first.size()) - shift);
  const double overlap_s = static_cast<double>(end - begin) / kSoundRateHz;
  const double block_s = std::min(kLongestBlock_s, overlap_s / 4);
  const auto parts =
      static_cast<std::ptrdiff_t>(std::clamp(std::floor(overlap_s / block_s), 1.0, kMostBlocks));
  const std::ptrdiff_t block = place(block_s), part = (end - begin) / parts;
  if (block < 1 || part < block) return {};
  PhaseTransform transform(static_cast<std::size_t>(block), static_cast<std::size_t>(place(kBlockReach_s)));
  std::vector<BlockOffset> out;
  for (std::ptrdiff_t p = 0; p < parts; ++p) {
    const std::ptrdiff_t from = begin + p * part;
    const auto energy = [&](std::ptrdiff_t at) {
      double sum = 0;
      for (const float sample : other.subspan(static_cast<std::size_t>(at), static_cast<std::size_t>(block)))
        sum += double{sample} * double{sample};
      return sum;
    };
    std::ptrdiff_t loudest = from;
    double most = -1;
    for (std::ptrdiff_t at = from; at + block <= from + part; at += block)
      if (const double now = energy(at); now > most) loudest = at, most = now;
    if (!(most > 0)) continue;
    if (const auto lag = transform.lag(first, other, loudest, loudest + shift))
      out.push_back({(static_cast<double>(loudest + shift) + 0.5 * static_cast<double>(block)) / kSoundRateHz,
                     (static_cast<double>(shift) + *lag) / kSoundRateHz});
  }
  return out;
}

/// The line through most of the blocks: its offset in the middle, its slope, and what is known of both.
struct Line {
  double offset_s = 0, slope = 0;
  double offset_sigma_s = 0, slope_sigma = 0;
  std::size_t on_it = 0;
};

Line line_through(std::span<const BlockOffset> blocks, double middle_s) {
  const auto on_line = [&](const BlockOffset& block, double offset_s, double slope) {
    return std::abs(block.offset_s - offset_s - slope * (block.time_s - middle_s)) <= kOnLine_s;
  };
  Line best;
  for (std::size_t i = 0; i < blocks.size(); ++i)
    for (std::size_t j = i; j < blocks.size(); ++j) {
      // Through one block alone: a line without drift.
      const double slope =
          i == j ? 0 : (blocks[j].offset_s - blocks[i].offset_s) / (blocks[j].time_s - blocks[i].time_s);
      if (!(std::abs(slope) <= 1e-6 * kMostSoundDrift_ppm)) continue;
      const double offset_s = blocks[i].offset_s - slope * (blocks[i].time_s - middle_s);
      const auto count = static_cast<std::size_t>(std::ranges::count_if(
          blocks, [&](const BlockOffset& block) { return on_line(block, offset_s, slope); }));
      if (count > best.on_it) best = {.offset_s = offset_s, .slope = slope, .on_it = count};
    }
  // Least squares over those, with what is known of crystals.
  std::vector<BlockOffset> used;
  std::ranges::copy_if(blocks, std::back_inserter(used),
                       [&](const BlockOffset& block) { return on_line(block, best.offset_s, best.slope); });
  double sigma_s = kBlockSigma_s;
  for (int round = 0; round < 2 && !used.empty(); ++round) {
    const double weight = 1 / (sigma_s * sigma_s);
    double a = 0, b = 0, c = std::pow(1e-6 * kUsualSoundDrift_ppm, -2), u = 0, v = 0;
    for (const BlockOffset& block : used) {
      const double t = block.time_s - middle_s;
      a += weight, b += weight * t, c += weight * t * t;
      u += weight * block.offset_s, v += weight * t * block.offset_s;
    }
    const double determinant = a * c - b * b;
    best.offset_s = (c * u - b * v) / determinant;
    best.slope = (a * v - b * u) / determinant;
    best.offset_sigma_s = std::sqrt(c / determinant);
    best.slope_sigma = std::sqrt(a / determinant);
    double squares = 0;
    for (const BlockOffset& block : used)
      squares += std::pow(block.offset_s - best.offset_s - best.slope * (block.time_s - middle_s), 2);
    sigma_s =
        std::max(kBlockSigma_s, std::sqrt(squares / std::max(1.0, static_cast<double>(used.size()) - 2)));
  }
  return best;
}

Result<void> check_heard(const Sound& sound, const char* which) {
  if (sound.duration_s() < kLeastSoundS)
    return fail(ErrorCode::not_found, fmt::format("{} is {:.1f} s long, {:.0f} s are asked", which,
                                                  sound.duration_s(), kLeastSoundS));
  double squares = 0;
  for (const float sample : sound.samples) squares += double{sample} * double{sample};
  if (!(std::sqrt(squares / static_cast<double>(sound.samples.size())) >= kLeastLoudness))
    return fail(ErrorCode::not_found, fmt::format("{} is silent", which));
  return {};
}

}  // namespace

Result<SoundOffset> sound_offset(const Sound& first, const Sound& other) {
  MIEN_TRY(check_heard(first, "the take's sound"));
  MIEN_TRY(check_heard(other, "the phone's sound"));
  const Sound a = resampled(first, kSoundRateHz), b = resampled(other, kSoundRateHz);
  const std::optional<Peak> peak = coarse_offset(envelope_of(a.samples), envelope_of(b.samples));
  if (!peak || !(peak->score >= kLeastSoundScore))
    return fail(ErrorCode::mismatch,
                fmt::format("the sounds do not match at any offset (the best is {:.2f} times the second, "
                            "{:.1f} is asked)",
                            peak ? peak->score : 0.0, kLeastSoundScore));
  const std::vector<BlockOffset> blocks = block_offsets(a.samples, b.samples, peak->offset_s);
  const double begin_s = std::max(0.0, peak->offset_s),
               end_s = std::min(a.duration_s(), b.duration_s() + peak->offset_s);
  SoundOffset out;
  out.middle_s = 0.5 * (begin_s + end_s);
  out.overlap_s = end_s - begin_s;
  out.score = peak->score;
  const Line line = line_through(blocks, out.middle_s);
  out.agreeing = blocks.empty() ? 0 : static_cast<double>(line.on_it) / static_cast<double>(blocks.size());
  if (line.on_it < 3 || out.agreeing < kLeastAgreeing)
    return fail(ErrorCode::mismatch,
                fmt::format("the sounds do not match ({} of {} blocks agree about the offset)", line.on_it,
                            blocks.size()));
  out.offset_s = line.offset_s;
  out.offset_sigma_s = line.offset_sigma_s;
  // first = middle + offset + slope (first - middle) as its offset: the other's clock is slow by the slope.
  out.drift_ppm = 1e6 * line.slope;
  out.drift_sigma_ppm = 1e6 * line.slope_sigma;
  return out;
}

}  // namespace mien::phone
