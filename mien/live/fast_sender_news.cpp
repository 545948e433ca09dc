#include <utility>  // Before Asio 1.74, which forgets it.

#include "mien/live/fast_sender_news.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace mien::live {
namespace {

/// Rates are of so long.
constexpr Duration kStretch = std::chrono::seconds(1);
/// Of whom nothing was dropped for so long is slow enough.
constexpr Duration kOver = std::chrono::seconds(5);
/// So many senders are said in one sentence.
constexpr std::size_t kSeveralSenders = 3;

/// 11987 as 12000.
double three_digits(double rate_hz) {
  const double step = std::pow(10.0, std::floor(std::log10(std::max(rate_hz, 100.0))) - 2);
  return step * std::round(rate_hz / step);
}

bool quiet_is_over(std::optional<HostTime> said, HostTime now) {
  return !said || now - *said >= FastSenderNews::kQuiet;
}

}  // namespace

void FastSenderNews::measure(HostTime now, const Intake::FastSender& one) {
  const auto [place, is_new] = senders_.try_emplace(one.peer);
  Sender& sender = place->second;
  sender.here = true;
  if (is_new) sender.source = one.source;
  if (!is_new && now - sender.since < kStretch) return;
  if (!is_new && one.dropped > sender.dropped) {
    const double rate_hz = static_cast<double>(one.sent - sender.sent) / to_seconds(now - sender.since);
    if (rate_hz > Intake::kMaxRatePerPeer) {
      sender.rate_hz = rate_hz;
      sender.newest = now;
    }
  }
  sender.since = now;
  sender.sent = one.sent;
  sender.dropped = one.dropped;
}

Sentence FastSenderNews::begun(std::span<Sender* const> senders) {
  const Sender& first = *senders.front();
  const std::string who =
      senders.size() == 1
          ? fmt::format("{} sends {:.0f} packets a second", first.source, three_digits(first.rate_hz))
          : fmt::format("{} and {} more send too many packets, that one {:.0f} a second", first.source,
                        senders.size() - 1, three_digits(first.rate_hz));
  return {"packets_lost",
          fmt::format("{}; beyond {:.0f} they are dropped, and what they say is lost: lower the rate of what "
                      "sends there, or stop it if it is no device of yours",
                      who, Intake::kMaxRatePerPeer)};
}

std::vector<Sentence> FastSenderNews::tell(HostTime now, std::span<const Intake::FastSender> senders) {
  for (auto& [peer, sender] : senders_) sender.here = false;
  for (const Intake::FastSender& one : senders) measure(now, one);
  std::vector<Sender*> fast;
  for (auto at = senders_.begin(); at != senders_.end();) {
    auto& [peer, sender] = *at;
    const bool over = !sender.here || (sender.newest && now - *sender.newest >= kOver);
    if (over && std::exchange(sender.told, false)) over_.emplace_back(peer, sender.source);
    if (over) sender.newest.reset();
    if (sender.newest && !sender.told) {
      // That it was over has not been said: then it is not.
      sender.told = std::erase_if(over_, [&](const auto& one) { return one.first == at->first; }) > 0;
      if (!sender.told) fast.push_back(&sender);
    }
    at = sender.here ? std::next(at) : senders_.erase(at);
  }
  std::vector<Sentence> out;
  if (!fast.empty() && quiet_is_over(said_begun_, now)) {
    said_begun_ = now;
    for (Sender* const sender : fast) sender->told = true;
    if (fast.size() >= kSeveralSenders)
      out.push_back(begun(fast));
    else
      for (Sender* const& sender : fast) out.push_back(begun(std::span(&sender, 1)));
  }
  if (!over_.empty() && quiet_is_over(said_over_, now)) {
    said_over_ = now;
    const std::string end =
        fmt::format("no more than {:.0f} packets a second again", Intake::kMaxRatePerPeer);
    if (over_.size() >= kSeveralSenders)
      out.push_back({"packets_taken",
                     fmt::format("{} and {} more send {}", over_.front().second, over_.size() - 1, end)});
    else
      for (const auto& [peer, source] : over_)
        out.push_back({"packets_taken", fmt::format("{} sends {}", source, end)});
    over_.clear();
  }
  return out;
}

}  // namespace mien::live
