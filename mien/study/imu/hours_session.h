#pragma once

#include "mien/virtual/imu/streamed_session.h"

namespace mien::study {

using HoursFrame = virt::StreamedFrame;
using HoursConsumer = virt::StreamConsumer;
using HoursSession = virt::StreamedSession;

}  // namespace mien::study
