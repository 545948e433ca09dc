#include "mien/sink/vrchat.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <numbers>

#include "mien/core/excerpt.h"
#include "mien/sink/osc_bundles.h"

namespace mien::sink {
namespace {

constexpr float kThreshold = 0.001F;
constexpr std::int64_t kFullEvery = 60;  // Frames: a second.
constexpr std::string_view kParameterPath = "/avatar/parameters/";
constexpr std::string_view kVersion = "v2/";

std::optional<std::size_t> parameter_index(std::string_view name) {
  const auto all = unified_parameters();
  const auto found = std::ranges::find(all, name, &UnifiedParameter::name);
  if (found == all.end()) return std::nullopt;
  return static_cast<std::size_t>(found - all.begin());
}

/// EyeLeftX, EyeY and the like.
bool is_gaze(std::size_t parameter) {
  const std::string_view name = unified_parameters()[parameter].name;
  return name.starts_with("Eye") && (name.ends_with('X') || name.ends_with('Y'));
}

/// "JawOpen4" is bit 2 of JawOpen, "JawXNegative" its sign.
struct BinaryName {
  std::size_t parameter = 0;
  int bit = -1;  ///< -1: the sign.
};
std::optional<BinaryName> binary_name(std::string_view name) {
  constexpr std::string_view kNegative = "Negative";
  if (name.ends_with(kNegative)) {
    const auto parameter = parameter_index(name.substr(0, name.size() - kNegative.size()));
    if (!parameter) return std::nullopt;
    return BinaryName{*parameter, -1};
  }
  const std::size_t last = name.find_last_not_of("0123456789");
  if (last == std::string_view::npos || last + 1 == name.size()) return std::nullopt;
  const std::string_view digits = name.substr(last + 1);
  unsigned step = 0;
  const auto [end, code] = std::from_chars(digits.data(), digits.data() + digits.size(), step);
  if (code != std::errc{} || digits.front() == '0' || !std::has_single_bit(step) ||
      step >= (1U << kMaxBinaryBits))
    return std::nullopt;
  const auto parameter = parameter_index(name.substr(0, last + 1));
  if (!parameter) return std::nullopt;
  return BinaryName{*parameter, std::countr_zero(step)};
}

}  // namespace

bool binary_bit(float value, int bit, int bits, bool has_negative) {
  if (value < 0 && !has_negative) return false;
  const float size = std::abs(value);
  if (size > 0.99999F) return true;
  return ((static_cast<unsigned>(size * static_cast<float>(1U << static_cast<unsigned>(bits))) >>
           static_cast<unsigned>(bit)) &
          1U) != 0;
}

void VrchatEncoder::add_native_eyes(bool directions, bool closed) {
  if (directions)
    channels_.push_back(
        {.address = "/tracking/eye/LeftRightPitchYaw", .source = Source::eyes_direction, .form = Form::four});
  if (closed)
    channels_.push_back({.address = "/tracking/eye/EyesClosedAmount", .source = Source::eyes_closed});
}

Result<VrchatEncoder> VrchatEncoder::make(const VrchatOptions& options) {
  if (options.binary_bits < 0 || options.binary_bits > kMaxBinaryBits)
    return fail(ErrorCode::out_of_range, fmt::format("a binary parameter has 0 to {} bits", kMaxBinaryBits),
                "vrchat");
  if (options.prefix.size() > 100 || options.prefix.find_first_of(" #*,?[]{}") != std::string::npos)
    return fail(ErrorCode::malformed, fmt::format("'{}' is no part of an OSC address", options.prefix),
                "vrchat", "write prefix=FT/");
  VrchatEncoder encoder;
  const std::string front = std::string(kParameterPath) + options.prefix;
  const auto all = unified_parameters();
  encoder.values_.resize(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    const std::string address = fmt::format("{}{}{}", front, kVersion, all[i].name);
    encoder.channels_.push_back({.address = address, .parameter = i});
    for (int bit = 0; bit < options.binary_bits; ++bit)
      encoder.channels_.push_back({.address = fmt::format("{}{}", address, 1 << bit),
                                   .form = Form::bit,
                                   .parameter = i,
                                   .bit = bit,
                                   .bits = options.binary_bits,
                                   .has_negative = true});
    if (options.binary_bits > 0)
      encoder.channels_.push_back({.address = address + "Negative", .form = Form::negative, .parameter = i});
  }
  const auto state = [&](const char* name, Source source) {
    encoder.channels_.push_back({.address = front + name, .source = source, .form = Form::truth});
  };
  state("EyeTrackingActive", Source::eye_tracking);
  state("ExpressionTrackingActive", Source::face_tracking);
  state("LipTrackingActive", Source::face_tracking);
  encoder.add_native_eyes(options.native_eyes, options.native_eyes);
  return encoder;
}

Result<VrchatEncoder> VrchatEncoder::make(const VrchatOptions& options, const VrchatAvatar& avatar) {
  VrchatEncoder encoder;
  const auto all = unified_parameters();
  encoder.values_.resize(all.size());
  bool eyes_turn = false;
  bool eyes_close = false;
  // How many bits the avatar has for a parameter under one prefix is known only when all have been seen.
  std::vector<std::string> binary_group;  // One a channel: the address before its digits, or empty.
  for (const VrchatAvatar::Parameter& declared : avatar.parameters) {
    Channel channel{.address = declared.address};
    std::string group;
    const std::string_view address = declared.address;
    const std::size_t slash = address.rfind('/');
    const std::string_view last = address.substr(slash + 1);
    const bool truth = declared.type == VrchatAvatar::Type::truth;
    const bool second_set = address.substr(0, slash + 1).ends_with("/v2/");
    if (last == "EyeTrackingActive" || last == "ExpressionTrackingActive" || last == "LipTrackingActive") {
      if (!truth) continue;
      channel.source = last == "EyeTrackingActive" ? Source::eye_tracking : Source::face_tracking;
      channel.form = Form::truth;
    } else if (!second_set) {
      continue;
    } else if (const auto whole = parameter_index(last)) {
      // An Int of a weight says nothing that a face tracker could mean.
      if (declared.type == VrchatAvatar::Type::whole) continue;
      channel.parameter = *whole;
      channel.form = truth ? Form::truth : Form::real;
    } else if (const auto binary = truth ? binary_name(last) : std::nullopt) {
      channel.parameter = binary->parameter;
      channel.form = binary->bit < 0 ? Form::negative : Form::bit;
      channel.bit = std::max(binary->bit, 0);
      group = std::string(address.substr(0, slash + 1)) + std::string(all[binary->parameter].name);
    } else {
      continue;
    }
    if (channel.source == Source::parameter) {
      const std::string_view name = all[channel.parameter].name;
      eyes_turn = eyes_turn || is_gaze(channel.parameter);
      eyes_close = eyes_close || name.starts_with("EyeLid") || name.starts_with("EyeOpen") ||
                   name.starts_with("EyeClosed");
    }
    encoder.channels_.push_back(std::move(channel));
    binary_group.push_back(std::move(group));
  }
  for (std::size_t i = 0; i < encoder.channels_.size(); ++i) {
    Channel& channel = encoder.channels_[i];
    if (channel.form != Form::bit) continue;
    for (std::size_t k = 0; k < encoder.channels_.size(); ++k) {
      if (binary_group[k] != binary_group[i]) continue;
      channel.bits += encoder.channels_[k].form == Form::bit ? 1 : 0;
      channel.has_negative = channel.has_negative || encoder.channels_[k].form == Form::negative;
    }
    channel.bits = std::min(channel.bits, kMaxBinaryBits);
  }
  if (encoder.channels_.empty())
    return fail(ErrorCode::mismatch, "the avatar has no parameter of face tracking (v2/JawOpen and the like)",
                avatar.name.empty() ? "the avatar" : excerpt(avatar.name),
                "leave out avatar= to send all, or wear an avatar that is made for face tracking");
  encoder.add_native_eyes(options.native_eyes && !eyes_turn, options.native_eyes && !eyes_close);
  return encoder;
}

void VrchatEncoder::encode(const ArkitFrame& frame, std::int64_t frame_index, Datagrams& out) {
  const bool full = !last_full_ || frame_index - *last_full_ >= kFullEvery || frame_index < *last_full_;
  if (full) last_full_ = frame_index;
  const UnifiedFrame unified = unified_frame(frame);
  const auto all = unified_parameters();
  for (std::size_t i = 0; i < all.size(); ++i) values_[i] = all[i].of(unified);

  OscBundles bundles(out);
  for (Channel& channel : channels_) {
    std::array<float, 4> now{};
    switch (channel.source) {
      case Source::parameter: {
        if (!frame.eyes_tracked && is_gaze(channel.parameter)) continue;
        const float value = values_[channel.parameter];
        if (channel.form == Form::real)
          now[0] = value;
        else if (channel.form == Form::negative)
          now[0] = value < 0 ? 1.0F : 0.0F;
        else if (channel.form == Form::truth)
          now[0] = value > 0.5F ? 1.0F : 0.0F;
        else
          now[0] = binary_bit(value, channel.bit, channel.bits, channel.has_negative) ? 1.0F : 0.0F;
        break;
      }
      case Source::eye_tracking:
        now[0] = frame.eyes_tracked ? 1.0F : 0.0F;
        break;
      case Source::face_tracking:
        now[0] = frame.face_tracked ? 1.0F : 0.0F;
        break;
      case Source::eyes_direction: {
        if (!frame.eyes_tracked) continue;
        constexpr float kDegrees = 180 / std::numbers::pi_v<float>;
        for (std::size_t eye = 0; eye < 2; ++eye) {
          now[2 * eye] = 0.0F - kDegrees * frame.eyes_rad[eye].y();
          now[2 * eye + 1] = 0.0F - kDegrees * frame.eyes_rad[eye].x();
        }
        break;
      }
      case Source::eyes_closed:
        if (!frame.lids_tracked && channel.last[0] == 0) continue;
        now[0] = frame.lids_tracked ? 1 - 0.5F * (unified.openness[0] + unified.openness[1]) : 0.0F;
        break;
    }
    float change = 0;
    for (std::size_t k = 0; k < now.size(); ++k)
      change = std::max(change, std::abs(now[k] - channel.last[k]));
    if (!full && change <= kThreshold) continue;
    channel.last = now;
    const char* const address = channel.address.c_str();
    if (channel.form == Form::four)
      bundles.add(address, now[0], now[1], now[2], now[3]);
    else if (channel.form == Form::real)
      bundles.add(address, now[0]);
    else
      bundles.add(address, now[0] != 0);
  }
  bundles.finish();
}

}  // namespace mien::sink
