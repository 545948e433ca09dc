#include "mien/performer/speech_articulation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

#include "mien/core/units.h"

namespace mien::performer {

using face::shape;

namespace {

/// Sounds in one phoneme; triphthongs with their glides have four.
constexpr std::size_t kMostParts = 4;

/// The movements that speech is made of. Stretch, smile and dimple and so on move both sides.
enum Gesture : std::size_t {
  jaw,
  funnel,
  pucker,
  stretch,
  smile,
  dimple,
  lower_down,
  upper_up,
  press,
  roll_lower,
  roll_upper,
  shrug_lower,
  tongue,
  kGestureCount
};

struct GestureShapes {
  std::size_t left;
  std::size_t right;  // The same as left for the middle.
};
constexpr std::array<GestureShapes, tongue> kGestureShapes = {{
    {shape("jawOpen"), shape("jawOpen")},
    {shape("mouthFunnel"), shape("mouthFunnel")},
    {shape("mouthPucker"), shape("mouthPucker")},
    {shape("mouthStretch_L"), shape("mouthStretch_R")},
    {shape("mouthSmile_L"), shape("mouthSmile_R")},
    {shape("mouthDimple_L"), shape("mouthDimple_R")},
    {shape("mouthLowerDown_L"), shape("mouthLowerDown_R")},
    {shape("mouthUpperUp_L"), shape("mouthUpperUp_R")},
    {shape("mouthPress_L"), shape("mouthPress_R")},
    {shape("mouthRollLower"), shape("mouthRollLower")},
    {shape("mouthRollUpper"), shape("mouthRollUpper")},
    {shape("mouthShrugLower"), shape("mouthShrugLower")},
}};

/// Articulatory target of one sound, and its dominance for jaw and lips (Cohen and Massaro 1993).
struct Articulation {
  std::array<float, kGestureCount> target{};
  float jaw_dominance = 0.5F;
  float lip_dominance = 0.5F;
  float closure = 0;  ///< 1: the lips meet.
  bool vowel = false;
};

/// Openness, rounding and spreading, 0 to 1, of the IPA's vowels.
struct Vowel {
  char32_t letter;
  float open;
  float round;
  float spread;
};
constexpr Vowel kVowels[] = {
    {U'a', 0.90F, 0, 0.20F},     {U'æ', 0.85F, 0, 0.35F},     {U'ɑ', 0.90F, 0, 0},
    {U'ɐ', 0.65F, 0, 0.10F},     {U'ʌ', 0.65F, 0, 0.05F},     {U'ɒ', 0.80F, 0.40F, 0},
    {U'ɛ', 0.55F, 0, 0.30F},     {U'e', 0.40F, 0, 0.40F},     {U'ə', 0.30F, 0.05F, 0},
    {U'ɜ', 0.40F, 0.10F, 0},     {U'ɪ', 0.25F, 0, 0.40F},     {U'i', 0.12F, 0, 0.65F},
    {U'ɨ', 0.15F, 0, 0.30F},     {U'ᵻ', 0.20F, 0, 0.30F},     {U'ʉ', 0.15F, 0.60F, 0},
    {U'y', 0.15F, 0.85F, 0.05F}, {U'ʏ', 0.25F, 0.70F, 0.05F}, {U'ø', 0.35F, 0.75F, 0},
    {U'œ', 0.50F, 0.60F, 0},     {U'ɶ', 0.80F, 0.40F, 0},     {U'ɔ', 0.60F, 0.60F, 0},
    {U'o', 0.40F, 0.80F, 0},     {U'ɤ', 0.40F, 0.05F, 0.05F}, {U'ʊ', 0.25F, 0.60F, 0},
    {U'u', 0.15F, 0.95F, 0},     {U'ɯ', 0.15F, 0.25F, 0.05F}, {U'ɚ', 0.35F, 0.25F, 0},
    {U'ɝ', 0.40F, 0.25F, 0},     {U'ɘ', 0.35F, 0, 0.10F},     {U'ɵ', 0.35F, 0.50F, 0}};

Articulation articulate_vowel(const Vowel& vowel) {
  Articulation a;
  a.vowel = true;
  a.target[jaw] = 0.05F + 0.42F * vowel.open;
  a.target[funnel] = vowel.round * (0.2F + 0.5F * vowel.open);
  a.target[pucker] = vowel.round * (0.75F - 0.35F * vowel.open);
  a.target[stretch] = 0.30F * vowel.spread;
  a.target[smile] = 0.18F * vowel.spread;
  a.target[dimple] = 0.12F * vowel.spread;
  a.target[lower_down] = (0.10F + 0.25F * vowel.open + 0.10F * vowel.spread) * (1 - 0.5F * vowel.round);
  a.target[upper_up] = (0.04F + 0.10F * vowel.open) * (1 - 0.5F * vowel.round);
  a.jaw_dominance = 0.7F + 0.3F * vowel.open;
  // Rounding insists and reaches over neighbours; what is neither round nor spread takes what comes.
  a.lip_dominance = 0.35F + 0.65F * std::max(vowel.round, 0.6F * vowel.spread);
  return a;
}

struct Ask {
  Gesture gesture;
  float amount;
};

/// Consonants that look alike; other targets are 0.
struct Consonants {
  std::u32string_view letters;
  float jaw_dominance, lip_dominance;
  std::vector<Ask> asks;
  float closure = 0;
};

const std::vector<Consonants>& consonants() {
  static const std::vector<Consonants> all = {
      {U"pbmʙ", 0.8F, 1, {{jaw, 0.07F}, {press, 0.35F}, {roll_lower, 0.15F}, {roll_upper, 0.10F}}, 1},
      {U"ɸβ", 0.6F, 0.7F, {{jaw, 0.07F}, {press, 0.1F}, {funnel, 0.1F}}, 0.5F},
      {U"fvʋɱⱱ", 0.8F, 1, {{jaw, 0.06F}, {roll_lower, 0.4F}, {upper_up, 0.2F}, {shrug_lower, 0.15F}}},
      {U"θð", 0.6F, 0.4F, {{jaw, 0.11F}, {lower_down, 0.2F}, {tongue, 0.3F}}},
      {U"sz",
       1,
       0.6F,
       {{jaw, 0.04F}, {stretch, 0.2F}, {lower_down, 0.25F}, {upper_up, 0.08F}, {dimple, 0.08F}}},
      {U"ʃʒʂʐɻ",
       1,
       0.9F,
       {{jaw, 0.06F}, {funnel, 0.45F}, {pucker, 0.25F}, {lower_down, 0.2F}, {upper_up, 0.2F}}},
      {U"ɕʑçʝ", 0.9F, 0.5F, {{jaw, 0.05F}, {funnel, 0.15F}, {stretch, 0.15F}, {lower_down, 0.2F}}},
      {U"tdnɾʈɖɳ", 0.6F, 0.25F, {{jaw, 0.09F}, {lower_down, 0.18F}, {upper_up, 0.05F}}},
      {U"lɫɭɬ", 0.5F, 0.25F, {{jaw, 0.14F}, {lower_down, 0.2F}, {tongue, 0.1F}}},
      {U"ɹɽ", 0.5F, 0.7F, {{jaw, 0.12F}, {pucker, 0.3F}, {funnel, 0.25F}}},
      {U"r", 0.5F, 0.3F, {{jaw, 0.12F}, {lower_down, 0.15F}}},
      {U"kɡgŋxɣqχʁcɢɴʀɟ", 0.35F, 0.15F, {{jaw, 0.14F}, {lower_down, 0.12F}}},
      {U"wʍ", 0.7F, 1, {{jaw, 0.08F}, {pucker, 0.85F}, {funnel, 0.3F}}},
      {U"ɥ", 0.7F, 1, {{jaw, 0.07F}, {pucker, 0.75F}, {funnel, 0.2F}}},
      {U"jʎɲ", 0.6F, 0.4F, {{jaw, 0.07F}, {stretch, 0.2F}, {smile, 0.1F}, {lower_down, 0.1F}}},
  };
  return all;
}

/// Nothing for marks and for sounds that leave the mouth as it is.
std::optional<Articulation> articulation_of(char32_t letter) {
  for (const Vowel& vowel : kVowels)
    if (vowel.letter == letter) return articulate_vowel(vowel);
  for (const Consonants& alike : consonants()) {
    if (!alike.letters.contains(letter)) continue;
    Articulation a;
    for (const Ask& ask : alike.asks) a.target[ask.gesture] = ask.amount;
    a.jaw_dominance = alike.jaw_dominance;
    a.lip_dominance = alike.lip_dominance;
    a.closure = alike.closure;
    return a;
  }
  return std::nullopt;
}

/// Letters of a UTF-8 text; broken bytes are skipped.
std::u32string letters_of(std::string_view utf8) {
  std::u32string letters;
  for (std::size_t i = 0; i < utf8.size();) {
    const auto lead = static_cast<unsigned char>(utf8[i]);
    const std::size_t length = lead < 0x80 ? 1 : lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : lead >= 0xC0 ? 2 : 0;
    if (length == 0 || i + length > utf8.size()) {
      ++i;
      continue;
    }
    char32_t letter = length == 1 ? lead : lead & (0x7FU >> length);
    for (std::size_t j = 1; j < length; ++j)
      letter = (letter << 6U) | (static_cast<unsigned char>(utf8[i + j]) & 0x3FU);
    letters.push_back(letter);
    i += length;
  }
  return letters;
}

/// One sound in time.
struct Sound {
  Articulation articulation;
  double start_s;
  double end_s;
  bool stressed;
};

/// Splits phonemes into single sounds: of a diphthong the first vowel takes 60 %, other letters share evenly.
std::vector<Sound> sounds_of(const Utterance& utterance) {
  std::vector<Sound> sounds;
  for (const auto& phoneme : utterance.phonemes) {
    bool stressed = false;
    std::vector<Articulation> parts;
    for (const char32_t letter : letters_of(phoneme.ipa)) {
      if (letter == U'ˈ') stressed = true;
      if (parts.size() == kMostParts) break;
      if (const auto articulation = articulation_of(letter)) parts.push_back(*articulation);
    }
    const bool diphthong = parts.size() == 2 && parts[0].vowel && parts[1].vowel;
    double start_s = phoneme.start_s;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const double share = diphthong ? (i == 0 ? 0.6 : 0.4) : 1.0 / static_cast<double>(parts.size());
      const double end_s = start_s + share * (phoneme.end_s - phoneme.start_s);
      sounds.push_back({parts[i], start_s, end_s, stressed && parts[i].vowel});
      start_s = end_s;
    }
  }
  return sounds;
}

/// Dominance-weighted targets, summed over sounds (Cohen and Massaro 1993, "Modeling coarticulation in
/// synthetic visual speech"); with a bell in place of their cusp, so that velocities are continuous.
class Mouth {
 public:
  explicit Mouth(std::size_t frame_count)
      : jaw_weight_(frame_count, kRest), lip_weight_(frame_count, kRest), sum_(frame_count) {}

