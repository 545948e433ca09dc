#include "mien/media/festival_speech.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "mien/media/phone_names.h"

namespace mien::media {
namespace {

struct FestivalVoice {
  std::string_view name;
  PhoneSet phones;
};
constexpr std::array kFestivalVoices = {
    FestivalVoice{"czech_dita", PhoneSet::continental},
    FestivalVoice{"czech_krb", PhoneSet::continental},
    FestivalVoice{"czech_machac", PhoneSet::continental},
    FestivalVoice{"czech_ph", PhoneSet::continental},
    FestivalVoice{"hy_fi_mv_diphone", PhoneSet::continental},
    FestivalVoice{"ked_diphone", PhoneSet::english},
    FestivalVoice{"lp_diphone", PhoneSet::continental},
    FestivalVoice{"msu_ru_nsh_clunits", PhoneSet::russian},
    FestivalVoice{"pc_diphone", PhoneSet::continental},
    FestivalVoice{"suo_fi_lj_diphone", PhoneSet::continental},
};
/// Begins each line that tells of a phone.
constexpr std::string_view kMark = "mien-phone ";

Result<FestivalVoice> find_voice(const std::string& name) {
  const auto found = std::ranges::find(kFestivalVoices, name, &FestivalVoice::name);
  if (found != kFestivalVoices.end()) return *found;
  std::string names;
  for (const FestivalVoice& voice : kFestivalVoices)
    names += (names.empty() ? "" : ", ") + std::string(voice.name);
  return fail(ErrorCode::bad_usage, "no such voice of festival", name, "use " + names);
}

std::string in_quotes(std::string_view text) {
  std::string quoted = "\"";
  for (const char letter : text) {
    if (letter == '"' || letter == '\\') quoted += '\\';
    quoted += letter;
  }
  return quoted + '"';
}

}  // namespace

Result<std::string> festival_script(const std::string& voice, const std::string& text, int words_per_minute,
                                    const std::filesystem::path& wav) {
  MIEN_TRY(find_voice(voice));
  MIEN_TRY(check_rate(words_per_minute, voice));
  const auto is_plain = [](char letter) { return letter >= ' ' && letter <= '~'; };
  if (text.empty() || !std::ranges::all_of(text, is_plain))
    return fail(ErrorCode::bad_usage, "festival's voices read ASCII, and there is none or other letters",
                voice, "write it in plain letters");
  constexpr double kOwnPace = 175;
  return fmt::format(
      "(voice_{0})\n"
      "(Parameter.set 'Duration_Stretch {1:.4f})\n"
      "(set! said (utt.synth (Utterance Text {2})))\n"
      "(utt.save.wave said {3} 'riff)\n"
      "(mapcar (lambda (phone) (format t \"\\n{4}%s %s\\n\" (item.feat phone 'end) (item.name phone)))\n"
      "        (utt.relation.items said 'Segment))\n",
      voice, kOwnPace / words_per_minute, in_quotes(text), in_quotes(wav.string()), kMark);
}

Result<std::vector<SpokenSpan>> parse_festival_phones(std::string_view printed, const std::string& voice) {
  MIEN_TRY_ASSIGN(const FestivalVoice speaker, find_voice(voice));
  std::vector<SpokenSpan> phones;
  double begin_s = 0;
  while (!printed.empty()) {
    const std::size_t length = std::min(printed.find('\n'), printed.size());
    std::string_view line = printed.substr(0, length);
    printed.remove_prefix(std::min(length + 1, printed.size()));
    if (!line.starts_with(kMark)) continue;
    line.remove_prefix(kMark.size());
    double end_s = 0;
    const auto [rest, error] = std::from_chars(line.data(), line.data() + line.size(), end_s);
    line.remove_prefix(static_cast<std::size_t>(rest - line.data()));
    if (error != std::errc() || !line.starts_with(' ') || !std::isfinite(end_s) || end_s < begin_s)
      return fail(ErrorCode::malformed, "a phone without its time", "festival's " + voice);
    phones.push_back({ipa_of(speaker.phones, line.substr(1)), begin_s, end_s});
    begin_s = end_s;
  }
  return phones;
}

}  // namespace mien::media
