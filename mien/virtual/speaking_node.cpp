#include "mien/virtual/speaking_node.h"

#include <utility>

namespace mien::virt {

HostTime SpeakingNode::due() const {
  if (!start_ || packets_.empty()) return HostTime::max();
  return *start_ + packets_.front().time.time_since_epoch();
}

std::optional<std::vector<std::byte>> SpeakingNode::next_datagram(HostTime now) {
  if (now < due()) return std::nullopt;
  std::vector<std::byte> bytes = std::move(packets_.front().bytes);
  packets_.pop_front();
  return bytes;
}

}  // namespace mien::virt
