#pragma once

#include <memory>

#include "mien/core/error.h"
#include "mien/sink/address.h"
#include "mien/sink/sink.h"

namespace mien::sink {

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

}  // namespace mien::sink
