#include <fmt/format.h>

#include <filesystem>

#include <cmath>
#include <memory>
#include <utility>

#include "app/command.h"
#include "app/json_output.h"
#include "app/performance.h"
#include "app/phone_option.h"
#include "app/write_motion.h"
#include "mien/solve/phone_truth.h"
#include "mien/solve/solve.h"
#include "mien/solve/trace_features.h"
#include "mien/take/take.h"

namespace mien::app {
namespace {

struct AlignOptions {
  std::string take, phone, out;
  PhoneReading reading;
  bool force = false;
  bool json = false;
};

/// How first guesses are called, for programs and for people; by solve::FirstGuess.
constexpr std::pair<const char*, const char*> kGuessNames[] = {{"none", "none, every offset was tried"},
                                                               {"arrivals", "when both arrived"},
                                                               {"sound", "what both heard"},
                                                               {"taps", "three taps that both saw"}};

std::pair<const char*, const char*> named(solve::FirstGuess guess) {
  return kGuessNames[static_cast<std::size_t>(guess)];
}

void print(const solve::PhoneTruth& truth, const solve::PhoneTrack& track) {
  const phone::TimeAlignment& at = truth.alignment;
  fmt::print(
      "first guess {}\n"
      "offset     {:.1f} ms +- {:.1f} in the middle, drift {:+.1f} ppm +- {:.1f}\n"
      "agreement  {:.2f} (share of jaw and smile that the skin foretells; {:.2f} is asked)\n"
      "in common  {:.1f} s{}\n",
      named(truth.guess).second, 1e3 * at.offset_s, 1e3 * at.offset_sigma_s, at.drift_ppm, at.drift_sigma_ppm,
      at.agreement, phone::kLeastAgreement, at.overlap_s,
      track.left_out_s > 0 ? fmt::format("; {:.1f} s left out, the phone's clock jumped", track.left_out_s)
                           : "");
  if (track.sound) {
    const solve::SoundGuess& sound = *track.sound;
    fmt::print(
        "sound      {:.1f} ms, drift {:+.1f} ppm; {:.1f} times as alike as at any other offset, and {:.0f} % "
        "of its blocks agree\n"
        "           film and file begin together {}, to {:.0f} ms; the motion is {:.1f} ms {} than the "
        "sound\n",
        1e3 * sound.at.offset_s, sound.at.drift_ppm, sound.at.score, 100 * sound.at.agreeing,
        sound.by_timecode ? "by their time codes" : "by assumption", 1e3 * sound.begin_sigma_s,
        1e3 * std::abs(*truth.after_sound_s), *truth.after_sound_s < 0 ? "earlier" : "later");
  }
  fmt::print("\n{:>8}{:>8}{:>12}{:>8}{:>11}\n", "from s", "to s", "off by ms", "+- ms", "agreement");
  for (const phone::AlignmentBlock& block : at.blocks)
    fmt::print("{:8.1f}{:8.1f}{:12.1f}{:8.1f}{:11.2f}\n", block.begin_s, block.end_s, 1e3 * block.residual_s,
               1e3 * block.sigma_s, block.agreement);
}

Json sound_json(const solve::PhoneTruth& truth, const solve::PhoneTrack& track) {
  if (!track.sound) return {};
  const solve::SoundGuess& sound = *track.sound;
  return {{"offset_ms", 1e3 * sound.at.offset_s},
          {"offset_sigma_ms", 1e3 * sound.at.offset_sigma_s},
          {"drift_ppm", sound.at.drift_ppm},
          {"score", sound.at.score},
          {"agreeing", sound.at.agreeing},
          {"overlap_s", sound.at.overlap_s},
          {"by_timecode", sound.by_timecode},
          {"begin_sigma_ms", 1e3 * sound.begin_sigma_s},
          {"motion_after_sound_ms", 1e3 * *truth.after_sound_s}};
}

Json alignment_json(const AlignOptions& options, const solve::PhoneTruth& truth,
                    const solve::PhoneTrack& track) {
  const phone::TimeAlignment& at = truth.alignment;
  Json blocks = Json::array();
  for (const phone::AlignmentBlock& block : at.blocks)
    blocks.push_back({{"begin_s", block.begin_s},
                      {"end_s", block.end_s},
                      {"residual_ms", 1e3 * block.residual_s},
                      {"sigma_ms", 1e3 * block.sigma_s},
                      {"agreement", block.agreement}});
  return {{"take", options.take},
          {"phone", options.phone.empty() ? Json() : Json(options.phone)},
          {"first_guess", named(truth.guess).first},
          {"sound", sound_json(truth, track)},
          {"middle_s", at.middle_s},
          {"offset_ms", 1e3 * at.offset_s},
          {"offset_sigma_ms", 1e3 * at.offset_sigma_s},
          {"drift_ppm", at.drift_ppm},
          {"drift_sigma_ppm", at.drift_sigma_ppm},
          {"agreement", at.agreement},
          {"overlap_s", at.overlap_s},
          {"left_out_s", track.left_out_s},
          {"blocks", std::move(blocks)}};
}

Result<void> run_align(const AlignOptions& options) {
  if (!options.out.empty()) {
    MIEN_TRY(check_output(options.out, {".csv"}));
    // What a phone recorded cannot be had again.
    std::error_code ignored;
    if (!options.force && std::filesystem::exists(options.out, ignored))
      return fail(ErrorCode::bad_usage, "it exists already", options.out, "use --force to replace it");
  }
  MIEN_TRY_ASSIGN(const take::Take take, take::Take::open(options.take));
  MIEN_TRY(check_aligns(take));
  MIEN_TRY_ASSIGN(const std::vector<model::FeatureFrame> features, solve::take_features(take));
  MIEN_TRY_ASSIGN(const solve::PhoneTrack track, options.reading.open(take, features, options.phone));
  MIEN_TRY_ASSIGN(const std::vector<take::Event> events, take.events());
  MIEN_TRY_ASSIGN(const solve::PhoneTruth truth, solve::phone_truth(events, features, track));
  if (!options.out.empty())
    MIEN_TRY(write_motion(motion_of(truth.frames, track.motion.name), take.header().face, options.out));
  if (options.json) {
    print_json(alignment_json(options, truth, track));
  } else {
    print(truth, track);
    if (!options.out.empty()) fmt::print("\nwrote {}\n", options.out);
  }
  return {};
}

}  // namespace

void add_align_command(Commands& commands) {
  auto options = std::make_shared<AlignOptions>();
  const Command command = commands.add(
      "align", "Finds a phone's time beside a take's sensors, by how faces move",
      "mien align take.mien phone.csv --out truth.csv", [options] { return run_align(*options); });
  command.add_option("take", options->take, "The take").required();
  command.add_option(
      "phone", options->phone,
      "What a phone recorded meanwhile: a Live Link Face CSV (default: the truth in the take)");
  command.add_option(
      "--out", options->out,
      "Write what the phone told at the take's frames, less its neutral face: .csv (Live Link Face)");
  command.add_flag("--force", options->force, "Replace --out where it exists");
  options->reading.add_to(command);
  add_json_flag(command, options->json);
}

}  // namespace mien::app
