#include "app/read_aloud.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "app/media_helper.h"
#include "mien/performer/lines.h"

namespace mien::app {
namespace {

/// Between two lines.
constexpr double kPauseS = 0.4;

/// Has each line said once.
class Reader {
 public:
  Result<const performer::SpokenLine*> say(const std::string& voice, const std::string& text,
                                           int words_per_minute) {
    const auto key = std::tuple(voice, text, words_per_minute);
    if (const auto found = said_.find(key); found != said_.end()) return &found->second;
    auto line = speaker_(voice, text, words_per_minute);
    if (!line) {
      Error error = line.error();
      if (error.code == ErrorCode::not_found) error.fix += ", or take --voice babble";
      return std::unexpected(std::move(error));
    }
    return &said_.emplace(key, *std::move(line)).first->second;
  }

 private:
  performer::Speaker speaker_ = speaker_by_helper();
  std::map<std::tuple<std::string, std::string, int>, performer::SpokenLine> said_;
};

/// Appends what is said at `at_s` of the segment.
void append(const performer::Utterance& line, double at_s, performer::Utterance& all) {
  for (performer::Utterance::Phoneme phoneme : line.phonemes) {
    phoneme.start_s += at_s;
    phoneme.end_s += at_s;
    all.phonemes.push_back(std::move(phoneme));
  }
  all.text += (all.text.empty() ? "" : " ") + line.text;
  all.duration_s = at_s + line.duration_s;
}

}  // namespace

void mix(const Sound& line, double at_s, double end_s, Sound& all) {
  if (all.rate_hz == 0) all.rate_hz = line.rate_hz;
  const auto begin = static_cast<std::size_t>(std::llround(at_s * all.rate_hz));
  const auto end = static_cast<std::size_t>(std::llround(end_s * all.rate_hz));
  if (begin >= end) return;
  const std::size_t count = std::min(line.samples.size(), end - begin);
  all.samples.resize(std::max(all.samples.size(), begin + count));
  std::copy_n(line.samples.begin(), count, all.samples.begin() + static_cast<std::ptrdiff_t>(begin));
}

Result<Sound> read_aloud(std::span<performer::Script> scripts, const Progress& progress) {
  // espeak-ng's own pace for calm reading; acted lines are quicker.
  constexpr int kCalm = 140, kActed = 170;
  const auto languages = performer::reading_languages();
  Reader reader;
  Sound mixed;
  double begin_s = 0, whole_s = 0;
  std::vector<performer::Segment*> segments;
  for (performer::Script& script : scripts)
    for (performer::Segment& segment : script.segments) {
      segments.push_back(&segment);
      whole_s += segment.duration_s;
    }
  std::size_t spoken = 0;
  for (performer::Segment* const each : segments) {
    performer::Segment& segment = *each;
    const double segment_s = segment.duration_s;
    const double from_s = begin_s;
    begin_s += segment_s;
    if (segment.block != performer::Block::reading && segment.block != performer::Block::acted) continue;
    const performer::ReadingLanguage& language = languages[spoken % languages.size()];
    performer::Utterance all;
    double at_s = 0;
    for (std::size_t line = spoken++; at_s < segment_s; ++line) {
      if (!progress((from_s + at_s) / whole_s, language.voice))
        return fail(ErrorCode::cancelled, "stopped while reading aloud");
      MIEN_TRY_ASSIGN(
          const performer::SpokenLine* said,
          reader.say(std::string(language.voice), std::string(language.lines[line % language.lines.size()]),
                     segment.block == performer::Block::acted ? kActed : kCalm));
      all.language = segment.language = said->utterance.language;
      append(said->utterance, at_s, all);
      // Hours of sound are not held twice while they grow.
      mixed.samples.reserve(static_cast<std::size_t>(std::ceil(whole_s * said->sound.rate_hz)));
      mix(said->sound, from_s + at_s, from_s + segment_s, mixed);
      at_s += std::max(said->utterance.duration_s, said->sound.duration_s()) + kPauseS;
    }
    segment.utterance = std::move(all);
  }
  if (mixed.rate_hz == 0)
    return fail(ErrorCode::bad_usage, "nothing in this script is said aloud",
                scripts.empty() ? "" : scripts.front().name,
                "take --script reading, acted or mixed, or --voice babble");
  progress(1, "read");
  return mixed;
}

}  // namespace mien::app
