#pragma once

#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/time.h"
#include "mien/face/output_frame.h"
#include "mien/sensor/sample.h"

namespace mien::tracker {

/// Samples in, output frames out: what every modality implements. Calls come in the order of the session's log, and the
/// answer depends on nothing else.
class Tracker {
 public:
  virtual ~Tracker() = default;

  /// Something the performer was asked to do between two times of the reference clock ("neutral", "nod", "shake");
  /// unknown kinds are passed over. Given before the tick at `begin`.
  virtual void mark(std::string_view kind, DeviceTime begin, DeviceTime end) = 0;
  virtual void add(HostTime arrival, const sensor::Sample& sample) = 0;
  /// The frame at `frame` has fired. Appends the frames that are ready: a tracker that looks ahead gives them later.
  virtual Result<void> tick(DeviceTime frame, std::vector<face::OutputFrame>& ready) = 0;
  /// No more ticks: appends what is left, so that there is one output frame a tick in all.
  virtual Result<void> finish(std::vector<face::OutputFrame>& ready) = 0;
};

}  // namespace mien::tracker
