#include "mien/core/random.h"

#include <bit>
#include <cmath>
#include <numbers>

namespace mien {
namespace {

std::uint64_t splitmix64(std::uint64_t& x) {
  x += 0x9E3779B97F4A7C15ULL;
  std::uint64_t z = x;
  z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9ULL;
  z = (z ^ (z >> 27U)) * 0x94D049BB133111EBULL;
  return z ^ (z >> 31U);
}

}  // namespace

Random::Random(std::uint64_t seed) {
  state_.seed = seed;
  std::uint64_t x = seed;
  for (auto& word : state_.words) word = splitmix64(x);
}

Random Random::fork(std::string_view name, std::uint64_t index) const {
  std::uint64_t hash = 0xCBF29CE484222325ULL;  // FNV-1a over the name.
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001B3ULL;
  std::uint64_t x = state_.seed ^ std::rotl(hash, 17);
  const std::uint64_t mixed = splitmix64(x) ^ (index * 0xD1342543DE82EF95ULL);
  std::uint64_t y = mixed;
  return Random(splitmix64(y));
}

std::uint64_t Random::bits() {
  auto& s = state_.words;
  const std::uint64_t result = std::rotl(s[0] + s[3], 23) + s[0];
  const std::uint64_t t = s[1] << 17U;
  s[2] ^= s[0];
  s[3] ^= s[1];
  s[1] ^= s[2];
  s[0] ^= s[3];
  s[2] ^= t;
  s[3] = std::rotl(s[3], 45);
  return result;
}

double Random::uniform() {
  return static_cast<double>(bits() >> 11U) * 0x1.0p-53;
}

std::uint64_t Random::below(std::uint64_t count) {
  // Rejection keeps it exactly even.
  const std::uint64_t limit = UINT64_MAX - UINT64_MAX % count;
  std::uint64_t x = bits();
  while (x >= limit) x = bits();
  return x % count;
}

double Random::normal() {
  if (state_.has_spare) {
    state_.has_spare = false;
    return state_.spare;
  }
  double u = 0;
  double v = 0;
  double s = 0;
  do {
    u = uniform(-1, 1);
    v = uniform(-1, 1);
    s = u * u + v * v;
  } while (s >= 1 || s == 0);
  const double k = std::sqrt(-2 * std::log(s) / s);
  state_.spare = v * k;
  state_.has_spare = true;
  return u * k;
}

Vec3 Random::normal_vector(double sigma) {
  const double x = normal();
  const double y = normal();
  const double z = normal();
  return sigma * Vec3(x, y, z);
}

double Random::log_normal(double sigma) {
  return std::exp(sigma * normal());
}

double Random::exponential(double mean) {
  return -mean * std::log1p(-uniform());
}

Vec3 Random::direction() {
  const double z = uniform(-1, 1);
  const double angle = uniform(0, 2 * std::numbers::pi);
  const double r = std::sqrt(1 - z * z);
  return {r * std::cos(angle), r * std::sin(angle), z};
}

Quat Random::rotation() {
  // Drawn one by one: compilers differ in the order in which they evaluate arguments.
  const double w = normal();
  const double x = normal();
  const double y = normal();
  const double z = normal();
  return canonical(Quat(w, x, y, z));
}

}  // namespace mien
