#pragma once

#include <map>
#include <string>
#include <string_view>

#include "mien/sensor/protocol.h"

namespace mien::session {

/// Who sent a datagram, as a session knows it.
struct Sender {
  /// `source`: as the log names it, "udp://192.168.1.7:5005"; by it people tell two senders of one id apart,
  /// and choose between them. Valid during the call that it is given to. Empty: cannot be chosen.
  Sender(sensor::Peer its, std::string_view name = {}) : peer(its), source(name) {}
  sensor::Peer peer;
  std::string_view source;
};

/// The senders of a session log, for whoever feeds it to a receiver again: numbered in the order of their
/// first datagrams, as live.
class Peers {
 public:
  /// Its source text stands as long as this does.
  Sender of(const std::string& source) {
    const auto known = peers_.emplace(source, static_cast<sensor::Peer>(peers_.size())).first;
    return {known->second, known->first};
  }

 private:
  std::map<std::string, sensor::Peer> peers_;
};

}  // namespace mien::session
