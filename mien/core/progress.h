#pragma once

#include <functional>
#include <string_view>

namespace mien {

/// How long work tells its caller where it stands. Returns false to ask for a stop: the work then ends with
/// ErrorCode::cancelled as soon as it safely can. `fraction` in [0, 1]; `what` is a short phrase.
using Progress = std::function<bool(double fraction, std::string_view what)>;

/// For callers who do not care.
inline bool no_progress(double, std::string_view) {
  return true;
}

}  // namespace mien
