#include "app/study/study_headset.h"

#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "app/json_output.h"
#include "app/seed_option.h"
#include "mien/render/lettering.h"
#include "mien/sensor/rig.h"
#include "mien/study/headset/contact_sheet.h"

namespace mien::app {
namespace {

struct StudyHeadsetOptions {
  study::ContactSheetRequest sheet;
  std::string out, rig;
};

Result<void> run_study_headset(const StudyHeadsetOptions& options) {
  MIEN_TRY_ASSIGN(const std::filesystem::path file, path_or(options.rig, "rigs/headset.toml"));
  MIEN_TRY_ASSIGN(const sensor::Rig rig, sensor::read_rig(file));
  study::ContactSheetRequest request = options.sheet;
  if (std::filesystem::exists(render::kFontFile)) request.font = render::kFontFile;
  MIEN_TRY_ASSIGN(const render::Image sheet,
                  study::headset_contact_sheet(request, rig, terminal_progress("headset")));
  clear_progress();
  MIEN_TRY(render::write_png(options.out, sheet));
  fmt::print("{}: {} x {} pixels\n", options.out, sheet.width, sheet.height);
  return {};
}

}  // namespace

void add_study_headset(Commands& commands, Command study) {
  auto options = std::make_shared<StudyHeadsetOptions>();
  const Command command = commands.add_under(
      study, "headset", "What a virtual headset's cameras see: a sheet of wearers and expressions",
      "mien study headset --sheet wearers.png --wearers 6",
      [options] { return run_study_headset(*options); });
  command.add_option("--sheet", options->out, "The PNG file to write").required();
  command.add_option("--rig", options->rig, "Rig file (default: rigs/headset.toml)");
  command.add_option("--wearers", options->sheet.wearers, "Virtual wearers, a row each")
      .in_range(1, 64)
      .show_default();
  command.add_flag("--failures", options->sheet.failures,
                   "A row for each thing that hides a face, instead of expressions");
  command.add_option("--side", options->sheet.side, "Pixels of a view either way")
      .in_range(16, 480)
      .show_default();
  add_seed_option(command, options->sheet.seed, "Of the wearers and their headsets");
}

}  // namespace mien::app
