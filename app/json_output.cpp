#include "app/json_output.h"

#include <cstdio>
#include <string>

namespace mien::app {

void print_json(const nlohmann::ordered_json& object) {
  const std::string text = object.dump(2) + "\n";
  std::fwrite(text.data(), 1, text.size(), stdout);
}

}  // namespace mien::app
