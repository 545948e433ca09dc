#include <string>
#include <string_view>

#include "app/command.h"
#include "lab/bench/benchmarks.h"
#include "lab/commands/studies.h"

int main(int argc, char** argv) {
  using namespace mien;
  // What it was typed as: mien, where `mien study` or `mien bench` became it.
  const std::string program = argc > 0 && std::string_view(argv[0]) == "mien" ? "mien" : "mien-lab";
  app::Commands commands(program, "Mien's studies and benchmarks. Started by `mien study` and `mien bench`.");
  commands.require_one(true);
  lab::add_studies(commands);
  lab::add_benchmarks(commands);
  return commands.main(argc, argv, app::usage_error);
}
