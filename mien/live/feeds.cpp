#include <utility>  // Before Asio 1.74, which forgets it.

#include "mien/live/feeds.h"

#include <exception>

#include "mien/live/intake.h"

namespace mien::live {

Result<void> Feeds::open(std::vector<Feed> feeds, bool wanted, Intake& intake) {
  want(wanted);
  feeds_ = std::move(feeds);
  for (const Feed& feed : feeds_) {
    MIEN_TRY_ASSIGN(sources_.emplace_back(), intake.add_source(feed.name));
  }
  return {};
}

void Feeds::begin(FeedPort::Tell tell) {
  tell_ = std::move(tell);
  for (std::size_t i = 0; i < feeds_.size(); ++i)
    threads_.emplace_back([this, &feed = feeds_[i], source = sources_[i]] {
      FeedPort port(*source, stop_, wanted_, tell_);
      try {
        feed.run(port);
        if (!stop_) tell_("feed_over", feed.name + " is over");
      } catch (const std::exception& error) {
        tell_("feed_failed", feed.name + " ended: " + error.what());
      }
    });
}

void Feeds::end() {
  stop_ = true;
  threads_.clear();  // Joined.
}

}  // namespace mien::live
