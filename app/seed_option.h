#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>

namespace mien::app {

/// --seed: a whole number, 0 to 2^64 - 1. (By itself CLI11 takes -1 for the largest.) `of` says what is drawn
/// from it.
CLI::Option* add_seed_option(CLI::App* command, std::uint64_t& seed, const std::string& of);

}  // namespace mien::app
