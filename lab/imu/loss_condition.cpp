#include "lab/imu/loss_condition.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <span>

#include "mien/core/draw_first.h"

namespace mien::lab {
namespace {

constexpr double kBurstLength = 10;       // Packets: a sixth of a second.
constexpr double kDisorderJitterMs = 20;  // Even, up to twice it; packets are 17 ms apart.
constexpr double kClockStepUs = 500;
constexpr double kClockStepEveryS = 10;
constexpr double kForever = std::numeric_limits<double>::infinity();

/// The face sensors in a random order: those that are in trouble first, so that three silent sensors are the
/// two and one more.
std::vector<std::uint16_t> drawn_sensors(const sensor::Rig& rig, Random random) {
  std::vector<std::uint16_t> sensors = rig.face_sensors();
  draw_first(std::span(sensors), sensors.size(), random);
  return sensors;
}

}  // namespace

std::string LossCondition::name() const {
  switch (fault) {
    case Fault::none:
      return "clean";
    case Fault::loss:
      return fmt::format("{:g} % lost", amount);
    case Fault::bursts:
      return fmt::format("{:g} % lost in bursts", amount);
    case Fault::jitter:
      return fmt::format("jitter {:g} ms", amount);
    case Fault::even_jitter:
      return fmt::format("jitter 0 to {:g} ms", amount);
    case Fault::lag:
      return fmt::format("lag {:g} ms", amount);
    case Fault::disorder:
      return fmt::format("{:g} % twice, out of order", amount);
    case Fault::clock_drift:
      return fmt::format("clocks {:g} ppm off, stepped", amount);
    case Fault::restart:
      return "one restarts half-way";
    case Fault::shared_id:
      return "two with one id, nobody chooses";
    case Fault::sensor_silent:
      return "without " + sensor;
    case Fault::sensors_silent:
      return fmt::format("without {:g} at once", amount);
    case Fault::head_silent:
      return fmt::format("head's silent for {:g} s", amount);
    case Fault::corrupted:
      return fmt::format("{:g} % corrupted", amount);
    case Fault::truncated:
      return fmt::format("{:g} % cut short", amount);
    case Fault::frozen:
      return fmt::format("{:g} frozen", amount);
    case Fault::all_silent:
      return fmt::format("all silent for {:g} s", amount);
  }
  return {};
}

std::vector<LossCondition> loss_conditions(const sensor::Rig& rig) {
  std::vector<LossCondition> out;
  for (const double percent : {2.0, 5.0, 10.0, 20.0}) out.push_back({Fault::loss, percent, {}});
  for (const double percent : {2.0, 5.0, 10.0, 20.0}) out.push_back({Fault::bursts, percent, {}});
  for (const double ms : {20.0, 50.0, 100.0}) out.push_back({Fault::jitter, ms, {}});
  out.push_back({Fault::even_jitter, 100, {}});
  out.push_back({Fault::lag, 100, {}});
  out.push_back({Fault::disorder, 20, {}});
  out.push_back({Fault::clock_drift, 50, {}});
  const std::vector<std::string> sensors = rig.face_sensor_names();
  if (!sensors.empty()) out.push_back({Fault::restart, 0, {}});
  if (sensors.size() > 1) out.push_back({Fault::shared_id, 0, {}});
  if (rig.head_sensor()) out.push_back({Fault::head_silent, 2, {}});
  for (const std::string& sensor : sensors) out.push_back({Fault::sensor_silent, 0, sensor});
  for (const double count : {2.0, 3.0})
    if (static_cast<double>(sensors.size()) > count) out.push_back({Fault::sensors_silent, count, {}});
  return out;
}

Result<Impairment> impairment(const LossCondition& condition, const sensor::Rig& rig, double begin_s,
                              double end_s, const Random& random) {
  const std::vector<std::uint16_t> drawn = drawn_sensors(rig, random.fork("sensors"));
  const double middle_s = 0.5 * (begin_s + end_s);
  const std::size_t needed = condition.fault == Fault::restart     ? 1
                             : condition.fault == Fault::shared_id ? 2
                             : condition.fault == Fault::sensors_silent || condition.fault == Fault::frozen
                                 ? std::max(0.0, condition.amount)
                                 : 0;
  if (needed > drawn.size())
    return fail(ErrorCode::not_found, "the rig has too few face sensors for: " + condition.name(), rig.name);
  Impairment out;
  switch (condition.fault) {
    case Fault::none:
      break;
    case Fault::loss:
      out.network.loss = 0.01 * condition.amount;
      break;
    case Fault::bursts:
      out.network.burst_share = 0.01 * condition.amount;
      out.network.burst_length = kBurstLength;
      break;
    case Fault::jitter:
      out.network.jitter_ms = condition.amount;
      break;
    case Fault::even_jitter:
      out.network.jitter_ms = 0.5 * condition.amount;
      out.network.jitter = virt::NetworkSettings::Jitter::uniform;
      break;
    case Fault::lag:
      out.network.lag_ms = condition.amount;
      break;
    case Fault::disorder:
      out.network.duplicated = 0.01 * condition.amount;
      out.network.jitter_ms = kDisorderJitterMs;
      out.network.jitter = virt::NetworkSettings::Jitter::uniform;
      break;
    case Fault::clock_drift:
      for (std::size_t s = 0; s < rig.sensors.size(); ++s) {
        Random clock = random.fork("clock", s);
        const double fast = clock.chance(0.5) ? 1 : -1;
        const double ahead = clock.chance(0.5) ? 1 : -1;
        out.troubles.clocks.push_back(
            {static_cast<std::uint16_t>(s), fast * condition.amount, ahead * kClockStepUs, kClockStepEveryS});
      }
      break;
    case Fault::restart:
      out.troubles.restarts.push_back({.sensor = drawn[0], .at_s = middle_s});
      break;
    case Fault::shared_id:
      out.troubles.shared_ids.push_back({.sensor = drawn[0], .as = drawn[1]});
      break;
    case Fault::sensor_silent: {
      const auto sensor = rig.find(condition.sensor);
      if (!sensor) return fail(ErrorCode::not_found, "the rig has no sensor " + condition.sensor, rig.name);
      out.troubles.silences.push_back({*sensor, 0, kForever});
      break;
    }
    case Fault::sensors_silent:
      for (std::size_t i = 0; i < needed; ++i) out.troubles.silences.push_back({drawn[i], 0, kForever});
      break;
    case Fault::head_silent: {
      const auto sensor = rig.head_sensor();
      if (!sensor) return fail(ErrorCode::not_found, "the rig has no sensor for the head", rig.name);
      out.troubles.silences.push_back({*sensor, middle_s, middle_s + condition.amount});
      break;
    }
    case Fault::corrupted:
      out.network.corrupted = 0.01 * condition.amount;
      break;
    case Fault::truncated:
      out.network.truncated = 0.01 * condition.amount;
      break;
    case Fault::frozen:
      for (std::size_t i = 0; i < needed; ++i) out.troubles.frozen.push_back({drawn[i], begin_s, end_s});
      break;
    case Fault::all_silent:
      out.troubles.silences.push_back({std::nullopt, middle_s, middle_s + condition.amount});
      break;
  }
  return out;
}

}  // namespace mien::lab
