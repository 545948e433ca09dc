#include <utility>  // Before Asio 1.74, which forgets it.

#include "mien/live/feeds.h"

#include <algorithm>
#include <exception>

#include "mien/live/intake.h"
#include "mien/live/page_messages.h"
#include "mien/live/page_server.h"

namespace mien::live {
namespace {

/// An answer is one for so long.
constexpr Duration kAnswered = std::chrono::seconds(1);

}  // namespace

std::uint64_t FeedPort::handed_over() const {
  const PayloadSource::Counts counts = source_.counts();
  // Of different moments: a datagram that is refused meanwhile may be in one and not in the other.
  return counts.received - std::min(counts.received, counts.too_long + counts.overrun);
}

Result<void> Feeds::open(std::vector<Feed> feeds, bool wanted, bool shut, Intake& intake) {
  wanted_ = wanted;
  shut_ = shut;
  intake_ = &intake;
  for (Feed& feed : feeds) {
    MIEN_TRY_ASSIGN(PayloadSource* const source, intake.add_source(feed.name));
    running_.emplace_back(std::move(feed), *source, *this);
  }
  return {};
}

void Feeds::begin(FeedPort::Tell tell) {
  tell_ = std::move(tell);
  for (Running& one : running_) threads_.emplace_back([this, &one] { run(one); });
}

void Feeds::run(Running& one) {
  try {
    one.feed.run(one.port);
    if (stop_) return;
    one.over = true;
    tell_("feed_over", one.feed.name + " is over");
  } catch (const std::exception& error) {
    const std::string why = one.feed.name + " ended: " + error.what();
    tell_("feed_failed", why);
    one.port.trouble(why);
  }
}

void Feeds::end() {
  stop_ = true;
  threads_.clear();  // Joined.
}

Result<void> Feeds::microphone(std::uint64_t client, bool on, PageServer& page) {
  PageInlet* const inlet = this->inlet();
  if (inlet == nullptr)
    return fail(ErrorCode::unsupported,
                shut_ ? "the session was started with every microphone shut (--no-audio)"
                      : "the session hears no browser's microphone",
                "microphone", "start it with --audio page");
  if (!on) {
    if (inlet->admitted() == client) inlet->admit(0);
    return {};
  }
  if (!wanted_)
    return fail(ErrorCode::bad_usage, "the voice is switched off", "microphone", "switch it on first");
  if (inlet->admitted() != client) release(page, "Another browser's microphone is heard instead.");
  inlet->admit(client);
  return {};
}

void Feeds::take(std::uint64_t client, std::span<const std::byte> bytes) {
  if (PageInlet* const inlet = this->inlet()) inlet->offer(client, bytes, PageInlet::Clock::now());
}

void Feeds::look(std::optional<bool> wanted, PageServer* page) {
  wanted_ = wanted.value_or(wanted_);
  for (Running& one : running_) {
    const std::string host = one.port.state().awaited;
    if (host.empty()) continue;
    boost::system::error_code code;
    const auto address = boost::asio::ip::make_address(host, code);
    one.port.set_answered(!code && intake_->hears(address, kAnswered));
  }
  const PageInlet* const inlet = this->inlet();
  if (inlet == nullptr || page == nullptr || inlet->admitted() == 0) return;
  if (!wanted_ || !page->has(inlet->admitted())) release(*page, "");
}

void Feeds::release(PageServer& page, const std::string& why) {
  PageInlet& inlet = *this->inlet();
  if (const std::uint64_t before = inlet.admitted(); before != 0) page.send(before, microphone_json(why));
  inlet.admit(0);
}

HearingState Feeds::state() const {
  HearingState out{.shut = shut_};
  for (const Running& one : running_) {
    if (out.trouble.empty()) out.trouble = one.port.state().trouble;
    if (one.feed.heard) out.handed_over += one.port.handed_over();
  }
  if (const PageInlet* const inlet = this->inlet())
    out.browser = HearingState::Browser{.heard = inlet->admitted() != 0, .refused = inlet->refused()};
  return out;
}

std::vector<CameraStatus> Feeds::cameras() const {
  std::vector<CameraStatus> all;
  for (const Running& one : running_)
    if (auto camera = one.port.state().camera) all.push_back(*std::move(camera));
  return all;
}

std::vector<std::string> Feeds::over() const {
  std::vector<std::string> sensors;
  for (const Running& one : running_)
    if (!one.feed.sensor.empty() && one.over) sensors.push_back(one.feed.sensor);
  return sensors;
}

PageInlet* Feeds::inlet() const {
  for (const Running& one : running_)
    if (one.feed.inlet) return one.feed.inlet.get();
  return nullptr;
}

}  // namespace mien::live
