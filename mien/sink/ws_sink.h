#pragma once

#include <cstdint>
#include <memory>

#include "mien/core/error.h"
#include "mien/sink/address.h"
#include "mien/sink/sink.h"

namespace mien::sink {

/// Where `ws://HOST` without a port is.
inline constexpr std::uint16_t kWsPort = 8741;
/// Most who may look on at once.
inline constexpr std::size_t kMaxWsClients = 16;

/// Sends the page's `hello` and `frame` messages (docs/reference/page_protocol.md) by WebSocket. Where the
/// address is this machine's and nobody listens there it listens itself, for at most kMaxWsClients who
/// connect; else it connects at once, before there are frames, and for as long as nobody answers tries again
/// after half a second, one, two, then every four. Which of both is settled when it is opened. It listens on
/// loopback for everybody on this machine but web pages of other hosts, and on other addresses only with a
/// token. Options: rate, token, role=connect|listen (by what is found there). Errors: bad_usage (listening to
/// the network without a token, options), not_found (no such host), io (role=listen, and it cannot).
[[nodiscard]] Result<std::unique_ptr<Sink>> open_ws_sink(boost::asio::io_context& network,
                                                         const Address& address, std::string_view text);

}  // namespace mien::sink
