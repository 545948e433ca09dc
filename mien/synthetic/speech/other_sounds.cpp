#include "mien/synthetic/speech/other_sounds.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mien/speech/sound_block.h"

namespace mien::synthetic {
namespace {

constexpr double kRate = speech::kRateHz;
constexpr double kLevel = 0.1;

std::size_t samples_in(double seconds) {
  return static_cast<std::size_t>(std::max(0.0, seconds * kRate));
}

/// Two poles and two zeros (Bristow-Johnson's cookbook).
class Biquad {
 public:
  static Biquad low_pass(double hz, double q) {
    const double w = 2 * std::numbers::pi * hz / kRate, c = std::cos(w);
    return Biquad((1 - c) / 2, 1 - c, (1 - c) / 2, w, q);
  }
  static Biquad high_pass(double hz, double q) {
    const double w = 2 * std::numbers::pi * hz / kRate, c = std::cos(w);
    return Biquad((1 + c) / 2, -(1 + c), (1 + c) / 2, w, q);
  }
  static Biquad band_pass(double hz, double q) {
    const double w = 2 * std::numbers::pi * hz / kRate, alpha = std::sin(w) / (2 * q);
    return Biquad(alpha, 0, -alpha, w, q);
  }
  double operator()(double in) {
    const double out = b0_ * in + s1_;
    s1_ = b1_ * in - a1_ * out + s2_;
    s2_ = b2_ * in - a2_ * out;
    return out;
  }

