#pragma once

#include <cstdint>
#include <string>

#include "app/command_line.h"

namespace mien::app {

/// --seed: a whole number, 0 to 2^64 - 1. (By itself CLI11 takes -1 for the largest.) `of` says what is drawn
/// from it.
Option add_seed_option(Command command, std::uint64_t& seed, const std::string& of);

}  // namespace mien::app
