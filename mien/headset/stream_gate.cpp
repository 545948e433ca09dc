#include "mien/headset/stream_gate.h"

#include <algorithm>
#include <tuple>

#include "mien/headset/jpeg_gate.h"

namespace mien::headset {

bool StreamGate::passes(std::span<const std::byte> jpeg) {
  const auto header = check_jpeg(jpeg);
  if (header) return true;
  ++faults_[static_cast<std::size_t>(header.error())];
  ++refused_;
  return false;
}

sensor::StreamCounts StreamGate::counts(const sensor::StreamCounts& found) const {
  sensor::StreamCounts counts = found;
  counts.whole -= refused_;
  counts.refused = refused_;
  return counts;
}

std::vector<sensor::Refusal> StreamGate::refusals() const {
  std::vector<sensor::Refusal> all;
  for (std::size_t i = 0; i < faults_.size(); ++i)
    if (faults_[i] > 0) all.push_back({name_of(static_cast<PictureFault>(i)), faults_[i]});
  // The most frequent first, those of one count by their names.
  std::ranges::sort(all, [](const sensor::Refusal& a, const sensor::Refusal& b) {
    return std::tie(b.count, a.why) < std::tie(a.count, b.why);
  });
  return all;
}

}  // namespace mien::headset
