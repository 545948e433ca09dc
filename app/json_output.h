#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace mien::app {

/// JSON that keeps the order in which it is made.
using Json = nlohmann::ordered_json;

/// As --json prints it and as files have it, with a line's end: text that is no UTF-8 is replaced.
[[nodiscard]] std::string json_text(const Json& object);

/// Prints the one JSON object that a command's --json gives on stdout.
void print_json(const Json& object);

}  // namespace mien::app
