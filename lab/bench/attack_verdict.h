#pragma once

#include <string>
#include <vector>

#include "lab/bench/attacked_session.h"

namespace mien::lab {

/// Each figure's median over runs; `same_bits` where all had it. The PVE is that of the runs that have one.
[[nodiscard]] AttackFigures median(const std::vector<AttackFigures>& runs);

/// What a stranger brought about that he must not, each in a few words; empty: nothing. `quiet` are the same
/// sessions without him. Limits: no reading of his is accepted, the face is shown as without him (the PVE
/// within 2 %, or the runs' own spread where that is more) and the devices are heard (99 of 100 readings, of
/// cameras all but a tenth of a second where that is more); no frame added; at most 40 MB more memory, which
/// is what the queues of a recording hold; its take replays to the same bits. Where the face is compared,
/// time is judged too: no frame missed that is not missed without him; p99 at most a millisecond more, with a
/// key no more than the runs' own spread or 0.2 ms. Of one who behaves as a sensor and speaks first, without
/// a key: all but whom the face is of. Of a camera: no frame is missing either, and what it shows is nobody
/// else's.
[[nodiscard]] std::vector<std::string> breaches(const Attack& attack, bool keyed,
                                                const std::vector<AttackFigures>& attacked,
                                                const std::vector<AttackFigures>& quiet);

}  // namespace mien::lab
