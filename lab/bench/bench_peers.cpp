#include "lab/bench/bench_peers.h"

#include <nlohmann/json.hpp>

#include "app/trainer_helper.h"
#include "lab/bench/onnx_peer.h"

namespace mien::lab {

Peer onnxruntime_step(const std::filesystem::path& model) {
  const auto times = measure_onnxruntime({.model = model});
  if (!times) return {.step_us = std::nullopt, .why_not = times.error().message()};
  return {.step_us = 1e6 * times->best_step_s, .why_not = {}};
}

Peer libtorch_step(const std::filesystem::path& model) {
  const auto said = app::ask_trainer({"step", model.string(), "--json"});
  if (!said) return {.step_us = std::nullopt, .why_not = said.error().message()};
  const auto told = nlohmann::json::parse(*said, nullptr, false);
  if (!told.is_object() || !told.contains("step_us") || !told["step_us"].is_number())
    return {.step_us = std::nullopt, .why_not = "mien-train did not say how long a step took"};
  return {.step_us = told["step_us"].get<double>(), .why_not = {}};
}

}  // namespace mien::lab
