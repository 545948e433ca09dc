#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

#include "mien/mocap/marker_log.h"
#include "mien/mocap/marker_packet.h"

// What was accepted and sent anew is accepted again and says the same; a log takes anything.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace mien;
  using namespace mien::mocap;
  const auto bytes = std::as_bytes(std::span(data, size));
  MarkerLog log;
  log.add(HostTime{}, bytes);
  log.add(HostTime{}, bytes);
  if (log.received().size() > 1) std::abort();
  const auto packet = parse_marker_packet(bytes);
  if (!packet) return 0;
  const auto* positions = std::get_if<MarkerPositionsPacket>(&*packet);
  if (positions == nullptr) {
    const auto& names = std::get<MarkerNamesPacket>(*packet);
    for (std::size_t i = 0; i < names.count; ++i)
      if (names.names[i].empty() || names.names[i].size() > kMaxMarkerNameBytes) std::abort();
    return 0;
  }
  const auto again = encode_marker_positions(*positions);
  if (!again) std::abort();
  const auto reread = parse_marker_packet(*again);
  if (!reread || std::get<MarkerPositionsPacket>(*reread).count != positions->count ||
      std::get<MarkerPositionsPacket>(*reread).time != positions->time)
    std::abort();
  return 0;
}
