#include "app/performance.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <utility>

#include "mien/core/excerpt.h"
#include "mien/face/livelink_csv.h"

namespace mien::app {
namespace {

/// The part of a take's sound that belongs to the motion: silence before it begins, nothing from before the
/// motion, nothing where it begins after it.
std::optional<Sound> sound_from(take::Audio audio, DeviceTime start, DeviceTime end) {
  if (audio.start >= end) return std::nullopt;
  Sound sound{.rate_hz = static_cast<std::uint32_t>(audio.rate_hz), .samples = std::move(audio.samples)};
  const auto shift = static_cast<std::int64_t>(std::llround(to_seconds(audio.start - start) * audio.rate_hz));
  if (shift > 0)
    sound.samples.insert(sound.samples.begin(), static_cast<std::size_t>(shift), 0.0F);
  else
    sound.samples.erase(sound.samples.begin(),
                        sound.samples.begin() + std::min(-shift, std::ssize(sound.samples)));
  return sound;
}

}  // namespace

face::Motion motion_of(std::span<const take::TruthFrame> truth, std::string name) {
  face::Motion motion{.name = std::move(name), .frames = {}};
  motion.frames.reserve(truth.size());
  for (const take::TruthFrame& frame : truth) {
    face::MotionFrame& out = motion.frames.emplace_back();
    out.time_s = to_seconds(frame.time - truth.front().time);
    out.weights = frame.weights;
    out.tongue_out = frame.tongue_out;
    out.has_face = frame.has_face;
  }
  return motion;
}

Result<Performance> load_performance(const std::filesystem::path& path, bool with_sound) {
  Performance performance;
  if (path.extension() != ".mien") {
    std::vector<std::string> warnings;
    MIEN_TRY_ASSIGN(performance.motion, face::load_motion(path, &warnings));
    for (const std::string& warning : warnings)
      fmt::print(stderr, "mien: {}: {}\n", without_controls(path.string()), without_controls(warning));
    return performance;
  }
  MIEN_TRY_ASSIGN(const take::Take take, take::Take::open(path));
  MIEN_TRY_ASSIGN(const auto truth, take.truth());
  if (truth.empty())
    return fail(ErrorCode::not_found, "this take holds no truth", path.string(),
                "solve it first: mien solve TAKE --out FILE.csv");
  performance.face = take.header().face;
  performance.motion = motion_of(truth, path.stem().string());
  if (!with_sound) return performance;
  MIEN_TRY_ASSIGN(auto audio, take.audio());
  if (audio && audio->rate_hz > 0)
    performance.sound = sound_from(*std::move(audio), truth.front().time, truth.back().time);
  return performance;
}

}  // namespace mien::app
