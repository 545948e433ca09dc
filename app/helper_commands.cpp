#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/command.h"
#include "app/trainer_helper.h"

namespace mien::app {
namespace {

/// Becomes the helper mien-lab, which calls itself mien.
Result<void> become_laboratory(std::vector<std::string> arguments) {
  MIEN_TRY_ASSIGN(const std::filesystem::path helper, find_helper("mien-lab"));
  arguments.insert(arguments.begin(), "mien");
  return become_program(helper, std::move(arguments));
}

/// A command that a helper does, but for commands of its own that are added before it is passed on. `become`
/// gets the command's name and what stands behind it.
Command add_helper_command(Commands& commands, const std::string& name, const std::string& does,
                           const std::string& example,
                           const std::function<Result<void>(std::vector<std::string>)>& become) {
  const auto command = std::make_shared<std::optional<Command>>();
  *command = commands.add(name, does, example, [command, name, become] {
    std::vector<std::string> arguments = (*command)->remaining();
    arguments.insert(arguments.begin(), name);
    return become(std::move(arguments));
  });
  return **command;
}

}  // namespace

void add_study_command(Commands& commands) {
  const Command study = add_helper_command(
      commands, "study", "The experiments behind the numbers (helper mien-lab); rigs' skin",
      "mien study placement --no-training --out placement", become_laboratory);
  add_skin_command(commands, study);
  study.pass_on();
}

void add_bench_command(Commands& commands) {
  add_helper_command(commands, "bench", "How fast it is on this machine, beside peers (helper mien-lab)",
                     "mien bench live", become_laboratory)
      .pass_on();
}

void add_train_command(Commands& commands) {
  add_helper_command(commands, "train", "Trains a model by a recipe (helper mien-train)",
                     "mien train models/recipes/default.toml --out mine.safetensors", become_trainer)
      .pass_on();
}

}  // namespace mien::app
