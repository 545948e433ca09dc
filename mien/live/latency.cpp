#include "mien/live/latency.h"

#include <algorithm>
#include <cmath>

namespace mien::live {
namespace {

constexpr double kLeast_ns = 100;
const double kLogStep = std::log(1.03);

}  // namespace

void Latencies::add(Duration took) {
  const double ns = std::max(kLeast_ns, static_cast<double>(took.count()));
  const auto bin = static_cast<std::size_t>(std::log(ns / kLeast_ns) / kLogStep);
  ++bins_[std::min(bin, kBins - 1)];
  ++count_;
  largest_ = std::max(largest_, took);
}

Duration Latencies::percentile(double share) const {
  if (count_ == 0) return {};
  const auto wanted = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(count_)));
  std::uint64_t seen = 0;
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    seen += bins_[bin];
    if (seen >= std::max<std::uint64_t>(wanted, 1)) {
      if (bin == kBins - 1) return largest_;  // It has no upper end: from a third of a second on.
      const double ns = kLeast_ns * std::exp(kLogStep * (static_cast<double>(bin) + 1));
      return std::min(largest_, Duration(static_cast<std::int64_t>(ns)));
    }
  }
  return largest_;
}

Latencies& Latencies::operator+=(const Latencies& other) {
  for (std::size_t bin = 0; bin < kBins; ++bin) bins_[bin] += other.bins_[bin];
  count_ += other.count_;
  largest_ = std::max(largest_, other.largest_);
  return *this;
}

}  // namespace mien::live
