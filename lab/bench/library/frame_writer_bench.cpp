#include <benchmark/benchmark.h>

#include <cmath>
#include <string>
#include <vector>

#include "mien/core/sha256.h"
#include "mien/tracker/frame_writer.h"

namespace {

using namespace mien;

/// As much of a model as the frame writer reads, with a table as large as the shipped ones'.
model::ModelFile model_of(std::size_t sensors) {
  model::ModelFile file;
  for (std::size_t s = 0; s < sensors; ++s) file.features.sensors.push_back("sensor " + std::to_string(s));
  file.normalisation.mean.assign(file.features.value_count(), 0.0F);
  file.normalisation.scale.assign(file.features.value_count(), 1.0F);
  model::ConfidenceTable& table = file.confidence.emplace();
  table.coverage_edges = {0.001F, 0.3F, 0.5F, 0.7F, 0.85F, 0.999F};
  table.value_edges = {0.02F, 0.05F, 0.1F, 0.15F, 0.2F, 0.3F, 0.45F, 0.6F, 0.8F};
  table.measured_from = 0.5F;
  for (std::size_t i = 0; i < face::kShapeCount * table.coverage_bins(); ++i) {
    table.explained.push_back(0.1F * static_cast<float>(i % table.coverage_bins()));
    for (std::size_t v = 0; v < table.value_bins(); ++v)
      table.within.push_back(1.0F - 0.01F * static_cast<float>(v + i % 13));
  }
  return file;
}

// What stands around the weights of one frame, confidence and provenance included; `missing`: one of eleven
// sensors is silent, so that the coverage is summed up.
void frame_writer(benchmark::State& state) {
  const model::ModelFile file = model_of(11);
  const tracker::FrameWriter writer(file);
  tracker::ModelInput input(file, file.features.sensors);
  model::FeatureFrame features;
  features.sensors.resize(11);
  for (model::SensorFeature& sensor : features.sensors) sensor.has_rotation = true;
  if (state.range(0) != 0) features.sensors[3] = {};
  std::vector<float> condition(file.features.width());
  input.encode(features, condition);
  std::vector<face::OutputFrame> frames(600);
  for (std::size_t f = 0; f < frames.size(); ++f)
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      frames[f].weights[k] = static_cast<float>(0.5 + 0.5 * std::sin(0.1 * static_cast<double>(f + 7 * k)));
  std::size_t f = 0;
  for (auto _ : state) {
    writer.write(features, input, frames[f]);
    benchmark::DoNotOptimize(frames[f].confidence.data());
    f = (f + 1) % frames.size();
  }
  Sha256 hash;
  for (face::OutputFrame& frame : frames) {
    writer.write(features, input, frame);
    for (const float confidence : frame.confidence) hash.add_value(confidence);
  }
  state.SetLabel(hash.hex().substr(0, 16));
}
BENCHMARK(frame_writer)->ArgName("missing")->Arg(0)->Arg(1);

}  // namespace
