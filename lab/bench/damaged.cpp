#include "lab/bench/damaged.h"

#include <cstdint>

#include "mien/core/bytes.h"
#include "mien/sensor/packet_envelope.h"

namespace mien::lab {

std::vector<std::byte> damaged(std::vector<std::byte> datagram, Random& random) {
  switch (random.below(3)) {
    case 0:
      for (std::uint64_t flips = 1 + random.below(8); flips > 0; --flips)
        datagram[random.below(datagram.size())] ^= static_cast<std::byte>(1U << random.below(8));
      break;
    case 1:
      datagram.resize(1 + random.below(datagram.size()));
      break;
    default:
      for (std::uint64_t more = 1 + random.below(64); more > 0; --more)
        datagram.push_back(static_cast<std::byte>(random.below(256)));
  }
  if (!random.chance(0.5)) mend_checksum(datagram);
  return datagram;
}

void mend_checksum(std::vector<std::byte>& datagram) {
  if (datagram.size() <= sensor::kChecksumBytes) return;
  datagram.resize(datagram.size() - sensor::kChecksumBytes);
  ByteWriter mended;
  mended.append(datagram);
  sensor::write_checksum(0, mended);
  datagram = mended.release();
}

}  // namespace mien::lab
