#include "mien/session/prompter.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace mien::session {
namespace {

const char* const kPrompts = "prompts";

/// In its first second what is shown has hardly begun: who asks for the last one again means the one before.
constexpr Duration kHardlyBegun = std::chrono::seconds(1);
/// The least time in which a text is spoken.
constexpr Duration kLeastSpoken = std::chrono::milliseconds(500);

/// What waits to be begun together; empty: it does not wait.
std::string block_key(const Prompt& prompt) {
  // No name of a block has a control character.
  return prompt.attempt > 1 && !prompt.block.empty() ? "\n" : prompt.block;
}

}  // namespace

Result<void> Prompter::check_asking() const {
  if (now_ < prompts_.size()) return {};
  return fail(ErrorCode::not_found, "no pose is being asked for", kPrompts,
              "mien record --prompts asks for some");
}

bool Prompter::waits() const {
  if (now_ >= prompts_.size()) return false;
  const std::string key = block_key(prompts_[now_]);
  return !key.empty() && key != begun_;
}

void Prompter::restart(Duration lead_in) {
  begin_.reset();
  lead_in_ = lead_in;
  goes_on_ = false;
  spoken_ = {};
  silence_.reset();
}

Result<void> Prompter::add(Prompt prompt) {
  MIEN_TRY(check_prompt(prompt, kPrompts));
  if (prompts_.size() >= kMaxPrompts)
    return fail(ErrorCode::out_of_range, fmt::format("{} poses are enough for one session", kMaxPrompts),
                kPrompts, "start a new one");
  if (now_ == prompts_.size()) {  // The first, or the first after a rest: another recording's.
    prompts_.clear();
    accepted_.clear();
    now_ = 0;
    restart(kLeadIn);
    paused_ = false;
    begun_.clear();
  }
  prompts_.push_back(std::move(prompt));
  return {};
}

Result<void> Prompter::skip() {
  MIEN_TRY(check_asking());
  ++now_;
  restart(paused_ ? lead_in_ : Duration::zero());
  return {};
}

Result<void> Prompter::pause(bool paused) {
  MIEN_TRY(check_asking());
  if (paused == paused_) return {};
  paused_ = paused;
  restart(kLeadIn);
  return {};
}

Result<void> Prompter::stop() {
  MIEN_TRY(check_asking());
  now_ = prompts_.size();
  restart(kLeadIn);
  paused_ = false;
  return {};
}

Result<void> Prompter::begin_block() {
  MIEN_TRY(check_asking());
  if (!waits()) return fail(ErrorCode::bad_usage, "no block waits to be begun", kPrompts);
  begun_ = block_key(prompts_[now_]);
  paused_ = false;
  restart(kLeadIn);
  return {};
}

Result<void> Prompter::go_on() {
  MIEN_TRY(check_asking());
  if (!is_running() || !prompts_[now_].own_pace)
    return fail(ErrorCode::bad_usage, "nothing is shown at your own pace", kPrompts,
                "skip goes to the next one");
  goes_on_ = true;
  return {};
}

Result<void> Prompter::repeat() {
  MIEN_TRY(check_asking());
  const bool begun = is_running() && newest_ - *begin_ >= kHardlyBegun;
  if (!begun && now_ > 0 && block_key(prompts_[now_ - 1]) == block_key(prompts_[now_])) --now_;
  restart(paused_ ? lead_in_ : kHardlyBegun);
  return {};
}

bool Prompter::ask_again(const Prompt& prompt) {
  const auto same = [&prompt](const Prompt& p) { return p.name == prompt.name && p.block == prompt.block; };
  const auto first = prompts_.begin() + static_cast<std::ptrdiff_t>(now_);
  if (prompt.attempt >= kMaxAttempts || prompts_.size() >= kMaxPrompts ||
      std::any_of(first, prompts_.end(), same) || std::ranges::any_of(accepted_, same))
    return false;
  Prompt& again = prompts_.emplace_back(prompt);
  ++again.attempt;
  return true;
}

void Prompter::accept(const Prompt& prompt) {
  accepted_.push_back(prompt);
  const auto first = prompts_.begin() + static_cast<std::ptrdiff_t>(now_);
  prompts_.erase(std::remove_if(first, prompts_.end(),
                                [&prompt](const Prompt& p) {
                                  return p.attempt > 1 && p.name == prompt.name && p.block == prompt.block;
                                }),
                 prompts_.end());
}

bool Prompter::is_spoken(DeviceTime frame, bool speaks) {
  if (!by_voice_ || prompts_[now_].text.empty()) return false;
  if (speaks) {
    spoken_ += frame_offset(1);
    silence_.reset();
    return false;
  }
  if (!silence_) silence_ = frame;
  const Duration usual = from_seconds(kSpokenShare * (prompts_[now_].seconds - 1));
  return spoken_ >= std::max(usual, kLeastSpoken) && frame - *silence_ >= kSilent;
}

std::optional<Prompter::Shown> Prompter::at(DeviceTime frame, bool speaks) {
  newest_ = frame;
  if (paused_ || now_ >= prompts_.size() || waits()) return std::nullopt;
  if (!begin_) begin_ = frame + lead_in_;
  if (frame < *begin_) return std::nullopt;
  const Prompt& prompt = prompts_[now_];
  DeviceTime end = *begin_ + from_seconds(prompt.seconds);
  if (prompt.own_pace) {
    if (!goes_on_ && !is_spoken(frame, speaks)) {
      if (frame - *begin_ >= kLongest) static_cast<void>(pause(true));
      return std::nullopt;
    }
    end = frame;
  }
  if (frame < end) return std::nullopt;
  Shown shown{prompt, *begin_, end};
  ++now_;
  restart({});
  // Without a gap and without drift; where frames are missing, what could not be shown waits.
  if (frame - end < frame_offset(1)) begin_ = end;
  if (waits()) begin_.reset();
  return shown;
}

Prompter::Place Prompter::place(DeviceTime frame) const {
  Place out;
  out.of = prompts_.size();
  if (prompts_.empty()) return out;
  out.number = std::min(now_ + 1, prompts_.size());
  if (now_ == prompts_.size()) {
    out.state = State::over;
    return out;
  }
  out.prompt = &prompts_[now_];
  if (now_ + 1 < prompts_.size()) out.next = &prompts_[now_ + 1];
  const Duration length = from_seconds(out.prompt->seconds);
  const Duration passed = begin_ ? frame - *begin_ : -lead_in_;
  out.state = paused_                     ? State::paused
              : waits()                   ? State::block
              : passed < Duration::zero() ? State::ready
                                          : State::running;
  out.begin = begin_.value_or(frame);
  out.progress = std::clamp(to_seconds(passed) / out.prompt->seconds, 0.0, 1.0);
  out.remaining = std::max(passed < Duration::zero() ? -passed : length - passed, Duration::zero());
  out.left = passed < Duration::zero() ? length - passed : out.remaining;
  for (std::size_t i = now_ + 1; i < prompts_.size(); ++i) {
    out.left += from_seconds(prompts_[i].seconds);
    if (prompts_[i].attempt > 1) ++out.again;
  }
  return out;
}

}  // namespace mien::session
