#include "app/seed_option.h"

#include <fmt/format.h>

#include <charconv>

namespace mien::app {

Option add_seed_option(Command command, std::uint64_t& seed, const std::string& of) {
  const auto check = [](const std::string& text) -> std::string {
    std::uint64_t value = 0;
    const auto [end, wrong] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (wrong == std::errc{} && end == text.data() + text.size()) return {};
    return fmt::format("{} is no whole number from 0 on", text);
  };
  return command.add_option("--seed", seed, of).check(check, "0 or more").show_default();
}

}  // namespace mien::app
