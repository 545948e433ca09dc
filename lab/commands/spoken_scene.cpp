#include "lab/commands/spoken_scene.h"

#include <filesystem>

#include "mien/core/files.h"
#include "mien/modalities/modalities.h"

namespace mien::lab {

void add_spoken_rig_option(app::Command command, std::string& rig) {
  command.add_option("--rig", rig, "Of IMUs or of glasses (default: rigs/default.toml)");
}

Result<SpokenScene> read_spoken_scene(const std::string& rig) {
  SpokenScene scene;
  MIEN_TRY_ASSIGN(const std::filesystem::path file, app::path_or(rig, "rigs/default.toml"));
  MIEN_TRY_ASSIGN(scene.rig, sensor::read_rig(file));
  MIEN_TRY_ASSIGN(scene.model, modalities::live_model(scene.rig, ""));
  MIEN_TRY_ASSIGN(const std::filesystem::path network, find_resource("models/speech.safetensors"));
  MIEN_TRY_ASSIGN(scene.network, speech::read_speech_network(network));
  return scene;
}

}  // namespace mien::lab
