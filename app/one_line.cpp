#include "app/one_line.h"

#include "mien/core/excerpt.h"

namespace mien::app {

std::string one_line(std::string_view text, std::size_t max_letters) {
  return excerpt(text, max_letters);
}

}  // namespace mien::app
