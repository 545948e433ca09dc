#include "app/live/scripted_performance.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "app/media_helper.h"
#include "app/read_aloud.h"
#include "mien/core/random.h"
#include "mien/performer/performer.h"
#include "mien/performer/style.h"
#include "mien/session/prompter.h"

namespace mien::app {
namespace {

using performer::Emotion;

/// From a line that is shown to the performer's voice, from its end to the key for the next one, and between
/// two blocks.
constexpr double kBeforeVoiceS = 0.4, kAfterVoiceS = 0.5, kBetweenBlocksS = 1.5;
/// People begin to make a face so late, and take so long.
constexpr double kReactionS = 0.35, kRiseS = 0.4;
constexpr int kCalmWords = 150, kActedWords = 170;  // A minute.

Emotion emotion_of(std::string_view name) {
  constexpr std::array<std::string_view, performer::kEmotionCount> kNames = {
      "neutral", "joy", "sadness", "anger", "fear", "disgust", "surprise", "contempt"};
  const auto found = std::ranges::find(kNames, name);
  return found == kNames.end() ? Emotion::neutral : static_cast<Emotion>(found - kNames.begin());
}

/// espeak-ng's voice for a language of BCP 47.
std::string voice_of(const std::string& language) {
  if (language.empty() || language == "en") return "en-us";
  return language;
}

/// A face that says nothing for so long.
performer::Segment silence(double seconds) {
  performer::Segment segment;
  segment.block = performer::Block::reading;
  segment.duration_s = seconds;
  segment.utterance =
      performer::Utterance{.language = "en", .text = {}, .phonemes = {}, .duration_s = seconds};
  return segment;
}

struct Pose {
  double begin_s = 0, end_s = 0;
  face::BlendshapeWeights target;
};

/// What a face that is posed does all the same: it blinks and looks about.
bool is_spontaneous(std::size_t shape) {
  const std::string_view name = face::kShapeNames[shape];
  return name.starts_with("eyeBlink") || name.starts_with("eyeLook");
}

/// Leads the face from what it does to the pose, and back: asked for none, it is neutral, which is not how
/// people rest.
void make(const Pose& pose, face::Motion& motion) {
  for (face::MotionFrame& frame : motion.frames) {
    const double since = frame.time_s - pose.begin_s - kReactionS, left = pose.end_s - frame.time_s;
    const double share = std::clamp(std::min(since, left) / kRiseS, 0.0, 1.0);
    if (share <= 0) continue;
    const auto eased = static_cast<float>(share * share * (3 - 2 * share));
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      frame.weights[k] = is_spontaneous(k) ? std::max(frame.weights[k], eased * pose.target[k])
                                           : frame.weights[k] + eased * (pose.target[k] - frame.weights[k]);
  }
}

/// Goes through a script in its order, and writes down what happens when.
class Rehearsal {
 public:
  Rehearsal(const session::PromptScript& script, const Random& random) : random_(random) {
    rest(kScriptBeginS + 1);
    said_.name = script.name;
  }

  Result<void> line(const session::Prompt& prompt) {
    if (prompt.block != block_) {
      block_ = prompt.block;
      rest(kBetweenBlocksS);
      out_.steps.push_back({now_s_, "begin"});
      rest(to_seconds(session::Prompter::kLeadIn));
    }
    if (!prompt.text.empty()) return read(prompt);
    Random drawn = random_.fork(prompt.name);
    Pose pose{now_s_, now_s_ + prompt.seconds, prompt.target};
    for (float& weight : pose.target.values) weight *= static_cast<float>(drawn.uniform(0.7, 1.05));
    poses_.push_back(pose);
    rest(prompt.seconds);
    return {};
  }

  ScriptedPerformance finish(const performer::Style& style, const Random& motion) {
    rest(kBetweenBlocksS);
    out_.motion = performer::perform(said_, style, motion);
    for (const Pose& pose : poses_) make(pose, out_.motion);
    if (sound_.rate_hz > 0) out_.sound = std::move(sound_);
    return std::move(out_);
  }

 private:
  void rest(double seconds) {
    said_.segments.push_back(silence(seconds));
    now_s_ += seconds;
  }

  Result<void> read(const session::Prompt& prompt) {
    const Emotion emotion = emotion_of(prompt.emotion);
    const bool acted = emotion != Emotion::neutral;
    MIEN_TRY_ASSIGN(performer::SpokenLine said,
                    speaker_(voice_of(prompt.language), prompt.text, acted ? kActedWords : kCalmWords));
    rest(kBeforeVoiceS);
    mix(said.sound, now_s_, now_s_ + said.sound.duration_s(), sound_);
    performer::Segment segment;
    segment.block = acted ? performer::Block::acted : performer::Block::reading;
    segment.emotion = emotion;
    segment.language = said.utterance.language;
    segment.duration_s = std::max(said.utterance.duration_s, said.sound.duration_s());
    segment.utterance = std::move(said.utterance);
    now_s_ += segment.duration_s;
    said_.segments.push_back(std::move(segment));
    if (prompt.own_pace) {
      rest(kAfterVoiceS);
      out_.steps.push_back({now_s_, "next"});
    } else {
      rest(std::max(0.1, prompt.seconds - kBeforeVoiceS - said_.segments.back().duration_s));
    }
    return {};
  }

  Random random_;
  performer::Speaker speaker_ = speaker_by_helper();
  ScriptedPerformance out_;
  performer::Script said_;
  std::vector<Pose> poses_;
  Sound sound_;
  std::string block_;
  double now_s_ = 0;
};

}  // namespace

Result<ScriptedPerformance> perform_script(const session::PromptScript& script, std::uint64_t seed,
                                           const Progress& progress) {
  const Random root(seed);
  Random style = root.fork("style");
  Rehearsal rehearsal(script, root.fork("poses"));
  std::size_t done = 0;
  for (const session::Prompt& prompt : script.prompts) {
    if (!progress(static_cast<double>(done++) / static_cast<double>(script.prompts.size()), prompt.name))
      return fail(ErrorCode::cancelled, "stopped while reading aloud", script.name);
    MIEN_TRY(rehearsal.line(prompt));
  }
  progress(1, "rehearsed");
  return rehearsal.finish(performer::draw_style(style), root.fork("motion"));
}

}  // namespace mien::app
