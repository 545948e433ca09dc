#include <fmt/format.h>

#include <array>

#include "mien/sink/datagram_sink.h"
#include "mien/sink/live_link.h"
#include "mien/sink/sink.h"

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

struct Kind {
  std::string_view scheme;
  std::string_view form;
  Opened (*open)(io_context&, const Address&, std::string_view text);
};

constexpr std::array kKinds = {
    Kind{"livelink", "livelink://HOST:PORT", open_live_link},
};

}  // namespace

Result<std::unique_ptr<Sink>> open_sink(io_context& network, std::string_view text) {
  MIEN_TRY_ASSIGN(const Address address, parse_address(text));
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

}  // namespace mien::sink
