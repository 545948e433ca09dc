#pragma once

#include <memory>

#include "mien/core/error.h"
#include "mien/sink/address.h"
#include "mien/sink/sink.h"

namespace mien::sink {

/// Opens a Live Link Face CSV that grows while the session lives: its header comes with the first rows, rows
/// every half second of frames, always whole lines in one write, by a thread of its own (a slow disk is no
/// business of the network's). A kill loses half a second. Time codes are the frames' own times at base 60.
/// Options: rate; force=1 replaces a file that exists, with the first rows and not before: a session that
/// ends without a frame replaces nothing and leaves nothing. Errors: bad_usage (the file exists, options),
/// not_found (its folder), unsupported (neither a file nor a device), io.
[[nodiscard]] Result<std::unique_ptr<Sink>> open_csv_sink(const Address& address, std::string_view text);

}  // namespace mien::sink
