#pragma once

#include <optional>
#include <vector>

#include "mien/sensor/protocol.h"
#include "mien/virtual/node.h"

namespace mien::virt::test {

/// A node and its host, joined by a wire without delay, on a clock that only this moves.
class Conversation {
 public:
  /// `host` may be none: nobody listens then.
  Conversation(Node& node, sensor::Protocol* host) : node_(node), host_(host) {}

  /// Runs until `end`, moment by moment as the node asks, the host ten times a second.
  void run_until(HostTime end) {
    while (now_ < end) {
      for (auto datagram = node_.next_datagram(now_); datagram; datagram = node_.next_datagram(now_)) {
        sent_.push_back({now_, *datagram});
        if (host_ == nullptr) continue;
        inbox_.reply.clear();
        verdicts_.push_back(host_->receive(now_, 1, *datagram, inbox_));
        if (!inbox_.reply.empty()) node_.receive(now_, inbox_.reply);
      }
      if (host_ != nullptr && now_ >= next_word_) {
        next_word_ = now_ + std::chrono::milliseconds(100);
        std::vector<sensor::Protocol::Outgoing> words;
        host_->heartbeats(now_, words);
        for (const auto& word : words) node_.receive(now_, word.datagram);
        if (!words.empty()) continue;
      }
      HostTime next = std::max(node_.due(), now_ + std::chrono::microseconds(1));
      if (host_ != nullptr) next = std::min(next, next_word_);
      now_ = std::min(end, next);
    }
  }

  struct Sent {
    HostTime time;
    std::vector<std::byte> bytes;
  };
  [[nodiscard]] HostTime now() const { return now_; }
  void connect(sensor::Protocol* host) { host_ = host; }
  std::vector<Sent>& sent() { return sent_; }
  std::vector<sensor::Verdict>& verdicts() { return verdicts_; }
  sensor::Inbox& inbox() { return inbox_; }

 private:
  Node& node_;
  sensor::Protocol* host_;
  HostTime now_;
  HostTime next_word_;
  std::vector<Sent> sent_;
  std::vector<sensor::Verdict> verdicts_;
  sensor::Inbox inbox_;
};

inline HostTime at(double seconds) {
  return HostTime(from_seconds(seconds));
}

}  // namespace mien::virt::test
