#pragma once

#include <map>
#include <string>

#include "mien/sensor/protocol.h"

namespace mien::session {

/// The senders of a session log, for whoever feeds it to a receiver again: numbered in the order of their
/// first datagrams, as live.
class Peers {
 public:
  sensor::Peer of(const std::string& source) {
    return peers_.emplace(source, static_cast<sensor::Peer>(peers_.size())).first->second;
  }

 private:
  std::map<std::string, sensor::Peer> peers_;
};

}  // namespace mien::session
