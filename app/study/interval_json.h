#pragma once

#include "app/json_output.h"
#include "mien/study/interval.h"

namespace mien::app {

/// {"mean", "low", "high"}; the ends null where nothing tells them.
[[nodiscard]] inline Json interval_json(const study::Interval& of) {
  const auto end = [&](double value) { return of.half() > 0 ? Json(value) : Json(); };
  return {{"mean", of.mean}, {"low", end(of.low)}, {"high", end(of.high)}};
}

}  // namespace mien::app
