#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "mien/core/time.h"
#include "mien/take/take.h"

namespace mien::virt {

/// Everything that a live session would have seen of a virtual performer, in order: what `mien perform
/// --take` writes and what training data are made of. The bytes are those that a socket would carry, and the
/// samples are decoded from them.
struct VirtualSession {
  std::vector<take::LogEntry> entries;  ///< By arrival; ids 1, 2, 3, ...
  /// Of the entries that have one beside their bytes, raw: by their ids.
  std::map<std::int64_t, std::vector<std::byte>> payloads;
  std::vector<take::StoredSample> samples;  ///< By entry.
  std::vector<take::Tick> ticks;
  std::vector<take::TruthFrame> truth;  ///< One a tick.
  DeviceTime motion_start;              ///< The motion's time 0, after the prologue.
  std::vector<take::Event> events;      ///< "neutral", "nod", "shake", "range", "prompt", "ease", and
                                        ///< of a headset "headset_failure".
};

}  // namespace mien::virt
