#include "app/shaping_option.h"

#include "mien/core/files.h"

namespace mien::app {

void ShapingOption::add_to(Command command) {
  command.add_option("--shaping", path,
                     "Shape the frames as a session with these settings would: a JSON file, {} for the "
                     "defaults (docs/reference/shaping_settings.md). Without it by the defaults; a window "
                     "model's answer is not shaped");
}

Result<std::optional<shaping::ShaperSettings>> ShapingOption::read() const {
  if (path.empty()) return std::nullopt;
  MIEN_TRY_ASSIGN(const std::string text, read_text(path));
  MIEN_TRY_ASSIGN(const shaping::ShaperSettings settings, shaping::parse_settings(text, path));
  return settings;
}

std::vector<Ablated> ablations(const shaping::ShaperSettings& settings) {
  std::vector<Ablated> out;
  for (std::size_t step = 0; step < shaping::kChainStepCount; ++step) {
    out.push_back({std::string(shaping::kChainStepNames[step]), settings});
    out.back().settings.off.set(step);
  }
  out.push_back({"every step", settings});
  out.back().settings.off.set();
  return out;
}

}  // namespace mien::app
