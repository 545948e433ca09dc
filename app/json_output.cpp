#include "app/json_output.h"

#include <cstdio>
#include <string>

namespace mien::app {

void print_json(const Json& object) {
  // A path may be any bytes: what is no UTF-8 is replaced.
  const std::string text = object.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
  std::fwrite(text.data(), 1, text.size(), stdout);
}

}  // namespace mien::app
