#pragma once

#include "app/json_output.h"
#include "mien/study/interval.h"

namespace mien::app {

/// {"mean", "low", "high"}.
[[nodiscard]] inline Json interval_json(const study::Interval& of) {
  return {{"mean", of.mean}, {"low", of.low}, {"high", of.high}};
}

}  // namespace mien::app
