#pragma once

#include <string>

namespace mien::live {

/// What a session says of itself, in words for a person: an event of the page.
struct Sentence {
  std::string kind;  ///< docs/reference/page_protocol.md lists them: "sensor_lost".
  std::string text;  ///< "mentalis is lost".
};

}  // namespace mien::live