 private:
  Biquad(double b0, double b1, double b2, double w, double q) {
    const double alpha = std::sin(w) / (2 * q), a0 = 1 + alpha;
    b0_ = b0 / a0;
    b1_ = b1 / a0;
    b2_ = b2 / a0;
    a1_ = -2 * std::cos(w) / a0;
    a2_ = (1 - alpha) / a0;
  }
  double b0_, b1_, b2_, a1_, a2_;
  double s1_ = 0, s2_ = 0;
};

void add_white(Random& random, std::vector<float>& sound) {
  for (float& s : sound) s += static_cast<float>(random.normal());
}

void add_pink(Random& random, std::vector<float>& sound) {
  // First-order sections a factor of about six apart (Kellet's economy filter).
  double a = 0, b = 0, c = 0;
  for (float& s : sound) {
    const double white = random.normal();
    a = 0.99765 * a + white * 0.0990460;
    b = 0.96300 * b + white * 0.2965164;
    c = 0.57000 * c + white * 1.0526913;
    s += static_cast<float>(a + b + c + 0.1848 * white);
  }
}

void add_hum(Random& random, std::vector<float>& sound) {
  const double base_hz = random.chance(0.5) ? (random.chance(0.5) ? 50 : 60) : random.uniform(70, 250);
  for (int harmonic = 1; harmonic <= 12; ++harmonic) {
    const double share = random.uniform(0.1, 1) / harmonic, phase = random.uniform(0, 2 * std::numbers::pi);
    const double step = 2 * std::numbers::pi * base_hz * harmonic / kRate;
    for (std::size_t i = 0; i < sound.size(); ++i)
      sound[i] += static_cast<float>(share * std::sin(phase + step * static_cast<double>(i)));
  }
  Biquad air = Biquad::low_pass(random.uniform(300, 2000), 0.7);
  const double share = random.uniform(0.2, 3);
  for (float& s : sound) s += static_cast<float>(share * air(random.normal()));
}

/// A tone with harmonics, from a sample on.
void add_tone(double hz, double seconds, double strength, bool plucked, Random& random, std::size_t begin,
              std::vector<float>& sound) {
  const std::size_t end = std::min(sound.size(), begin + samples_in(seconds));
  const double vibrato = plucked ? 0 : random.uniform(0, 0.004);
  for (int harmonic = 1; harmonic <= 8 && hz * harmonic < kRate / 2; ++harmonic) {
    const double share = strength * std::pow(harmonic, -random.uniform(0.7, 1.8));
    const double decay = plucked ? (1.5 + harmonic) / seconds : 0.3 / seconds;
    double phase = random.uniform(0, 2 * std::numbers::pi);
    for (std::size_t i = begin; i < end; ++i) {
      const double t = static_cast<double>(i - begin) / kRate;
      const double rise = std::min(1.0, t / (plucked ? 0.005 : 0.06));
      const double fall = std::min(1.0, static_cast<double>(end - i) / samples_in(0.03));
      phase += 2 * std::numbers::pi * hz * harmonic / kRate *
               (1 + vibrato * std::sin(2 * std::numbers::pi * 5.5 * t));
      sound[i] += static_cast<float>(share * rise * fall * std::exp(-decay * t) * std::sin(phase));
    }
  }
}

void add_music(Random& random, std::vector<float>& sound) {
  constexpr std::array kScale = {0, 2, 4, 5, 7, 9, 11};
  const auto hz_of = [&](int degree) {
    const int octave = degree / 7;
    return 110 * std::exp2(octave + kScale[static_cast<std::size_t>(degree % 7)] / 12.0);
  };
  const double beat_s = random.uniform(0.3, 0.7);
  const bool plucked = random.chance(0.5), drums = random.chance(0.6);
  int tune = 14;
  for (std::size_t beat = 0; samples_in(static_cast<double>(beat) * beat_s) < sound.size(); ++beat) {
    const std::size_t begin = samples_in(static_cast<double>(beat) * beat_s);
    if (beat % 4 == 0) {
      const int root = static_cast<int>(random.below(7));
      for (const int third : {0, 2, 4})
        add_tone(hz_of(root + third), 4 * beat_s, 0.4, plucked, random, begin, sound);
    }
    tune = std::clamp(tune + static_cast<int>(random.below(5)) - 2, 7, 24);
    if (random.chance(0.8))
      add_tone(hz_of(tune), beat_s * random.uniform(0.5, 1.5), 1, !plucked, random, begin, sound);
    if (!drums) continue;
    Biquad skin = random.chance(0.5) ? Biquad::low_pass(150, 3) : Biquad::high_pass(3000, 0.7);
    const std::size_t end = std::min(sound.size(), begin + samples_in(0.15));
    for (std::size_t i = begin; i < end; ++i)
      sound[i] += static_cast<float>(3 * skin(random.normal()) *
                                     std::exp(-static_cast<double>(i - begin) / samples_in(0.03)));
  }
}

void add_keyboard(Random& random, std::vector<float>& sound) {
  for (double at_s = random.uniform(0, 0.5); samples_in(at_s) < sound.size();) {
    // A key's way down, its stop, and, softer, its way up.
    for (const double part_s : {0.0, random.uniform(0.008, 0.02), random.uniform(0.06, 0.12)}) {
      const double q = random.uniform(0.7, 3), hz = random.uniform(800, 5000);
      Biquad body = Biquad::band_pass(hz, q);
      const std::size_t begin = samples_in(at_s + part_s),
                        end = std::min(sound.size(), begin + samples_in(0.02));
      const double strength = random.uniform(2, 10), fade = samples_in(random.uniform(0.001, 0.005));
      for (std::size_t i = begin; i < end; ++i)
        sound[i] += static_cast<float>(strength * body(random.normal()) *
                                       std::exp(-static_cast<double>(i - begin) / fade));
    }
    at_s += random.chance(0.1) ? random.uniform(0.5, 3) : random.uniform(0.08, 0.3);
  }
}

/// Noise through a tract, swelling and falling.
void add_air(double at_s, double seconds, double rise, double strength, Random& random,
             std::vector<float>& sound) {
  const double throat_q = random.uniform(0.5, 1.5), throat_hz = random.uniform(400, 1500);
  const double mouth_q = random.uniform(0.5, 1.5), mouth_hz = random.uniform(1500, 4000);
  Biquad throat = Biquad::band_pass(throat_hz, throat_q);
  Biquad mouth = Biquad::band_pass(mouth_hz, mouth_q);
  const double share = random.uniform(0.3, 1);
  const std::size_t begin = samples_in(at_s), end = std::min(sound.size(), begin + samples_in(seconds));
  for (std::size_t i = begin; i < end; ++i) {
    const double part = static_cast<double>(i - begin) / (seconds * kRate);
    const double swell = part < rise ? part / rise : (1 - part) / (1 - rise);
    const double white = random.normal();
    sound[i] += static_cast<float>(strength * swell * (throat(white) + share * mouth(white)));
  }
}

void add_breath(Random& random, std::vector<float>& sound) {
  for (double at_s = random.uniform(0, 1); samples_in(at_s) < sound.size(); at_s += random.uniform(2.5, 5)) {
    const double in_s = random.uniform(0.5, 1.2), out_s = random.uniform(0.8, 1.8);
    const double in_strength = random.uniform(0.5, 1.5), in_rise = random.uniform(0.3, 0.7);
    add_air(at_s, in_s, in_rise, in_strength, random, sound);
    const double out_strength = random.uniform(0.4, 1.5), out_rise = random.uniform(0.1, 0.5);
    add_air(at_s + in_s + random.uniform(0.05, 0.3), out_s, out_rise, out_strength, random, sound);
  }
}

void add_cough(Random& random, std::vector<float>& sound) {
  for (double at_s = random.uniform(0, 2); samples_in(at_s) < sound.size(); at_s += random.uniform(3, 8)) {
    const std::uint64_t bursts = 1 + random.below(3);
    for (std::uint64_t b = 0; b < bursts; ++b) {
      const double strength = random.uniform(3, 8), rise = random.uniform(0.03, 0.1);
      add_air(at_s, random.uniform(0.2, 0.4), rise, strength, random, sound);
      at_s += random.uniform(0.3, 0.5);
    }
  }
}

}  // namespace

double rms_of(const std::vector<float>& sound) {
  double sum = 0;
  for (const float s : sound) sum += double{s} * double{s};
  return sound.empty() ? 0 : std::sqrt(sum / static_cast<double>(sound.size()));
}

std::vector<float> make_other_sound(OtherSound kind, std::size_t samples, Random random) {
  std::vector<float> sound(samples);
  constexpr std::array kMakers = {add_white,    add_pink,   add_hum,  add_music,
                                  add_keyboard, add_breath, add_cough};  // In the order of OtherSound.
  kMakers[static_cast<std::size_t>(kind)](random, sound);
  const double rms = rms_of(sound);
  if (rms == 0) return sound;
  for (float& s : sound) s = static_cast<float>(std::clamp(kLevel / rms * double{s}, -1.0, 1.0));
  return sound;
}

void mix_at(double snr_db, const std::vector<float>& other, std::vector<float>& sound) {
  if (other.empty() || sound.empty()) return;
  // What is quiet is pauses: the upper half of the tenths of a second is speech.
  const std::size_t piece = samples_in(0.1);
  std::vector<double> powers;
  for (std::size_t begin = 0; begin < sound.size(); begin += piece) {
    double sum = 0;
    const std::size_t end = std::min(sound.size(), begin + piece);
    for (std::size_t i = begin; i < end; ++i) sum += double{sound[i]} * double{sound[i]};
    powers.push_back(sum / static_cast<double>(end - begin));
  }
  std::ranges::sort(powers, std::greater());
  powers.resize((powers.size() + 1) / 2);
  double loud = 0;
  for (const double power : powers) loud += power / static_cast<double>(powers.size());
  const double rms = rms_of(other);
  if (rms == 0) return;
  const double gain = std::sqrt(loud) / rms * std::pow(10, -snr_db / 20);
  for (std::size_t i = 0; i < sound.size(); ++i)
    sound[i] += static_cast<float>(gain * double{other[i % other.size()]});
}

void put_in_room(double decay_s, double direct_db, Random random, std::vector<float>& sound) {
  // Sixty echoes, denser the later they are, each of its own sign: a decay without a convolution.
  constexpr int kEchoes = 60;
  struct Echo {
    std::size_t delay;
    double gain;
  };
  std::vector<Echo> echoes;
  double power = 0;
  for (int e = 0; e < kEchoes; ++e) {
    const double at_s = decay_s * std::pow(random.uniform(), 1.5) + 0.002;
    const double gain = std::pow(10, -3 * at_s / decay_s) * (random.chance(0.5) ? 1 : -1);
    echoes.push_back({samples_in(at_s), gain});
    power += gain * gain;
  }
  const double scale = std::pow(10, -direct_db / 20) / std::sqrt(power);
  const std::vector<float> dry = sound;
  for (const Echo& echo : echoes)
    for (std::size_t i = echo.delay; i < sound.size(); ++i)
      sound[i] += static_cast<float>(scale * echo.gain * double{dry[i - echo.delay]});
}

void limit_band(double low_hz, double high_hz, std::vector<float>& sound) {
  Biquad low = Biquad::high_pass(low_hz, std::numbers::sqrt2 / 2);
  Biquad high = Biquad::low_pass(high_hz, std::numbers::sqrt2 / 2);
  for (float& s : sound) s = static_cast<float>(high(low(s)));
}

}  // namespace mien::synthetic
