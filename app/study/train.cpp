#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "app/command.h"
#include "app/study/trainer_helper.h"

namespace mien::app {

void add_train_command(Commands& commands) {
  auto command = std::make_shared<CLI::App*>(nullptr);
  *command = commands.add("train", "Trains a model by a recipe (starts the helper mien-train)",
                          "mien train models/recipes/default.toml --out mine.safetensors", [command] {
                            std::vector<std::string> arguments = (*command)->remaining();
                            arguments.insert(arguments.begin(), "train");
                            return become_trainer(std::move(arguments));
                          });
  // Everything behind `train`, --help as well, is the helper's.
  (*command)->set_help_flag();
  (*command)->prefix_command();
}

}  // namespace mien::app
