#include "app/wear_again.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "mien/core/files.h"
#include "mien/face/motion.h"
#include "mien/sensor/rig_part.h"
#include "mien/solve/solve.h"
#include "mien/virtual/perform_take.h"

namespace mien::app {
namespace {

/// What is evaluated of a take, from 0 s on.
Result<face::Motion> evaluated_motion(const take::Take& take) {
  MIEN_TRY_ASSIGN(const std::vector<take::TruthFrame> truth, solve::own_truth(take));
  face::Motion motion;
  motion.name = take.header().script;
  const take::TruthFrame* first = nullptr;
  for (const take::TruthFrame& frame : truth) {
    if (!frame.evaluated) continue;
    if (first == nullptr) first = &frame;
    motion.frames.push_back({.time_s = to_seconds(frame.time - first->time),
                             .weights = frame.weights,
                             .tongue_out = frame.tongue_out,
                             .has_face = frame.has_face});
  }
  return motion;
}

}  // namespace

Result<void> check_wears_again(const take::Take& take) {
  const auto refused = [&](std::string what) {
    return fail(ErrorCode::bad_usage, std::move(what), take.path().string(), "leave --wears away");
  };
  if (!take.header().performer.starts_with("virtual:"))
    return refused("only performed takes can be worn again, and this one was recorded or imported");
  if (!sensor::sensors_of(take.rig(), "speech").empty())
    return refused("a take with a microphone cannot be worn again: its sound is not performed anew");
  MIEN_TRY_ASSIGN(const face::Motion motion, evaluated_motion(take));
  if (motion.duration_s() < 1) return refused("less than a second of the take is evaluated");
  return {};
}

Result<take::Take> wear_again(const take::Take& take, std::uint64_t seed, const std::filesystem::path& folder,
                              const Progress& progress) {
  const take::Header& header = take.header();
  virt::PerformRequest request;
  MIEN_TRY_ASSIGN(request.motion, evaluated_motion(take));
  request.script_name = header.script;
  request.face = header.face;
  request.devices = header.devices;
  request.prologue = performer::prologue_kind(header.prologue);
  request.seed = seed;
  request.software = header.software;
  request.rig = folder / "rig.toml";
  request.take = folder / fmt::format("{}.mien", seed);
  request.replace = true;
  MIEN_TRY(write_file(request.rig, header.rig_toml));
  MIEN_TRY(virt::perform_take(request, progress));
  return take::Take::open(request.take);
}

}  // namespace mien::app
