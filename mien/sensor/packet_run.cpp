#include "mien/sensor/packet_run.h"

namespace mien::sensor {

bool PacketRun::add(std::uint32_t sequence, DeviceTime time) {
  // By how many packets this one is ahead of the newest; numbers wrap.
  const auto ahead = static_cast<std::int32_t>(sequence - newest_);
  constexpr auto kFar = static_cast<std::int32_t>(kRemembered);
  if (!empty_ && ahead <= -kFar && time <= at(newest_).newest) return false;
  if (empty_ || ahead >= kFar || ahead <= -kFar) {
    *this = PacketRun();
    empty_ = false;
    whole_ = newest_ = sequence;
  }
  Packet& packet = packets_[sequence % kRemembered];
  if (came(sequence)) {
    if (time <= packet.newest) return false;
    packet.newest = time;
    return true;
  }
  packet = {sequence, true, time};
  if (ahead > 0) newest_ = sequence;
  // What is so far behind that its place is needed is given up.
  if (newest_ - whole_ >= kRemembered) whole_ = newest_;
  go_on();
  return true;
}

void PacketRun::go_on() {
  while (whole_ != newest_ && came(whole_ + 1)) ++whole_;
}

void PacketRun::give_up(DeviceTime time) {
  for (std::uint32_t next = whole_; next != newest_ && whole_until() < time;)
    if (came(++next)) whole_ = next;
  go_on();
}

}  // namespace mien::sensor
