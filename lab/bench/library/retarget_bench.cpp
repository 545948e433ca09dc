#include <benchmark/benchmark.h>

#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "mien/builtin_face/builtin_face.h"
#include "mien/core/sha256.h"
#include "mien/face/marker_deformation.h"
#include "mien/face/weight_solver.h"

namespace {

using namespace mien;

/// Every second of the built-in face's landmarks as markers, and a face that speaks.
struct Marked {
  face::Face face = builtin_face::make_builtin({});
  Eigen::VectorXd neutral_m = Eigen::VectorXd::Zero(3 * 34);
  Eigen::MatrixXd shapes_m = Eigen::MatrixXd::Zero(3 * 34, static_cast<Eigen::Index>(face::kShapeCount));

  Marked() {
    std::vector<Vec3f> moved(face.neutral_m.size());
    for (std::size_t k = 0; k < face::kShapeCount; ++k) {
      face::BlendshapeWeights one;
      one[k] = 1;
      face::evaluate(face, one, 0, moved);
      for (Eigen::Index i = 0; i < 34; ++i) {
        const std::uint32_t v = face.landmarks[static_cast<std::size_t>(2 * i)];
        neutral_m.segment<3>(3 * i) = face.neutral_m[v].cast<double>();
        shapes_m.col(static_cast<Eigen::Index>(k)).segment<3>(3 * i) =
            (moved[v] - face.neutral_m[v]).cast<double>();
      }
    }
  }
  [[nodiscard]] std::vector<Eigen::VectorXd> speech() const {
    std::vector<Eigen::VectorXd> frames;
    for (int i = 0; i < 600; ++i) {
      Eigen::VectorXd weights = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(face::kShapeCount));
      for (Eigen::Index k = 0; k < weights.size(); ++k)
        weights[k] = std::max(
            0.0, 0.6 * std::sin(0.02 * i * (1 + 0.1 * static_cast<double>(k)) + static_cast<double>(k)));
      frames.emplace_back(neutral_m + shapes_m * weights);
    }
    return frames;
  }
};

// Markers to weights, a frame.
void weights_of_34_markers(benchmark::State& state) {
  const Marked marked;
  const std::vector<Eigen::VectorXd> frames = marked.speech();
  face::WeightSolver solver = face::WeightSolver::create(marked.neutral_m, marked.shapes_m).value();
  face::BlendshapeWeights weights;
  std::size_t i = 0;
  for (auto step : state) {
    (void)step;
    solver.solve(frames[i++ % frames.size()], {}, 1 / 60.0, weights);
    benchmark::DoNotOptimize(weights);
  }
  solver.reset();
  Sha256 hash;
  for (const Eigen::VectorXd& frame : frames) {
    solver.solve(frame, {}, 1 / 60.0, weights);
    hash.add(std::as_bytes(std::span(weights.values)));
  }
  state.SetLabel("sha256 " + hash.hex().substr(0, 16));
}
BENCHMARK(weights_of_34_markers)->Unit(benchmark::kMicrosecond);

// Markers to the whole mesh of a face without shapes, a frame.
void mesh_of_34_markers(benchmark::State& state) {
  const Marked marked;
  const std::vector<Eigen::VectorXd> frames = marked.speech();
  const auto deformation = face::MarkerDeformation::create(marked.face, marked.neutral_m).value();
  std::vector<Vec3f> vertices(marked.face.neutral_m.size());
  std::size_t i = 0;
  for (auto step : state) {
    (void)step;
    deformation.apply(marked.face, frames[i++ % frames.size()], vertices);
    benchmark::DoNotOptimize(vertices.data());
  }
  deformation.apply(marked.face, frames.back(), vertices);
  Sha256 hash;
  hash.add(std::as_bytes(std::span(vertices)));
  state.SetLabel(std::to_string(vertices.size()) + " vertices, sha256 " + hash.hex().substr(0, 16));
}
BENCHMARK(mesh_of_34_markers)->Unit(benchmark::kMicrosecond);

}  // namespace
