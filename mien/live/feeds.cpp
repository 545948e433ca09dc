#include <utility>  // Before Asio 1.74, which forgets it.

#include "mien/live/feeds.h"

#include <exception>

#include "mien/live/intake.h"

namespace mien::live {

Result<void> Feeds::open(std::vector<Feed> feeds, Intake& intake) {
  feeds_ = std::move(feeds);
  for (const Feed& feed : feeds_) {
    MIEN_TRY_ASSIGN(sources_.emplace_back(), intake.add_source(feed.name));
  }
  return {};
}

void Feeds::begin(const std::function<void(std::string kind, std::string text)>& tell) {
  for (std::size_t i = 0; i < feeds_.size(); ++i)
    threads_.emplace_back([this, &feed = feeds_[i], out = sources_[i], tell] {
      try {
        feed.run(*out, stop_);
        if (!stop_) tell("feed_over", feed.name + " is over");
      } catch (const std::exception& error) {
        tell("feed_failed", feed.name + " ended: " + error.what());
      }
    });
}

void Feeds::end() {
  stop_ = true;
  threads_.clear();  // Joined.
}

}  // namespace mien::live
