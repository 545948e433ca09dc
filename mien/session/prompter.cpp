#include "mien/session/prompter.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace mien::session {
namespace {

const char* const kPrompts = "prompts";

}  // namespace

Result<void> Prompter::check_asking() const {
  if (now_ < prompts_.size()) return {};
  return fail(ErrorCode::not_found, "no pose is being asked for", kPrompts,
              "mien record --prompts asks for some");
}

Result<void> Prompter::add(Prompt prompt) {
  MIEN_TRY(check_prompt(prompt, kPrompts));
  if (prompts_.size() >= kMaxPrompts)
    return fail(ErrorCode::out_of_range, fmt::format("{} poses are enough for one session", kMaxPrompts),
                kPrompts, "start a new one");
  if (now_ == prompts_.size()) {  // The first, or the first after a rest.
    begin_.reset();
    paused_ = false;
    lead_in_ = kLeadIn;
  }
  prompts_.push_back(std::move(prompt));
  return {};
}

Result<void> Prompter::skip() {
  MIEN_TRY(check_asking());
  ++now_;
  begin_.reset();
  if (!paused_) lead_in_ = {};
  return {};
}

Result<void> Prompter::pause(bool paused) {
  MIEN_TRY(check_asking());
  if (paused == paused_) return {};
  paused_ = paused;
  begin_.reset();
  lead_in_ = kLeadIn;
  return {};
}

Result<void> Prompter::stop() {
  MIEN_TRY(check_asking());
  now_ = prompts_.size();
  begin_.reset();
  paused_ = false;
  return {};
}

std::optional<take::Event> Prompter::at(DeviceTime frame) {
  if (paused_ || now_ >= prompts_.size()) return std::nullopt;
  if (!begin_) begin_ = frame + lead_in_;
  const DeviceTime end = *begin_ + from_seconds(prompts_[now_].seconds);
  if (frame < end) return std::nullopt;
  take::Event event{"prompt", *begin_, end, prompt_event_json(prompts_[now_])};
  ++now_;
  // Without a gap and without drift; where frames are missing, what could not be shown waits.
  begin_ = frame - end < frame_offset(1) ? std::optional(end) : std::nullopt;
  lead_in_ = {};
  return event;
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
  out.state = paused_ ? State::paused : passed < Duration::zero() ? State::ready : State::running;
  out.progress = std::clamp(to_seconds(passed) / out.prompt->seconds, 0.0, 1.0);
  out.remaining = std::max(passed < Duration::zero() ? -passed : length - passed, Duration::zero());
  out.left = passed < Duration::zero() ? length - passed : out.remaining;
  for (std::size_t i = now_ + 1; i < prompts_.size(); ++i) out.left += from_seconds(prompts_[i].seconds);
  return out;
}

}  // namespace mien::session
