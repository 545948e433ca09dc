#include "mien/virtual/network.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

namespace mien::virt {
namespace {

constexpr double kMostDelayMs = 10'000;

Result<void> check(const NetworkSettings& settings) {
  const auto within = [](const char* name, double value, double least, double most) -> Result<void> {
    if (value >= least && value <= most) return {};
    return fail(ErrorCode::out_of_range, fmt::format("{} is {}, not {} to {}", name, value, least, most),
                "network settings");
  };
  MIEN_TRY(within("loss", settings.loss, 0, 1));
  MIEN_TRY(within("burst_share", settings.burst_share, 0, 0.99));
  MIEN_TRY(within("burst_length", settings.burst_length, 1, 1e6));
  MIEN_TRY(within("lag_ms", settings.lag_ms, 0, kMostDelayMs));
  MIEN_TRY(within("jitter_ms", settings.jitter_ms, 0, kMostDelayMs));
  MIEN_TRY(within("duplicated", settings.duplicated, 0, 1));
  MIEN_TRY(within("corrupted", settings.corrupted, 0, 1));
  return within("truncated", settings.truncated, 0, 1);
}

/// The way of one source's datagrams.
class Way {
 public:
  Way(const NetworkSettings& settings, const Random& random, std::uint16_t source)
      : settings_(settings),
        loss_(random.fork("loss", source)),
        burst_(random.fork("burst", source)),
        delay_(random.fork("delay", source)),
        duplicate_(random.fork("duplicate", source)),
        corrupt_(random.fork("corrupt", source)),
        truncate_(random.fork("truncate", source)) {
    shut_ = burst_.chance(settings.burst_share);
  }

  void send(const Datagram& datagram, std::vector<Datagram>& arrived) {
    const bool lost = loss_.chance(settings_.loss) || in_burst();
    const int copies = duplicate_.chance(settings_.duplicated) ? 2 : 1;
    for (int copy = 0; copy < copies; ++copy) {
      // Drawn for what is lost too, so that loss does not change what becomes of the others.
      Datagram out = datagram;
      out.time = arrival(datagram.time);
      damage(out.bytes);
      if (lost) continue;
      arrived.push_back(std::move(out));
    }
  }

 private:
  bool in_burst() {
    if (settings_.burst_share <= 0) return false;
    const bool shut = shut_;
    // Stays shut for burst_length datagrams on average, open for as many as make it burst_share of all.
    const double opens = 1 / settings_.burst_length;
    const double shuts = std::min(1.0, opens * settings_.burst_share / (1 - settings_.burst_share));
    shut_ = shut ? !burst_.chance(opens) : burst_.chance(shuts);
    return shut;
  }

  HostTime arrival(HostTime sent) {
    const double jitter_ms = settings_.jitter == NetworkSettings::Jitter::exponential
                                 ? delay_.exponential(settings_.jitter_ms)
                                 : delay_.uniform(0, 2 * settings_.jitter_ms);
    return sent + from_seconds(1e-3 * (settings_.lag_ms + jitter_ms));
  }

  void damage(std::vector<std::byte>& bytes) {
    const bool corrupt = corrupt_.chance(settings_.corrupted);
    const auto changes = 1 + corrupt_.below(4);
    for (std::uint64_t i = 0; i < changes; ++i) {
      const std::uint64_t place = corrupt_.bits();
      const auto flips = static_cast<std::byte>(1 + corrupt_.below(255));
      if (corrupt && !bytes.empty()) bytes[place % bytes.size()] ^= flips;
    }
    const bool truncate = truncate_.chance(settings_.truncated);
    const double kept = truncate_.uniform();
    if (truncate) bytes.resize(static_cast<std::size_t>(kept * static_cast<double>(bytes.size())));
  }

  const NetworkSettings& settings_;
  Random loss_;
  Random burst_;
  Random delay_;
  Random duplicate_;
  Random corrupt_;
  Random truncate_;
  bool shut_ = false;
};

}  // namespace

// (Not by stable_sort, whose buffer clang-19 calls deprecated.)
void sort_by_time(std::vector<Datagram>& datagrams) {
  std::vector<std::pair<HostTime, std::size_t>> order;
  order.reserve(datagrams.size());
  for (const Datagram& datagram : datagrams) order.emplace_back(datagram.time, order.size());
  std::ranges::sort(order);
  std::vector<Datagram> sorted;
  sorted.reserve(datagrams.size());
  for (const auto& [time, place] : order) sorted.push_back(std::move(datagrams[place]));
  datagrams = std::move(sorted);
}

Result<std::vector<Datagram>> deliver(std::span<const Datagram> sent, const NetworkSettings& settings,
                                      const Random& random) {
  MIEN_TRY(check(settings));
  std::map<std::uint16_t, Way> ways;
  std::vector<Datagram> arrived;
  arrived.reserve(sent.size());
  for (const Datagram& datagram : sent) {
    const auto way = ways.try_emplace(datagram.source, settings, random, datagram.source).first;
    way->second.send(datagram, arrived);
  }
  sort_by_time(arrived);
  return arrived;
}

}  // namespace mien::virt
