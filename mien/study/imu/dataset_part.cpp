#include "mien/study/imu/dataset_part.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "mien/core/nearest_word.h"
#include "mien/face/profile.h"

namespace mien::study {
namespace {

/// Of each row of `from`, `width` numbers for each chosen sensor, group by group of `sensors` sensors.
template <class T>
std::vector<T> chosen(const std::vector<T>& from, std::size_t sensors, std::size_t width,
                      std::span<const std::size_t> which) {
  std::vector<T> out;
  const std::size_t group = sensors * width;
  out.reserve(from.size() / std::max<std::size_t>(sensors, 1) * which.size());
  for (std::size_t begin = 0; begin + group <= from.size(); begin += group)
    for (const std::size_t s : which)
      out.insert(out.end(), from.begin() + static_cast<std::ptrdiff_t>(begin + s * width),
                 from.begin() + static_cast<std::ptrdiff_t>(begin + (s + 1) * width));
  return out;
}

}  // namespace

Result<Dataset> with_sensors(const Dataset& data, std::span<const std::string> names) {
  if (names.empty()) return fail(ErrorCode::bad_usage, "no sensor is left", "data set");
  std::vector<std::size_t> which;
  for (const std::string& name : names) {
    const auto found = std::ranges::find(data.sensors, name);
    if (found == data.sensors.end())
      return fail(ErrorCode::not_found,
                  fmt::format("the data set has no sensor {}{}", name, did_you_mean(name, data.sensors)),
                  "data set");
    which.push_back(static_cast<std::size_t>(found - data.sensors.begin()));
  }
  const std::size_t sensors = data.sensors.size();
  constexpr std::size_t kSlopes = 3 * face::kShapeCount;
  Dataset out;
  out.sensors.assign(names.begin(), names.end());
  out.standard_slopes = chosen(data.standard_slopes, sensors, kSlopes, which);
  for (const Sequence& sequence : data.sequences) {
    Sequence& part = out.sequences.emplace_back();
    part.performer = sequence.performer;
    part.lab = sequence.lab;
    part.from_take = sequence.from_take;
    part.frames = sequence.frames;
    part.values = chosen(sequence.values, sensors, 7, which);
    part.present = chosen(sequence.present, sensors, 1, which);
    part.slopes = chosen(sequence.slopes, sensors, kSlopes, which);
    part.weights = sequence.weights;
  }
  return out;
}

Dataset one_in_people(const Dataset& data, std::size_t one_in, std::size_t which) {
  Dataset out;
  out.sensors = data.sensors;
  out.standard_slopes = data.standard_slopes;
  for (const Sequence& sequence : data.sequences)
    if (sequence.performer % one_in == which % one_in) out.sequences.push_back(sequence);
  return out;
}

Result<TrainingData> put_together(TrainingData performed, TrainingData takes) {
  if (performed.train.sensors != takes.train.sensors || performed.train.sensors != takes.validation.sensors)
    return fail(ErrorCode::mismatch, "takes and virtual performers have different sensors", "data set");
  std::uint32_t next = 0;
  for (const Dataset* part : {&performed.train, &performed.validation})
    for (const Sequence& s : part->sequences) next = std::max(next, s.performer + 1);
  std::map<std::uint32_t, std::uint32_t> numbers;  // Whoever were in both parts would be so with one number.
  const auto add = [&](Dataset& from, Dataset& to) {
    for (Sequence& s : from.sequences) {
      const auto [number, fresh] = numbers.try_emplace(s.performer, next);
      if (fresh) ++next;
      s.performer = number->second;
      to.sequences.push_back(std::move(s));
    }
  };
  add(takes.train, performed.train);
  add(takes.validation, performed.validation);
  return performed;
}

}  // namespace mien::study
