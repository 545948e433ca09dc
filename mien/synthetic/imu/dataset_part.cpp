#include "mien/synthetic/imu/dataset_part.h"

#include <algorithm>
#include <map>
#include <utility>

namespace mien::synthetic {

dataset::Dataset one_in_people(const dataset::Dataset& data, std::size_t one_in, std::size_t which) {
  dataset::Dataset out;
  out.sensors = data.sensors;
  out.standard_slopes = data.standard_slopes;
  for (const dataset::Sequence& sequence : data.sequences)
    if (sequence.performer % one_in == which % one_in) out.sequences.push_back(sequence);
  return out;
}

Result<dataset::TrainingData> put_together(dataset::TrainingData performed, dataset::TrainingData takes) {
  if (performed.train.sensors != takes.train.sensors || performed.train.sensors != takes.validation.sensors)
    return fail(ErrorCode::mismatch, "takes and virtual performers have different sensors", "data set");
  std::uint32_t next = 0;
  for (const dataset::Dataset* part : {&performed.train, &performed.validation})
    for (const dataset::Sequence& s : part->sequences) next = std::max(next, s.performer + 1);
  std::map<std::uint32_t, std::uint32_t> numbers;  // Whoever were in both parts would be so with one number.
  const auto add = [&](dataset::Dataset& from, dataset::Dataset& to) {
    for (dataset::Sequence& s : from.sequences) {
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

}  // namespace mien::synthetic
