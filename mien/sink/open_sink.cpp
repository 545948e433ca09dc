#include <fmt/format.h>

#include <array>

#include "mien/core/ascii.h"
#include "mien/core/files.h"
#include "mien/sink/datagram_sink.h"
#include "mien/sink/live_link.h"
#include "mien/sink/sink.h"
#include "mien/sink/sink_kinds.h"
#include "mien/sink/vmc.h"
#include "mien/sink/vrchat.h"
#include "mien/sink/vrchat_avatar.h"

namespace mien::sink {
namespace {

using boost::asio::io_context;
using Opened = Result<std::unique_ptr<Sink>>;

Result<int> rate_of(const Address& address) {
  return address.whole_option("rate", 60, 1, 60);
}

Opened open_live_link(io_context& network, const Address& address, std::string_view text) {
  MIEN_TRY(address.expect_options({"subject", "rate"}));
  MIEN_TRY_ASSIGN(const int rate_hz, rate_of(address));
  const std::string* const given = address.option("subject");
  const std::string subject = given == nullptr ? "mien" : *given;
  if (subject.empty() || subject.size() > kMaxLiveLinkName)
    return fail(ErrorCode::out_of_range, fmt::format("a subject has 1 to {} bytes", kMaxLiveLinkName),
                std::string(text));
  MIEN_TRY_ASSIGN(UdpTarget target, UdpTarget::open(network, address, kLiveLinkPort));
  return std::make_unique<DatagramSink>(
      std::string(text), std::move(target), rate_hz,
      [source = live_link_source(subject)](const face::OutputFrame& frame, std::int64_t index,
                                           Datagrams& out) {
        encode_live_link(arkit_frame(frame), source, index, out);
      });
}

Opened open_vmc(io_context& network, const Address& address, std::string_view text) {
  MIEN_TRY(address.expect_options({"shapes", "bones", "rate"}));
  MIEN_TRY_ASSIGN(const int rate_hz, rate_of(address));
  MIEN_TRY_ASSIGN(const int bones, address.whole_option("bones", 1, 0, 1));
  VmcOptions options{.bones = bones == 1};
  if (const std::string* const given = address.option("shapes")) {
    if (*given == "arkit")
      options.shapes = VmcShapes::perfect_sync;
    else if (*given == "presets")
      options.shapes = VmcShapes::presets;
    else if (*given != "both")
      return fail(ErrorCode::bad_usage, fmt::format("there are no shapes '{}'", *given), std::string(text),
                  "write shapes=arkit, presets or both");
  }
  MIEN_TRY_ASSIGN(UdpTarget target, UdpTarget::open(network, address, kVmcPort));
  return std::make_unique<DatagramSink>(
      std::string(text), std::move(target), rate_hz,
      [options](const face::OutputFrame& frame, std::int64_t /*index*/, Datagrams& out) {
        encode_vmc(arkit_frame(frame), frame.time, options, out);
      });
}

Result<VrchatEncoder> vrchat_encoder(const Address& address) {
  VrchatOptions options;
  MIEN_TRY_ASSIGN(options.binary_bits, address.whole_option("binary", 0, 0, kMaxBinaryBits));
  MIEN_TRY_ASSIGN(const int eyes, address.whole_option("eyes", 1, 0, 1));
  options.native_eyes = eyes == 1;
  if (const std::string* const prefix = address.option("prefix")) options.prefix = *prefix;
  const std::string* const avatar_file = address.option("avatar");
  if (avatar_file == nullptr) return VrchatEncoder::make(options);
  if (!options.prefix.empty() || options.binary_bits != 0)
    return fail(ErrorCode::bad_usage, "prefix and binary say what the avatar's file says already",
                *avatar_file, "leave them out");
  constexpr std::size_t kMaxAvatarBytes = std::size_t{4} << 20U;
  MIEN_TRY_ASSIGN(const std::string json, read_text(*avatar_file, kMaxAvatarBytes));
  MIEN_TRY_ASSIGN(const VrchatAvatar avatar, parse_vrchat_avatar(json, *avatar_file));
  return VrchatEncoder::make(options, avatar);
}

Opened open_vrchat(io_context& network, const Address& address, std::string_view text) {
  MIEN_TRY(address.expect_options({"avatar", "prefix", "binary", "eyes", "rate"}));
  MIEN_TRY_ASSIGN(const int rate_hz, rate_of(address));
  MIEN_TRY_ASSIGN(VrchatEncoder encoder, vrchat_encoder(address));
  MIEN_TRY_ASSIGN(UdpTarget target, UdpTarget::open(network, address, kVrchatPort));
  return std::make_unique<DatagramSink>(
      std::string(text), std::move(target), rate_hz,
      [encoder = std::move(encoder)](const face::OutputFrame& frame, std::int64_t index,
                                     Datagrams& out) mutable {
        encoder.encode(arkit_frame(frame), index, out);
      });
}

Opened open_csv(io_context& /*network*/, const Address& address, std::string_view text) {
  return open_csv_sink(address, text);
}

struct Kind {
  std::string_view scheme;
  std::string_view form;
  Opened (*open)(io_context&, const Address&, std::string_view text);
};

constexpr std::array kKinds = {
    Kind{"livelink", "livelink://HOST:PORT", open_live_link},
    Kind{"vmc", "vmc://HOST:PORT", open_vmc},
    Kind{"vrchat", "vrchat://HOST:PORT", open_vrchat},
    Kind{"ifacialmocap", "ifacialmocap://HOST:PORT", open_ifacialmocap_sink},
    Kind{"ws", "ws://HOST:PORT", open_ws_sink},
    Kind{"csv", "csv:FILE", open_csv},
};

/// One of several addresses is wrong: its error says which, as it was typed, and then what else it names (an
/// avatar's file, the port that was not given).
Error named(Error error, std::string_view text) {
  std::string_view where = error.where;
  if (where.size() > 1 && where.starts_with('\'') && where.ends_with('\''))
    where = where.substr(1, where.size() - 2);
  if (text.find(where) == std::string_view::npos) error.what = fmt::format("{}: {}", where, error.what);
  error.where = text;
  return error;
}

Opened open(io_context& network, const Address& address, std::string_view text) {
  for (const Kind& kind : kKinds) {
    if (kind.scheme != address.scheme) continue;
    if (address.scheme != "ws" && address.scheme != "csv" && !address.path.empty())
      return fail(ErrorCode::bad_usage, fmt::format("{} takes no path", address.scheme), std::string(text),
                  fmt::format("write {}", kind.form));
    return kind.open(network, address, text);
  }
  std::string known;
  for (const Kind& kind : kKinds) known += fmt::format("{}{}", known.empty() ? "" : ", ", kind.form);
  return fail(ErrorCode::bad_usage, fmt::format("there is no sink of the kind '{}'", address.scheme),
              std::string(text), "the kinds are " + known);
}

}  // namespace

Result<std::unique_ptr<Sink>> open_sink(io_context& network, std::string_view text) {
  const Result<Address> address = parse_address(text);
  // What is too long, or would be obeyed by a terminal, is not repeated.
  const bool sayable = text.size() <= kMaxAddressBytes && !has_control(text);
  if (!address) return std::unexpected(sayable ? named(address.error(), text) : address.error());
  Opened opened = open(network, *address, text);
  if (!opened) return std::unexpected(named(std::move(opened).error(), text));
  return opened;
}

}  // namespace mien::sink
