#pragma once

#include <cstdint>
#include <memory>
#include <string_view>

#include "mien/core/error.h"
#include "mien/sink/address.h"
#include "mien/sink/sink.h"

// Sinks that are more than an encoder of datagrams. `text`: the address as it was given.
namespace mien::sink {

/// Opens a Live Link Face CSV that grows while the session lives: its header comes with the first rows, rows
/// every half second of frames, always whole lines in one write, by a thread of its own (a slow disk is no
/// business of the network's). A kill loses half a second. Time codes are the frames' own times at base 60.
/// Options: rate; force=1 replaces a file that exists, with the first rows and not before: a session that
/// ends without a frame replaces nothing and leaves nothing. Errors: bad_usage (the file exists, options),
/// not_found (its folder), unsupported (neither a file nor a device), io.
[[nodiscard]] Result<std::unique_ptr<Sink>> open_csv_sink(const Address& address, std::string_view text);

/// Sends iFacialMocap frames to one receiver unasked, and, as a phone would, to those who ask: who sends a
/// request to our port gets frames of its version at the receiver's port, 49983 unless the address has
/// another. Requests are answered only within the local network, for at most 8 who ask: frames are fifty
/// times as long as a request, and its sender's address may be forged. On this very machine the receiver has
/// the port, so none is listened on there unless `listen` names one.
/// Options: rate, version=1|2 (2), listen=PORT (0: do not). Errors: those of the options; not_found; io (a
/// `listen` that was asked for is taken).
[[nodiscard]] Result<std::unique_ptr<Sink>> open_ifacialmocap_sink(boost::asio::io_context& network,
                                                                   const Address& address,
                                                                   std::string_view text);

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