  void add(const Sound& sound, double strength) {
    constexpr double kJawReach_s = 0.045;
    constexpr double kLipReach_s = 0.070;
    const double centre_s = 0.5 * (sound.start_s + sound.end_s);
    const double core_s = 0.3 * (sound.end_s - sound.start_s);
    const double reach_s = core_s + 3.2 * kLipReach_s;
    const auto count = static_cast<double>(sum_.size());
    const auto begin =
        static_cast<std::size_t>(std::clamp(std::ceil((centre_s - reach_s) * kFrameRateHz), 0.0, count));
    const auto end =
        static_cast<std::size_t>(std::clamp(std::ceil((centre_s + reach_s) * kFrameRateHz), 0.0, count));
    const auto& target = sound.articulation.target;
    for (std::size_t i = begin; i < end; ++i) {
      const double away_s =
          std::max(0.0, std::abs(static_cast<double>(i) / kFrameRateHz - centre_s) - core_s);
      const auto bell = [&](double width_s) {
        return std::exp(-0.5 * (away_s / width_s) * (away_s / width_s));
      };
      const auto jaw_share = static_cast<float>(sound.articulation.jaw_dominance * bell(kJawReach_s));
      const auto lip_share = static_cast<float>(sound.articulation.lip_dominance * bell(kLipReach_s));
      jaw_weight_[i] += jaw_share;
      lip_weight_[i] += lip_share;
      sum_[i][jaw] += jaw_share * static_cast<float>(strength) * target[jaw];
      for (std::size_t g = funnel; g < kGestureCount; ++g) sum_[i][g] += lip_share * target[g];
    }
  }

