#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "app/command.h"
#include "app/media_helper.h"

namespace mien::app {
namespace {

namespace fs = std::filesystem;

/// Debian's OpenBLAS comes in a pthread and an OpenMP variant. Under libtorch, which brings OpenMP threads of
/// its own, the pthread one is slower with two threads than with one, so the other is put first where it is
/// installed. OPENBLAS_CORETYPE and OPENBLAS_L2_SIZE pin it to another CPU's kernels: half the speed.
void prepare_environment() {
  ::unsetenv("OPENBLAS_CORETYPE");
  ::unsetenv("OPENBLAS_L2_SIZE");
  std::error_code code;
  for (const char* folder :
       {"/usr/lib/x86_64-linux-gnu/openblas-openmp", "/usr/lib/aarch64-linux-gnu/openblas-openmp"}) {
    if (!fs::exists(folder, code)) continue;
    const char* given = std::getenv("LD_LIBRARY_PATH");
    const std::string path =
        given != nullptr && *given != 0 ? std::string(folder) + ":" + given : std::string(folder);
    ::setenv("LD_LIBRARY_PATH", path.c_str(), 1);
  }
}

/// Becomes the helper, so that its exit status, its progress and Ctrl-C are the program's own.
Result<void> become_trainer(std::vector<std::string> arguments) {
  MIEN_TRY_ASSIGN(const fs::path helper, find_helper("mien-train"));
  std::string name = helper.string(), command = "train";
  std::vector<char*> argv = {name.data(), command.data()};
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  prepare_environment();
  ::execv(name.c_str(), argv.data());
  return fail(ErrorCode::io, std::strerror(errno), name,
              "build or install it again, with Debian's libtorch-dev");
}

}  // namespace

void add_train_command(Commands& commands) {
  auto command = std::make_shared<CLI::App*>(nullptr);
  *command = commands.add("train", "Trains a model by a recipe (starts the helper mien-train)",
                          "mien train models/recipes/default.toml --out mine.safetensors",
                          [command] { return become_trainer((*command)->remaining()); });
  // Everything behind `train`, --help as well, is the helper's.
  (*command)->set_help_flag();
  (*command)->prefix_command();
}

}  // namespace mien::app
