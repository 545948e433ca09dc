#include "lab/columns.h"

#include <fmt/format.h>

namespace mien::lab {

std::string cell_text(const Json& value, const std::string& format, double factor) {
  if (value.is_null()) return "-";
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (value.is_string()) return fmt::format(fmt::runtime(format), value.get<std::string>());
  if (value.is_number_integer()) return fmt::format(fmt::runtime(format), value.get<std::int64_t>());
  return fmt::format(fmt::runtime(format), factor * value.get<double>());
}

}  // namespace mien::lab
