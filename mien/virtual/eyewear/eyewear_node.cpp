#include "mien/virtual/eyewear/eyewear_node.h"

#include <utility>

namespace mien::virt {

HostTime EyewearNode::due() const {
  if (!start_ || scans_.empty()) return HostTime::max();
  return *start_ + scans_.front().time.time_since_epoch();
}

std::optional<std::vector<std::byte>> EyewearNode::next_datagram(HostTime now) {
  if (now < due()) return std::nullopt;
  std::vector<std::byte> bytes = std::move(scans_.front().bytes);
  scans_.pop_front();
  return bytes;
}

}  // namespace mien::virt
