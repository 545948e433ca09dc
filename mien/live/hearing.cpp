#include <utility>  // Before Asio 1.74, which forgets it.

#include "mien/live/hearing.h"

#include "mien/live/intake.h"
#include "mien/live/page_messages.h"
#include "mien/live/page_server.h"

namespace mien::live {

Result<void> Hearing::open(std::vector<Feed> feeds, bool wanted, bool shut, Intake& intake) {
  wanted_ = wanted;
  shut_ = shut;
  return feeds_.open(std::move(feeds), wanted, intake);
}

Result<void> Hearing::microphone(std::uint64_t client, bool on, PageServer& page) {
  PageInlet* const inlet = feeds_.inlet();
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

void Hearing::take(std::uint64_t client, std::span<const std::byte> bytes) {
  if (PageInlet* const inlet = feeds_.inlet()) inlet->offer(client, bytes, PageInlet::Clock::now());
}

void Hearing::look(std::optional<bool> wanted, PageServer* page) {
  wanted_ = wanted.value_or(wanted_);
  feeds_.want(wanted_);
  feeds_.look_for_answers();
  const PageInlet* const inlet = feeds_.inlet();
  if (inlet == nullptr || page == nullptr || inlet->admitted() == 0) return;
  if (!wanted_ || !page->has(inlet->admitted())) release(*page, "");
}

void Hearing::release(PageServer& page, const std::string& why) {
  PageInlet& inlet = *feeds_.inlet();
  if (const std::uint64_t before = inlet.admitted(); before != 0) page.send(before, microphone_json(why));
  inlet.admit(0);
}

HearingState Hearing::state() const {
  HearingState out{.shut = shut_,
                   .trouble = feeds_.trouble(),
                   .handed_over = feeds_.handed_over(),
                   .browser = std::nullopt};
  if (const PageInlet* const inlet = feeds_.inlet())
    out.browser = HearingState::Browser{.heard = inlet->admitted() != 0, .refused = inlet->refused()};
  return out;
}

}  // namespace mien::live
