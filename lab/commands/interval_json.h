#pragma once

#include "app/json_output.h"
#include "lab/interval.h"

namespace mien::lab {

/// {"mean", "low", "high"}; the ends null where nothing tells them.
[[nodiscard]] inline app::Json interval_json(const Interval& of) {
  const auto end = [&](double value) { return of.half() > 0 ? app::Json(value) : app::Json(); };
  return {{"mean", of.mean}, {"low", end(of.low)}, {"high", end(of.high)}};
}

}  // namespace mien::lab
