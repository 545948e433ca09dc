#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/child_program.h"
#include "app/command.h"
#include "app/skin.h"

extern char** environ;

namespace mien::app {
namespace {

/// Becomes the helper mien-lab, which calls itself mien. `arguments`: behind `name`.
Result<void> become_laboratory(const std::string& name, std::vector<std::string> arguments) {
  MIEN_TRY_ASSIGN(const std::filesystem::path helper, find_helper("mien-lab"));
  arguments.insert(arguments.begin(), {"mien", name});
  std::vector<std::string> environment;
  for (char** variable = environ; *variable != nullptr; ++variable) environment.emplace_back(*variable);
  return become_program(helper, std::move(arguments), std::move(environment));
}

/// A command that is the laboratory's, but for commands of its own that are added before it is passed on.
Command add_laboratory_command(Commands& commands, const std::string& name, const std::string& does,
                               const std::string& example) {
  const auto command = std::make_shared<std::optional<Command>>();
  *command = commands.add(name, does, example,
                          [command, name] { return become_laboratory(name, (*command)->remaining()); });
  return **command;
}

}  // namespace

void add_study_command(Commands& commands) {
  const Command study = add_laboratory_command(
      commands, "study", "The experiments behind the numbers (helper mien-lab); rigs' skin",
      "mien study placement --no-training --out placement");
  add_skin_command(commands, study);
  study.pass_on();
}

void add_bench_command(Commands& commands) {
  add_laboratory_command(commands, "bench", "How fast it is on this machine, beside peers (helper mien-lab)",
                         "mien bench live")
      .pass_on();
}

}  // namespace mien::app