  void write(Canvas& canvas, const Manner& manner, const Style& style) const {
    const auto opening = static_cast<float>(manner.loudness);
    const auto lips = static_cast<float>(manner.articulation);
    // Few people speak with both halves of the mouth alike.
    const auto lean = static_cast<float>(0.12 * Random(style.taste).fork("lean").normal());
    for (std::size_t i = 0; i < sum_.size(); ++i) {
      canvas.weights[i][shape("jawOpen")] += opening * sum_[i][jaw] / jaw_weight_[i];
      for (std::size_t g = funnel; g < tongue; ++g) {
        const float now = lips * sum_[i][g] / lip_weight_[i];
        const GestureShapes& shapes = kGestureShapes[g];
        canvas.weights[i][shapes.left] += shapes.left == shapes.right ? now : now * (1 + lean);
        if (shapes.left != shapes.right) canvas.weights[i][shapes.right] += now * (1 - lean);
      }
      canvas.tongue_out[i] += 0.5F * sum_[i][tongue] / lip_weight_[i];
    }
  }

 private:
  static constexpr float kRest = 0.05F;  // The pull of rest: closes the mouth in pauses.
  std::vector<float> jaw_weight_;
  std::vector<float> lip_weight_;
  std::vector<std::array<float, kGestureCount>> sum_;
};

/// Lips meet for every bilabial, for two frames at least, however short it is.
void close_lips(Canvas& canvas, const Sound& sound) {
  const double length_s = sound.end_s - sound.start_s;
  const double hold_s = std::max(0.040, 0.6 * length_s);
  const double centre_s = sound.start_s + 0.45 * length_s;
  const Envelope envelope{centre_s - 0.5 * hold_s - 0.055, 0.055, hold_s, 0.065};
  const double first = std::max(0.0, std::ceil(envelope.begin_s * kFrameRateHz));
  for (auto i = static_cast<std::size_t>(first); i < canvas.frame_count(); ++i) {
    const double t = static_cast<double>(i) / kFrameRateHz;
    if (t > envelope.end_s()) break;
    const auto now = static_cast<float>(sound.articulation.closure * envelope.at(t));
    canvas.lip_closure[i] = std::max(canvas.lip_closure[i], now);
  }
}

/// Accents of brows and head on stressed vowels; a raised brow where a phrase ends as a question.
void add_prosody(Canvas& canvas, const std::vector<Sound>& sounds, const Manner& manner, Random random) {
  static const Pose brows = pose_of({{"browInnerUp", 1}, {"browOuterUp", 0.8F}});
  static const Pose frown = pose_of({{"browDown", 1}});
  double free_s = 0;
  for (std::size_t s = 0; s < sounds.size(); ++s) {
    const Sound& sound = sounds[s];
    const bool last = s + 1 == sounds.size() || sounds[s + 1].start_s > sound.end_s + 0.15;
    if (sound.articulation.vowel && sound.start_s > free_s &&
        (sound.stressed ? random.chance(0.35) : random.chance(0.05))) {
      const double rise_s = random.uniform(0.12, 0.25);
      const Envelope envelope{sound.start_s - 0.6 * rise_s, rise_s, random.uniform(0, 0.2),
                              random.uniform(0.2, 0.5)};
      const double which = random.uniform();
      if (which < 0.45) canvas.add(brows, envelope, manner.prosody * random.uniform(0.06, 0.35));
      if (which > 0.85) canvas.add(frown, envelope, manner.prosody * random.uniform(0.05, 0.25));
      if (random.chance(0.6)) {
        const Vec3 gesture = manner.prosody * kRadPerDeg *
                             Vec3{random.uniform(1, 4.5), 1.2 * random.normal(), 0.8 * random.normal()};
        const auto first =
            static_cast<std::size_t>(std::max(0.0, std::ceil(envelope.begin_s * kFrameRateHz)));
        for (std::size_t i = first; i < canvas.frame_count(); ++i) {
          const double t = static_cast<double>(i) / kFrameRateHz;
          if (t > envelope.end_s()) break;
          canvas.head_rad[i] += envelope.at(t) * gesture;
        }
      }
      free_s = sound.start_s + random.uniform(0.25, 0.9);
    }
    if (last && random.chance(0.2))
      canvas.add(brows, {sound.start_s - 0.3, 0.35, 0.2, 0.5}, manner.prosody * random.uniform(0.1, 0.4));
  }
}

}  // namespace

