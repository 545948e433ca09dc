#include "app/trainer_helper.h"

#include <unistd.h>

#include <filesystem>
#include <string_view>
#include <utility>

extern char** environ;

namespace mien::app {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kLibraries = "LD_LIBRARY_PATH=";

/// The kernels that OpenBLAS is to multiply with; empty: as it finds itself. Debian 12's (0.3.21) does not
/// know CPUs that are newer than it is, and takes its oldest kernels on them: 0.6 of the speed of training.
std::string_view blas_kernels() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
      __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
    return "SKYLAKEX";
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return "HASWELL";
#endif
  return "";
}

/// This program's environment as libtorch is quickest in it. Debian's OpenBLAS comes in a pthread and an
/// OpenMP variant. Under libtorch, which brings OpenMP threads of its own, the pthread one is slower with two
/// threads than with one, so the other is put first where it is installed. OPENBLAS_CORETYPE and
/// OPENBLAS_L2_SIZE, where a machine sets them, pin it to another CPU's kernels: half the speed.
std::vector<std::string> environment() {
  std::vector<std::string> variables;
  std::string libraries;
  for (char** variable = environ; *variable != nullptr; ++variable) {
    const std::string_view text = *variable;
    if (text.starts_with("OPENBLAS_CORETYPE=") || text.starts_with("OPENBLAS_L2_SIZE=")) continue;
    if (text.starts_with(kLibraries))
      libraries = text.substr(kLibraries.size());
    else
      variables.emplace_back(text);
  }
  std::error_code code;
  for (const char* folder :
       {"/usr/lib/x86_64-linux-gnu/openblas-openmp", "/usr/lib/aarch64-linux-gnu/openblas-openmp"})
    if (fs::exists(folder, code)) libraries = libraries.empty() ? folder : folder + (":" + libraries);
  if (!libraries.empty()) variables.push_back(std::string(kLibraries) + libraries);
  if (const std::string kernels(blas_kernels()); !kernels.empty())
    variables.push_back("OPENBLAS_CORETYPE=" + kernels);
  return variables;
}

Result<std::vector<std::string>> command_of(std::vector<std::string> arguments) {
  MIEN_TRY_ASSIGN(const fs::path helper, find_helper("mien-train"));
  arguments.insert(arguments.begin(), helper.string());
  return arguments;
}

}  // namespace

Result<void> become_trainer(std::vector<std::string> arguments) {
  MIEN_TRY_ASSIGN(const fs::path helper, find_helper("mien-train"));
  arguments.insert(arguments.begin(), "mien");  // By which it knows what was typed.
  auto become = become_program(helper, std::move(arguments), environment());
  if (!become) become.error().fix = "build or install it again, with Debian's libtorch-dev";
  return become;
}

Result<std::string> ask_trainer(std::vector<std::string> arguments) {
  MIEN_TRY_ASSIGN(const std::vector<std::string> command, command_of(std::move(arguments)));
  MIEN_TRY_ASSIGN(const ChildOutput said, run_child(command, environment()));
  if (said.succeeded()) return said.out;
  const std::string line = said.complaints.substr(0, said.complaints.find('\n'));
  return fail(ErrorCode::io, line.empty() ? "it stopped without a word" : line, command.front());
}

Result<Child> start_trainer(std::vector<std::string> arguments) {
  MIEN_TRY_ASSIGN(std::vector<std::string> command, command_of(std::move(arguments)));
  return Child::start(std::move(command), Child::Input::none, environment());
}

}  // namespace mien::app
