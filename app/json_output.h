#pragma once

#include <nlohmann/json.hpp>

namespace mien::app {

/// Prints the one JSON object that a command's --json gives on stdout.
void print_json(const nlohmann::ordered_json& object);

}  // namespace mien::app