void perform_speech(Canvas& canvas, const Utterance& utterance, const Manner& manner, const Style& style,
                    Random random) {
  const std::vector<Sound> sounds = sounds_of(utterance);
  Mouth mouth(canvas.frame_count());
  double phrase = 1;
  for (std::size_t s = 0; s < sounds.size(); ++s) {
    const Sound& sound = sounds[s];
    const double silence_s = s == 0 ? sound.start_s : sound.start_s - sounds[s - 1].end_s;
    if (silence_s > 0.15) {
      const double pause_s = sound.start_s - silence_s;
      canvas.pauses_s.push_back(pause_s + 0.05);
      phrase = std::clamp(random.log_normal(0.15), 0.7, 1.4);
      // In a long pause one breathes in.
      if (silence_s > 0.4 && random.chance(0.6))
        canvas.add(shape("jawOpen"), {sound.start_s - 0.35, 0.2, 0.02, 0.15}, random.uniform(0.03, 0.12));
    }
    const double stress = sound.stressed ? 1.15 : 1.0;
    mouth.add(sound, phrase * stress * std::clamp(random.log_normal(0.12), 0.7, 1.4));
    if (sound.articulation.closure > 0) close_lips(canvas, sound);
  }
  mouth.write(canvas, manner, style);
  add_prosody(canvas, sounds, manner, random.fork("prosody"));
}

}  // namespace mien::performer
