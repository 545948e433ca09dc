#include <benchmark/benchmark.h>

#include <string>
#include <vector>

#include "mien/core/bytes.h"
#include "mien/core/random.h"
#include "mien/core/rotation.h"
#include "mien/core/sha256.h"

namespace {

using namespace mien;

// One skin patch of a virtual sensor: its rotation from 40 vertices, once a simulated sample.
void fit_rotation_of_a_patch(benchmark::State& state) {
  Random random(1);
  const Quat turn = random.rotation();
  std::vector<Vec3> from;
  std::vector<Vec3> to;
  for (int i = 0; i < 40; ++i) {
    from.push_back(0.005 * random.direction());
    to.push_back(turn * from.back() + 1e-5 * random.direction());
  }
  Quat fitted;
  for (auto step : state) {
    (void)step;
    fitted = fit_rotation(from, to);
    benchmark::DoNotOptimize(fitted);
  }
  Sha256 hash;
  hash.add(std::as_bytes(std::span(fitted.coeffs().data(), 4)));
  state.SetLabel("sha256 " + hash.hex().substr(0, 16));
}
BENCHMARK(fit_rotation_of_a_patch);

// The check value of a full IMU packet.
void crc32_of_a_packet(benchmark::State& state) {
  Random random(2);
  ByteWriter packet;
  for (int i = 0; i < 60; ++i) packet.little(random.bits());
  std::uint32_t crc = 0;
  for (auto step : state) {
    (void)step;
    crc = crc32(packet.bytes());
    benchmark::DoNotOptimize(crc);
  }
  state.SetBytesProcessed(static_cast<std::int64_t>(state.iterations() * packet.bytes().size()));
  state.SetLabel("crc32 " + std::to_string(crc));
}
BENCHMARK(crc32_of_a_packet);

// A second of a virtual sensor's noise: 240 samples of six axes.
void normal_numbers(benchmark::State& state) {
  double sum = 0;
  for (auto step : state) {
    (void)step;
    Random random(3);
    sum = 0;
    for (int i = 0; i < 1440; ++i) sum += random.normal();
    benchmark::DoNotOptimize(sum);
  }
  state.SetItemsProcessed(1440 * state.iterations());
  state.SetLabel("sum " + std::to_string(sum));
}
BENCHMARK(normal_numbers);

}  // namespace
