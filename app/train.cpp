#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/command.h"
#include "app/trainer_helper.h"

namespace mien::app {

void add_train_command(Commands& commands) {
  const auto command = std::make_shared<std::optional<Command>>();
  *command = commands.add("train", "Trains a model by a recipe (helper mien-train)",
                          "mien train models/recipes/default.toml --out mine.safetensors", [command] {
                            std::vector<std::string> arguments = (*command)->remaining();
                            arguments.insert(arguments.begin(), "train");
                            return become_trainer(std::move(arguments));
                          });
  (*command)->pass_on();
}

}  // namespace mien::app
