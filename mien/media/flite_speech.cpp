#include "mien/media/flite_speech.h"

#include <flite/flite.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string_view>

#include "mien/media/phone_names.h"

extern "C" {
// No header of flite declares them.
cst_voice* register_cmu_us_awb(const char* folder);
cst_voice* register_cmu_us_kal16(const char* folder);
cst_voice* register_cmu_us_rms(const char* folder);
cst_voice* register_cmu_us_slt(const char* folder);
}

namespace mien::media {
namespace {

struct Voice {
  std::string_view name;
  cst_voice* (*find)(const char*);
};
constexpr std::array kVoices = {Voice{"awb", register_cmu_us_awb}, Voice{"kal16", register_cmu_us_kal16},
                                Voice{"rms", register_cmu_us_rms}, Voice{"slt", register_cmu_us_slt}};

}  // namespace

Result<SpokenText> speak_by_flite(const std::string& voice, const std::string& text, int words_per_minute) {
  const auto found = std::ranges::find(kVoices, voice, &Voice::name);
  if (found == kVoices.end())
    return fail(ErrorCode::bad_usage, "flite has no such voice", voice, "use awb, kal16, rms or slt");
  flite_init();
  cst_voice* const speaker = found->find(nullptr);
  constexpr float kOwnPace = 175;
  feat_set_float(speaker->features, "duration_stretch", kOwnPace / static_cast<float>(words_per_minute));
  const std::unique_ptr<cst_utterance, decltype(&delete_utterance)> said(
      flite_synth_text(text.c_str(), speaker), &delete_utterance);
  if (!said) return fail(ErrorCode::io, "flite gave up on this text", voice);
  SpokenText spoken;
  const cst_wave* const wave = utt_wave(said.get());
  if (wave == nullptr || wave->num_samples <= 0)
    return fail(ErrorCode::bad_usage, "flite finds nothing to say", voice, "give a text");
  spoken.sound.rate_hz = static_cast<std::uint32_t>(wave->sample_rate);
  spoken.sound.samples.reserve(static_cast<std::size_t>(wave->num_samples));
  for (int i = 0; i < wave->num_samples; ++i)
    spoken.sound.samples.push_back(static_cast<float>(wave->samples[i]) / 32768.0F);
  double begin_s = 0;
  for (cst_item* phone = relation_head(utt_relation(said.get(), "Segment")); phone != nullptr;
       phone = item_next(phone)) {
    const double end_s =
        std::clamp(double{item_feat_float(phone, "end")}, begin_s, spoken.sound.duration_s());
    spoken.phonemes.push_back({ipa_of(PhoneSet::english, item_feat_string(phone, "name")), begin_s, end_s});
    begin_s = end_s;
  }
  return spoken;
}

}  // namespace mien::media
