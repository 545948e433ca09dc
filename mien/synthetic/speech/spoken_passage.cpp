#include "mien/synthetic/speech/spoken_passage.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mien/performer/lines.h"
#include "mien/performer/performer.h"
#include "mien/performer/script.h"
#include "mien/performer/style.h"
#include "mien/speech/block_maker.h"

namespace mien::synthetic {
namespace {

std::size_t at_rate(double seconds) {
  return static_cast<std::size_t>(std::llround(seconds * speech::kRateHz));
}

}  // namespace

Result<std::vector<float>> resampled(const Sound& sound) {
  MIEN_TRY_ASSIGN(auto maker, speech::BlockMaker::create(static_cast<int>(sound.rate_hz)));
  std::vector<float> out;
  const speech::BlockMaker::Take take = [&](const speech::Block& block) {
    for (const std::int16_t s : block) out.push_back(static_cast<float>(s) / speech::kFullScale);
  };
  maker.push(sound.samples, take);
  maker.finish(take);
  out.resize(static_cast<std::size_t>(std::llround(sound.duration_s() * speech::kRateHz)));
  return out;
}

std::vector<Closure> closures_of(const performer::Utterance& utterance) {
  constexpr double kShortest_s = 0.040, kShare = 0.6, kMiddle = 0.45, kApart_s = 0.03;
  std::vector<Closure> closures;
  for (const auto& phoneme : utterance.phonemes) {
    if (phoneme.ipa.find_first_of("pbm") == std::string::npos) continue;
    const double length_s = phoneme.end_s - phoneme.start_s;
    const double middle_s = phoneme.start_s + kMiddle * length_s;
    const double half_s = 0.5 * std::max(kShortest_s, kShare * length_s);
    // A double sound is one closure.
    if (!closures.empty() && middle_s - half_s <= closures.back().end_s + kApart_s)
      closures.back().end_s = middle_s + half_s;
    else
      closures.push_back({middle_s - half_s, middle_s + half_s});
  }
  return closures;
}

bool SpokenPassage::voiced_at(double time_s) const {
  return std::ranges::any_of(utterance.phonemes, [&](const performer::Utterance::Phoneme& phoneme) {
    return !phoneme.ipa.empty() && time_s >= phoneme.start_s && time_s < phoneme.end_s;
  });
}

Result<SpokenPassage> speak_passage(const performer::Speaker& speaker, const std::string& voice,
                                    std::size_t language, const Random& random, double at_least_s) {
  constexpr int kLines = 3;
  Random drawn = random.fork("passage");
  const std::span<const std::string_view> lines = language < performer::kNoLanguage
                                                      ? performer::reading_languages()[language].lines
                                                      : std::span<const std::string_view>();
  SpokenPassage passage;
  double at_s = drawn.uniform(0.3, 1);
  for (int l = 0; l < kLines || at_s < at_least_s; ++l) {
    const std::string text = drawn.chance(0.5) || lines.empty()
                                 ? performer::invented_line(language, drawn)
                                 : std::string(lines[drawn.below(lines.size())]);
    const int words_per_minute = static_cast<int>(110 + drawn.below(120));
    MIEN_TRY_ASSIGN(const performer::SpokenLine line, speaker(voice, text, words_per_minute));
    MIEN_TRY_ASSIGN(const std::vector<float> sound, resampled(line.sound));
    passage.sound.resize(at_rate(at_s));
    passage.sound.insert(passage.sound.end(), sound.begin(), sound.end());
    for (performer::Utterance::Phoneme phoneme : line.utterance.phonemes) {
      phoneme.start_s += at_s;
      phoneme.end_s += at_s;
      passage.utterance.phonemes.push_back(std::move(phoneme));
    }
    passage.utterance.language = line.utterance.language;
    at_s += line.sound.duration_s() + drawn.uniform(0.3, 1);
  }
  passage.sound.resize(at_rate(at_s));
  passage.utterance.duration_s = at_s;
  passage.closures = closures_of(passage.utterance);
  performer::Script script;
  script.moves_head = false;
  script.segments = {
      {.block = performer::Block::reading, .duration_s = at_s, .utterance = passage.utterance}};
  Random style = random.fork("style");
  passage.face = performer::perform(script, performer::draw_style(style), random.fork("motion"));
  return passage;
}

std::vector<speech::Block> blocks_of(std::span<const float> sound) {
  std::vector<speech::Block> blocks((sound.size() + speech::kBlockSamples - 1) / speech::kBlockSamples);
  for (std::size_t i = 0; i < sound.size(); ++i)
    blocks[i / speech::kBlockSamples][i % speech::kBlockSamples] = static_cast<std::int16_t>(
        std::lround(std::clamp(speech::kFullScale * sound[i], -32768.0F, 32767.0F)));
  return blocks;
}

}  // namespace mien::synthetic
