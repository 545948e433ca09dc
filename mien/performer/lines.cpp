#include "mien/performer/lines.h"

#include <array>

namespace mien::performer {
namespace {

using Lines = std::array<std::string_view, 6>;

constexpr Lines kEnglish = {"The morning fog lay over the harbour, and nobody had thought of the boats.",
                            "Five brave foxes puff up their fur before they jump the muddy brook.",
                            "Would you whistle that tune again, a little more slowly this time?",
                            "She sells fresh fish, thick cheese and good brown bread by the bridge.",
                            "My mother put a purple plum beside the broken window, who knows why.",
                            "Joy is what we measure, though hardly anyone would choose to call it that."};
constexpr Lines kGerman = {"Am frühen Morgen zog der Nebel über die Brücke und den Hafen.",
                           "Fünf flinke Füchse springen über den trüben Bach.",
                           "Könntest du dieses Lied noch einmal pfeifen, bitte ein wenig langsamer?",
                           "Die Frau verkauft frischen Fisch, dunkles Brot und süße Pflaumen.",
                           "Meine Mutter backt am Wochenende gern Apfelkuchen mit Zimt.",
                           "Ob wir nun lachen oder weinen, das Gesicht erzählt es allen."};
constexpr Lines kSpanish = {"La niebla cubría el puerto y nadie se acordaba de los barcos.",
                            "Cinco zorros valientes saltan por encima del arroyo.",
                            "¿Podrías silbar esa canción otra vez, un poco más despacio?",
                            "Mi madre compra pan fresco, queso y ciruelas en la plaza.",
                            "Ayer llovió mucho, pero hoy el viento empuja las nubes.",
                            "El rostro cuenta en silencio lo que la boca no quiere decir."};
constexpr Lines kFrench = {"Le brouillard couvrait le port et personne ne pensait aux bateaux.",
                           "Cinq renards courageux sautent par-dessus le ruisseau.",
                           "Pourrais-tu siffler cette chanson encore une fois, un peu plus lentement ?",
                           "Ma mère achète du pain frais, du beurre et des prunes bleues.",
                           "Hier il a plu, mais aujourd'hui le vent pousse les nuages.",
                           "Le visage raconte tout bas ce que la bouche ne veut pas dire."};
constexpr std::array kLanguages = {ReadingLanguage{"en-us", kEnglish}, ReadingLanguage{"de", kGerman},
                                   ReadingLanguage{"es", kSpanish}, ReadingLanguage{"fr-fr", kFrench}};

/// What syllables are spelt of, words apart by spaces; "-" is nothing.
struct Spelling {
  std::string_view onsets, nuclei, codas;
};
constexpr std::array<Spelling, kNoLanguage + 1> kSpellings = {{
    {"p b m p b m t d n k g f v s sh ch j th l r w h y st sp sm pl bl br pr tr dr kl gr fr fl sl sw kw sk - "
     "-",
     "a e i o u ee oo ai ow oy er ar or ea oa i a e",
     "- - - p b m t d n k g f v s z sh th l ng nd mp st ks lt"},
    {"p b m p b m t d n k g f w s sch l r h j z pf st sp bl br pl pr tr dr kl gr fr fl schl schm kn zw - -",
     "a e i o u ä ö ü ei au eu ie a e i ah eh oh", "- - - p b m t d n k g f s ch sch l r ng nt mp st ft lt"},
    {"p b m p b m t d n c g f v s ch j l ll r rr y ñ pl pr br bl tr dr cl gr fr fl - -",
     "a e i o u a e o ia ie ue ua ai ei", "- - - - - n s r l m d"},
    {"p b m p b m t d n c g f v s ch j l r pl pr br bl tr dr cl gr fr fl - -",
     "a e i o u ou eu an on in ai oi eau é è ui a é",
     "- - - - be pe me te de ne que gue fe ve se che ge le re"},
    {"p b m p b m p b m t d n k f v s z l r j sp st pl bl br pr tr dr kr kl fr fl sm sn - -",
     "a e i o u a e o ia ie ai au oi", "- - - - - n s r l m t k p"},
}};

std::string_view word_of(std::string_view list, Random& random) {
  std::size_t count = 1;
  for (const char letter : list) count += letter == ' ' ? 1 : 0;
  std::size_t left = random.below(count);
  std::size_t begin = 0;
  for (; left > 0; --left) begin = list.find(' ', begin) + 1;
  const std::string_view word = list.substr(begin, list.find(' ', begin) - begin);
  return word == "-" ? std::string_view() : word;
}

}  // namespace

std::span<const ReadingLanguage> reading_languages() {
  return kLanguages;
}

std::string invented_line(std::size_t language, Random& random) {
  constexpr double kComma = 0.12, kQuestion = 0.2;
  const Spelling& spelling = kSpellings[language];
  std::string line;
  const std::uint64_t words = 4 + random.below(6);
  for (std::uint64_t w = 0; w < words; ++w) {
    if (w > 0) line += random.chance(kComma) ? ", " : " ";
    const std::uint64_t syllables = 1 + random.below(3);
    for (std::uint64_t s = 0; s < syllables; ++s) {
      line += word_of(spelling.onsets, random);
      line += word_of(spelling.nuclei, random);
    }
    line += word_of(spelling.codas, random);
  }
  // Festival's Italian voices stumble over questions.
  line += language != kNoLanguage && random.chance(kQuestion) ? "?" : ".";
  return line;
}

}  // namespace mien::performer
