#include "app/json_output.h"

#include <cstdio>

namespace mien::app {

std::string json_text(const Json& object) {
  // A path may be any bytes: what is no UTF-8 is replaced.
  return object.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

void print_json(const Json& object) {
  const std::string text = json_text(object);
  std::fwrite(text.data(), 1, text.size(), stdout);
}

}  // namespace mien::app
