#include "mien/speech/phone_decoder.h"

#include <err.h>
#include <pocketsphinx.h>

#include <algorithm>
#include <deque>
#include <string>
#include <utility>
#include <vector>

namespace mien::speech {
namespace {

/// An utterance begins with the first block of this level, -48 dB, and ends after a pause of this length, or
/// when it is so long that going through all its phones would take too much of a block's time. Ours, tuned on
/// nothing.
constexpr float kSpeech_rms = 0.004F;
constexpr int kPause_blocks = 20;
constexpr int kLongest_blocks = 600;
/// Blocks before the first one with sound that are decoded too: onsets are quiet.
constexpr std::size_t kRunUp_blocks = 4;
constexpr std::string_view kSilent = "SIL";
/// Phones that are handed on.
constexpr std::size_t kKept = 24;

struct FreeConfig {
  void operator()(cmd_ln_t* config) const { cmd_ln_free_r(config); }
};
struct FreeDecoder {
  void operator()(ps_decoder_t* decoder) const { ps_free(decoder); }
};

}  // namespace

struct PhoneDecoder::State {
  std::unique_ptr<cmd_ln_t, FreeConfig> config;
  std::unique_ptr<ps_decoder_t, FreeDecoder> decoder;
  std::deque<Block> run_up;        // The newest quiet blocks, which nobody decoded.
  std::uint64_t blocks = 0;        // Since the first.
  bool speaking = false;           // An utterance is open, ...
  std::uint64_t utterance = 0;     // ... which began with this block, ...
  int quiet = 0;                   // ... with so many quiet blocks at its end.
  std::vector<HeardPhone> before;  // Of ended utterances.
  std::vector<HeardPhone> heard;

  /// What the decoder refuses is not heard.
  void listen(const Block& block) { ps_process_raw(decoder.get(), block.data(), block.size(), 0, 0); }

  void begin() {
    if (ps_start_utt(decoder.get()) < 0) return;
    speaking = true;
    quiet = 0;
    utterance = blocks - run_up.size();
    for (const Block& block : run_up) listen(block);
    run_up.clear();
  }

  /// What the utterance is taken for so far, after what was said before.
  void read(bool open) {
    heard = before;
    int begun = -1;  // The decoder's count of frames goes on from one utterance to the next.
    for (ps_seg_t* segment = ps_seg_iter(decoder.get()); segment != nullptr; segment = ps_seg_next(segment)) {
      int first = 0, last = 0;
      ps_seg_frames(segment, &first, &last);
      if (begun < 0) begun = first;
      const std::string_view word = ps_seg_word(segment);
      HeardPhone& phone = heard.emplace_back();
      const bool noise = word.empty() || word[0] == '+' || word.size() >= phone.symbol.size();
      std::ranges::copy(noise ? kSilent : word, phone.symbol.begin());
      phone.begin = kFramesPerBlock * utterance + static_cast<std::uint64_t>(std::max(first - begun, 0));
      phone.end = kFramesPerBlock * utterance + static_cast<std::uint64_t>(std::max(last - begun, 0)) + 1;
      phone.open = open;
    }
    if (heard.size() > kKept) heard.erase(heard.begin(), heard.end() - kKept);
  }

  void end() {
    ps_end_utt(decoder.get());
    read(false);
    before = heard;
    speaking = false;
  }
};

PhoneDecoder::PhoneDecoder(std::unique_ptr<State> state) : state_(std::move(state)) {}
PhoneDecoder::PhoneDecoder(PhoneDecoder&&) noexcept = default;
PhoneDecoder& PhoneDecoder::operator=(PhoneDecoder&&) noexcept = default;
PhoneDecoder::~PhoneDecoder() {
  if (!state_) return;
  ps_decoder_t* const decoder = state_->decoder.get();
  if (state_->speaking) ps_end_utt(decoder);
  // The library frees its list of an utterance's phones when it makes the next one, and the last one never:
  // an empty utterance's is none.
  if (ps_start_utt(decoder) < 0) return;
  ps_end_utt(decoder);
  if (ps_seg_t* segment = ps_seg_iter(decoder)) ps_seg_free(segment);
}

Result<void> PhoneDecoder::check(const std::filesystem::path& model) {
  std::error_code error;
  if (std::filesystem::exists(model / "en-us", error) &&
      std::filesystem::exists(model / "en-us-phone.lm.bin", error))
    return {};
  return fail(ErrorCode::not_found, "PocketSphinx's English model is not there", model.string(),
              "install Debian's pocketsphinx-en-us");
}

Result<PhoneDecoder> PhoneDecoder::create(const std::filesystem::path& model) {
  MIEN_TRY(check(model));
  const std::string acoustic = model / "en-us", language = model / "en-us-phone.lm.bin";
  err_set_logfp(nullptr);  // It would write pages.
  auto state = std::make_unique<State>();
  state->config.reset(cmd_ln_init(nullptr, ps_args(), 1, "-hmm", acoustic.c_str(), "-allphone",
                                  language.c_str(), "-allphone_ci", "yes", "-lw", "2.0", "-beam", "1e-20",
                                  "-pbeam", "1e-20", "-remove_silence", "no", "-dither", "no", "-cmn", "live",
                                  nullptr));
  if (state->config) state->decoder.reset(ps_init(state->config.get()));
  if (!state->decoder)
    return fail(ErrorCode::internal, "PocketSphinx does not take its model", model.string());
  return PhoneDecoder(std::move(state));
}

std::span<const HeardPhone> PhoneDecoder::push(const Block& block) {
  State& s = *state_;
  const bool loud = loudness_of(block).rms >= kSpeech_rms;
  if (!s.speaking && loud) s.begin();
  if (s.speaking) {
    s.listen(block);
    s.read(true);
    s.quiet = loud ? 0 : s.quiet + 1;
  } else {
    s.run_up.push_back(block);
    if (s.run_up.size() > kRunUp_blocks) s.run_up.pop_front();
  }
  ++s.blocks;
  if (s.speaking &&
      (s.quiet >= kPause_blocks || s.blocks - s.utterance >= static_cast<std::uint64_t>(kLongest_blocks)))
    s.end();
  return s.heard;
}

void PhoneDecoder::reset() {
  State& s = *state_;
  if (s.speaking) s.end();
  s.run_up.clear();
  s.blocks = 0;
  s.before.clear();
  s.heard.clear();
}

}  // namespace mien::speech
