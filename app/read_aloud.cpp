#include "app/read_aloud.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <tuple>
#include <utility>

#include "app/media_helper.h"

namespace mien::app {
namespace {

/// What is read in one language; every sound of the language comes up, and some lines are hard to say.
struct Reader {
  const char* voice;  // As espeak-ng names it.
  std::array<const char*, 6> lines;
};

constexpr std::array<Reader, 4> kReaders = {{
    {"en-us",
     {"The morning fog lay over the harbour, and nobody had thought of the boats.",
      "Five brave foxes puff up their fur before they jump the muddy brook.",
      "Would you whistle that tune again, a little more slowly this time?",
      "She sells fresh fish, thick cheese and good brown bread by the bridge.",
      "My mother put a purple plum beside the broken window, who knows why.",
      "Joy is what we measure, though hardly anyone would choose to call it that."}},
    {"de",
     {"Am frühen Morgen zog der Nebel über die Brücke und den Hafen.",
      "Fünf flinke Füchse springen über den trüben Bach.",
      "Könntest du dieses Lied noch einmal pfeifen, bitte ein wenig langsamer?",
      "Die Frau verkauft frischen Fisch, dunkles Brot und süße Pflaumen.",
      "Meine Mutter backt am Wochenende gern Apfelkuchen mit Zimt.",
      "Ob wir nun lachen oder weinen, das Gesicht erzählt es allen."}},
    {"es",
     {"La niebla cubría el puerto y nadie se acordaba de los barcos.",
      "Cinco zorros valientes saltan por encima del arroyo.",
      "¿Podrías silbar esa canción otra vez, un poco más despacio?",
      "Mi madre compra pan fresco, queso y ciruelas en la plaza.",
      "Ayer llovió mucho, pero hoy el viento empuja las nubes.",
      "El rostro cuenta en silencio lo que la boca no quiere decir."}},
    {"fr-fr",
     {"Le brouillard couvrait le port et personne ne pensait aux bateaux.",
      "Cinq renards courageux sautent par-dessus le ruisseau.",
      "Pourrais-tu siffler cette chanson encore une fois, un peu plus lentement ?",
      "Ma mère achète du pain frais, du beurre et des prunes bleues.",
      "Hier il a plu, mais aujourd'hui le vent pousse les nuages.",
      "Le visage raconte tout bas ce que la bouche ne veut pas dire."}},
}};

/// Between two lines.
constexpr double kPauseS = 0.4;

/// Has espeak-ng say each line once.
class Speaker {
 public:
  struct Line {
    performer::Utterance utterance;
    Sound sound;
  };

  Result<const Line*> say(const std::string& voice, const std::string& text, int words_per_minute) {
    const auto key = std::tuple(voice, text, words_per_minute);
    if (const auto found = said_.find(key); found != said_.end()) return &found->second;
    auto speech = speak_with_helper(voice, text, words_per_minute);
    if (!speech) {
      Error error = speech.error();
      if (error.code == ErrorCode::not_found) error.fix += ", or take --voice babble";
      return std::unexpected(std::move(error));
    }
    Line line;
    MIEN_TRY_ASSIGN(line.utterance, performer::parse_utterance(speech->json));
    line.sound = std::move(speech->sound);
    return &said_.emplace(key, std::move(line)).first->second;
  }

 private:
  std::map<std::tuple<std::string, std::string, int>, Line> said_;
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

/// Sets the sound at its place, cut where the segment ends.
void mix(const Sound& line, double at_s, double end_s, Sound& all) {
  if (all.rate_hz == 0) all.rate_hz = line.rate_hz;
  const auto begin = static_cast<std::size_t>(std::llround(at_s * all.rate_hz));
  const auto end = static_cast<std::size_t>(std::llround(end_s * all.rate_hz));
  if (begin >= end) return;
  const std::size_t count = std::min(line.samples.size(), end - begin);
  all.samples.resize(std::max(all.samples.size(), begin + count));
  std::copy_n(line.samples.begin(), count, all.samples.begin() + static_cast<std::ptrdiff_t>(begin));
}

}  // namespace

Result<Sound> read_aloud(performer::Script& script, const Progress& progress) {
  // espeak-ng's own pace for calm reading; acted lines are quicker.
  constexpr int kCalm = 140, kActed = 170;
  Speaker speaker;
  Sound mixed;
  double begin_s = 0;
  std::size_t spoken = 0;
  for (performer::Segment& segment : script.segments) {
    const double segment_s = segment.duration_s;
    const double from_s = begin_s;
    begin_s += segment_s;
    if (segment.block != performer::Block::reading && segment.block != performer::Block::acted) continue;
    const Reader& reader = kReaders[spoken % kReaders.size()];
    performer::Utterance all;
    double at_s = 0;
    for (std::size_t line = spoken++; at_s < segment_s; ++line) {
      if (!progress((from_s + at_s) / script.duration_s(), reader.voice))
        return fail(ErrorCode::cancelled, "stopped while reading aloud");
      MIEN_TRY_ASSIGN(const Speaker::Line* said,
                      speaker.say(reader.voice, reader.lines[line % reader.lines.size()],
                                  segment.block == performer::Block::acted ? kActed : kCalm));
      all.language = segment.language = said->utterance.language;
      append(said->utterance, at_s, all);
      mix(said->sound, from_s + at_s, from_s + segment_s, mixed);
      at_s += std::max(said->utterance.duration_s, said->sound.duration_s()) + kPauseS;
    }
    segment.utterance = std::move(all);
  }
  if (mixed.rate_hz == 0)
    return fail(ErrorCode::bad_usage, "nothing in this script is said aloud", script.name,
                "take --script reading, acted or mixed, or --voice babble");
  progress(1, "read");
  return mixed;
}

}  // namespace mien::app
