#pragma once

#include <nlohmann/json.hpp>

namespace mien::app {

/// JSON that keeps the order in which it is made.
using Json = nlohmann::ordered_json;

/// Prints the one JSON object that a command's --json gives on stdout.
void print_json(const Json& object);

}  // namespace mien::app
