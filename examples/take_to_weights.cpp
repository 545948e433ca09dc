// How did the face move in a recorded session? Solves a take with a model, and prints the weights as CSV:
//   take_to_weights                       a take that it makes: a virtual performer reads for two seconds
//   take_to_weights TAKE.mien [MODEL]     a take of yours; the model is the default one of its sensors unless
//   told

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include "mien/core/files.h"
#include "mien/modalities/modalities.h"
#include "mien/solve/solve.h"
#include "mien/virtual/perform_take.h"

namespace {
using namespace mien;

/// A take with no hardware: twelve simulated IMUs on a virtual performer, who holds still, nods and shakes
/// the head first.
Result<void> make_take(const std::filesystem::path& path) {
  virt::PerformRequest request;
  request.take = path;
  request.script = performer::default_script(performer::Block::reading, 2);
  MIEN_TRY_ASSIGN(request.rig, find_resource("rigs/default.toml"));
  MIEN_TRY(virt::perform_take(request, no_progress));
  return {};
}

Result<void> run(const std::filesystem::path& path, const std::string& named) {
  MIEN_TRY_ASSIGN(const take::Take take, take::Take::open(path));
  MIEN_TRY_ASSIGN(const auto model, modalities::live_model(take.rig(), named));
  // As a session shows it: its log is played through a session again.
  MIEN_TRY_ASSIGN(const solve::Solution solution, solve::replay_take(take, model, no_progress));
  fmt::print("time_s,{}\n", fmt::join(face::kShapeNames, ","));
  for (const face::OutputFrame& frame : solution.frames)
    fmt::print("{:.4f},{:.3f}\n", to_seconds(frame.time.time_since_epoch()),
               fmt::join(frame.weights.values, ","));
  fmt::print(stderr, "{} frames, hash {}\n", solution.frames.size(), solution.hash);
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  std::filesystem::path path = argc > 1 ? argv[1] : "";
  Result<void> done;
  if (argc > 1) {
    done = run(argv[1], argc > 2 ? argv[2] : "");
  } else {
    const auto own =
        std::filesystem::temp_directory_path() / fmt::format("take_to_weights-{}.mien", getpid());
    done = make_take(own);
    if (done) done = run(own, "");
    std::filesystem::remove(own);
  }
  if (!done) fmt::print(stderr, "{}\n", done.error().message());
  return done ? 0 : 1;
}
