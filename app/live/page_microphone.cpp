#include "app/live/page_microphone.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "mien/speech/sound_block.h"

namespace mien::app {
namespace {

/// A browser's clock may run so much faster than the machine's: more than any that is not broken.
constexpr double kFastest = 1.002;
/// A message counts for so much sound at least, s: each costs time, however short it is.
constexpr double kLeastSound_s = 0.005;
constexpr auto kPageWait = std::chrono::milliseconds(50);
constexpr const char* kItsName = "the browser's microphone";
/// What to do where nothing better is known.
constexpr const char* kAgain = "press Stop and use it again, or load the page anew";

}  // namespace

PageSound::PageSound(std::uint64_t device, live::FeedPort& port, Clock::time_point now)
    : port_(port), heard_(kItsName, device, port, now), paid_(now), newest_(now) {}

bool PageSound::take(std::uint64_t client, std::span<const std::byte> bytes, Clock::time_point now) {
  const Result<speech::SoundMessage> message = speech::parse_message(bytes);
  if (!message) return refuse(client, message.error());
  bool anew = !stream_ || stream_->client != client || stream_->rate_hz != message->rate_hz ||
              (message->count == 0 && stream_->next != 0);
  if (!anew) {
    const double off_s =
        stream_->lateness.at(stream_->position_s(message->count + message->samples.size()), now);
    if (std::abs(off_s) <= kOff_s) {
      stream_->off_since.reset();
      if (message->count < stream_->next) return refuse(client, {.what = "it repeats what was heard"});
    } else {
      if (!stream_->off_since) stream_->off_since = now;
      if (now - *stream_->off_since < kPatience)
        return refuse(client,
                      {.what = off_s > 0 ? "it came more than a second late" : "it is ahead of its time"});
      anew = true;
    }
  }
  if (!pay(*message, now)) return refuse(client, {.what = "more sound than time passes"});
  if (anew)
    if (const auto begun = begin(client, *message, now); !begun) return refuse(client, begun.error());
  hear(*message, now);
  return true;
}

void PageSound::look(std::uint64_t admitted, Clock::time_point now) {
  if (admitted != admitted_) {
    admitted_ = admitted;
    newest_ = now;
    stream_.reset();
    troubled_ = false;
    heard_.over();
    return;
  }
  if (admitted == 0 || troubled_ || now - newest_ < kGone) return;
  troubled_ = true;
  const std::string why = fmt::format("nothing comes from {}; {}", kItsName, kAgain);
  port_.tell("microphone_lost", why);
  heard_.trouble(why);
}

bool PageSound::refuse(std::uint64_t client, Error why) {
  if (why.fix.empty()) why.fix = kAgain;
  const std::string text = fmt::format("{}: what it sent was refused, {}", kItsName, why.message());
  if (told_ != client) port_.tell("microphone_failed", text);
  told_ = client;
  troubled_ = true;
  heard_.trouble(text);
  return false;
}

bool PageSound::pay(const speech::SoundMessage& message, Clock::time_point now) {
  allowance_s_ =
      std::min(allowance_s_ + kFastest * std::chrono::duration<double>(now - paid_).count(), kOff_s);
  paid_ = now;
  const double cost_s =
      std::max(static_cast<double>(message.samples.size()) / message.rate_hz, kLeastSound_s);
  if (cost_s > allowance_s_) return false;
  allowance_s_ -= cost_s;
  return true;
}

Result<void> PageSound::begin(std::uint64_t client, const speech::SoundMessage& message,
                              Clock::time_point now) {
  MIEN_TRY(heard_.begin(message.rate_hz, now));
  stream_ = Stream{.client = client,
                   .rate_hz = message.rate_hz,
                   .first = message.count,
                   .next = message.count,
                   .lateness = Lateness(now),
                   .off_since = std::nullopt};
  return {};
}

void PageSound::hear(const speech::SoundMessage& message, Clock::time_point now) {
  if (message.count > stream_->next) heard_.skip(message.count - stream_->next, now);
  stream_->next = message.count + message.samples.size();
  stream_->lateness.follow(stream_->position_s(stream_->next), now);
  newest_ = now;
  if (std::exchange(troubled_, false)) heard_.trouble({});
  samples_.resize(message.samples.size());
  std::ranges::transform(message.samples, samples_.begin(),
                         [](std::int16_t s) { return static_cast<float>(s) / speech::kFullScale; });
  heard_.push(samples_, now);
}

live::Feed page_feed(std::uint64_t device) {
  auto inlet = std::make_shared<live::PageInlet>();
  const auto run = [inlet, device](live::FeedPort& port) {
    PageSound sound(device, port, PageSound::Clock::now());
    while (!port.stopped()) {
      sound.look(inlet->admitted(), PageSound::Clock::now());
      const auto message = inlet->front();
      if (!message) {
        inlet->wait(kPageWait);
        continue;
      }
      // Whoever was let in before, and what came before the switch, is heard no more.
      const bool asked = port.wanted() && message->client == inlet->admitted();
      if (!asked || !sound.take(message->client, message->bytes, message->arrival)) inlet->count_refused();
      inlet->release();
    }
  };
  return live::Feed{"microphone:page", run, inlet};
}

}  // namespace mien::app
