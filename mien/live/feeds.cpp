#include <utility>  // Before Asio 1.74, which forgets it.

#include "mien/live/feeds.h"

#include <algorithm>
#include <exception>

#include "mien/live/intake.h"

namespace mien::live {
namespace {

/// An answer is one for so long.
constexpr Duration kAnswered = std::chrono::seconds(1);

}  // namespace

Result<void> Feeds::open(std::vector<Feed> feeds, bool wanted, Intake& intake) {
  want(wanted);
  intake_ = &intake;
  feeds_ = std::move(feeds);
  for (const Feed& feed : feeds_) {
    MIEN_TRY_ASSIGN(sources_.emplace_back(), intake.add_source(feed.name));
    states_.emplace_back();
  }
  return {};
}

void Feeds::begin(FeedPort::Tell tell) {
  tell_ = std::move(tell);
  for (std::size_t i = 0; i < feeds_.size(); ++i)
    threads_.emplace_back([this, &feed = feeds_[i], source = sources_[i], &state = states_[i]] {
      FeedPort port(*source, stop_, wanted_, tell_, state);
      try {
        feed.run(port);
        if (!stop_) {
          state.set_over();
          tell_("feed_over", feed.name + " is over");
        }
      } catch (const std::exception& error) {
        const std::string why = feed.name + " ended: " + error.what();
        tell_("feed_failed", why);
        state.set_trouble(why);
      }
    });
}

void Feeds::look_for_answers() {
  for (FeedState& one : states_) {
    const std::string host = one.awaited();
    if (host.empty()) continue;
    boost::system::error_code code;
    const auto address = boost::asio::ip::make_address(host, code);
    one.set_answered(!code && intake_->hears(address, kAnswered));
  }
}

std::string Feeds::trouble() const {
  for (const FeedState& one : states_)
    if (std::string text = one.trouble(); !text.empty()) return text;
  return {};
}

std::vector<CameraStatus> Feeds::cameras() const {
  std::vector<CameraStatus> all;
  for (const FeedState& one : states_)
    if (auto camera = one.camera()) all.push_back(*std::move(camera));
  return all;
}

std::uint64_t Feeds::handed_over() const {
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < feeds_.size(); ++i) {
    if (!feeds_[i].heard) continue;
    const PayloadSource::Counts counts = sources_[i]->counts();
    // Of different moments: a datagram that is refused meanwhile may be in one and not in the other.
    const std::uint64_t refused = counts.too_long + counts.overrun;
    sum += counts.received - std::min(counts.received, refused);
  }
  return sum;
}

std::vector<std::string> Feeds::over() const {
  std::vector<std::string> sensors;
  for (std::size_t i = 0; i < feeds_.size(); ++i)
    if (!feeds_[i].sensor.empty() && states_[i].over()) sensors.push_back(feeds_[i].sensor);
  return sensors;
}

PageInlet* Feeds::inlet() const {
  for (const Feed& feed : feeds_)
    if (feed.inlet) return feed.inlet.get();
  return nullptr;
}

void Feeds::end() {
  stop_ = true;
  threads_.clear();  // Joined.
}

}  // namespace mien::live
