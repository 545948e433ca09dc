#include "mien/phone/face_readings.h"

#include <array>
#include <span>

namespace mien::phone {

void add_readings(const ToldFace& face, std::uint64_t device, const ToldWhen& when, sensor::Inbox& inbox) {
  std::array<sensor::Sample, kMostParts> samples;
  const std::size_t used = samples_of(face, samples);
  for (sensor::Sample& sample : std::span(samples).first(used)) {
    sample.sequence = when.sequence;
    sample.time = when.time;
    sample.time_estimated = when.estimated;
    inbox.readings.push_back({.from = {device, 0}, .sample = sample});
  }
  if (used == 0) inbox.alive = {device, 0};
  if (used > 0 && face.origin == Origin::held) inbox.no_face = {device, 0};
}

}  // namespace mien::phone
