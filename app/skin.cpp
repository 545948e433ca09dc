#include <filesystem>
#include <memory>
#include <string>

#include "app/command.h"
#include "app/seed_option.h"
#include "mien/sensor/rig.h"
#include "mien/virtual/imu/skin_motion.h"

namespace mien::app {
namespace {

struct SkinOptions {
  virt::SkinMotionRequest request;
  std::string rig;
};

Result<void> run_skin(const SkinOptions& options) {
  MIEN_TRY_ASSIGN(const std::filesystem::path path, path_or(options.rig, "rigs/default.toml"));
  MIEN_TRY_ASSIGN(const sensor::Rig rig, sensor::read_rig(path));
  MIEN_TRY_ASSIGN(const sensor::SkinMotion skin,
                  virt::study_skin_motion(options.request, rig, terminal_progress("skin")));
  fmt::print("{}", sensor::write_skin(skin));
  return {};
}

}  // namespace

void add_skin_command(Commands& commands, const Command& study) {
  auto skin = std::make_shared<SkinOptions>();
  const Command command =
      commands.add_under(study, "skin", "How skin turns under a rig's sensors: the [skin] table of its file",
                         "mien study skin --rig my_rig.toml > skin.toml", [skin] { return run_skin(*skin); });
  add_rig_option(command, skin->rig);
  command.add_option("--performers", skin->request.performers, "Virtual performers")
      .in_range(1, 100000)
      .show_default();
  command.add_option("--seconds", skin->request.seconds, "Length of each performance")
      .number_between(1.0, 3600.0)
      .show_default();
  add_seed_option(command, skin->request.seed, "Of the performers");
}

}  // namespace mien::app
