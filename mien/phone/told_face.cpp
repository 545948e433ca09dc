#include "mien/phone/told_face.h"

#include <algorithm>
#include <cmath>

namespace mien::phone {
namespace {

using sensor::Sample;
using sensor::SampleKind;

constexpr std::size_t kHeadValues = 10;
constexpr float kLengthTolerance = 0.01F;

bool is_within(float x, float low, float high) {
  return x >= low && x <= high;
}

bool is_share(float x) {
  return x == kUntold || is_within(x, 0, 1);
}

bool is_weight(float x) {
  return x == kUntold || is_within(x, -kBeyond, 1 + kBeyond);
}

bool is_sound(const ToldHead& head) {
  float square = 0;
  for (const float q : head.rotation) square += q * q;
  for (const float x : head.position_m)
    if (!is_within(x, -kMostHead_m, kMostHead_m) || (x != 0 && !head.position_known)) return false;
  return is_within(std::sqrt(square), 1 - kLengthTolerance, 1 + kLengthTolerance) &&
         is_share(head.confidence);
}

/// A whole number from 0 to below `end`; none for any other.
std::optional<std::uint8_t> number_below(float value, std::size_t end) {
  if (!is_within(value, 0, static_cast<float>(end) - 1) || value != std::floor(value)) return std::nullopt;
  return static_cast<std::uint8_t>(value);
}

std::size_t put_parts(const ToldFace& face, SampleKind kind, std::span<Sample, kMostParts> out,
                      std::size_t used) {
  const auto& values = kind == SampleKind::weights ? face.weights : face.confidence;
  const std::size_t count = count_of(face.set);
  for (std::size_t first = 0; first < count; first += kPartShapes) {
    const auto part = std::span(values).subspan(first, std::min(kPartShapes, count - first));
    if (std::ranges::all_of(part, [](float x) { return x == kUntold; })) continue;
    Sample& sample = out[used++];
    sample = {};
    sample.kind = kind;
    sample.count = static_cast<std::uint8_t>(3 + part.size());
    sample.values[0] = static_cast<float>(face.set);
    sample.values[1] = static_cast<float>(face.origin);
    sample.values[2] = static_cast<float>(first);
    std::ranges::copy(part, sample.values.begin() + 3);
  }
  return used;
}

bool add_part(const Sample& sample, ToldFace& face) {
  const auto values = sample.used();
  if (values.size() < 4) return false;
  const auto set = number_below(values[0], kShapeSetCount);
  const auto origin = number_below(values[1], kOriginCount);
  const auto first = number_below(values[2], kMostShapes);
  if (!set || !origin || !first || *first % kPartShapes != 0) return false;
  const auto of = static_cast<ShapeSet>(*set);
  const bool begun = face.told() > 0;
  if (begun && face.set != of) return false;
  const std::size_t count = count_of(of);
  if (*first >= count || values.size() - 3 != std::min(kPartShapes, count - *first)) return false;
  const auto part = values.subspan(3);
  if (sample.kind == SampleKind::weights) {
    if (!std::ranges::all_of(part, is_weight)) return false;
    std::ranges::copy(part, face.weights.begin() + *first);
  } else {
    for (std::size_t i = 0; i < part.size(); ++i)
      if (!is_share(part[i]) || (part[i] != kUntold && face.weights[*first + i] == kUntold)) return false;
    std::ranges::copy(part, face.confidence.begin() + *first);
  }
  face.set = of;
  face.origin = static_cast<Origin>(*origin);
  return true;
}

bool add_head(const Sample& sample, ToldFace& face) {
  const auto values = sample.used();
  if (values.size() != kHeadValues) return false;
  const auto origin = number_below(values[8], kOriginCount);
  const auto known = number_below(values[9], 2);
  if (!origin || !known) return false;
  ToldHead head;
  head.position_m = {values[0], values[1], values[2]};
  std::ranges::copy(values.subspan(3, 4), head.rotation.begin());
  head.confidence = values[7];
  head.position_known = *known == 1;
  if (!is_sound(head)) return false;
  face.head = head;
  face.origin = static_cast<Origin>(*origin);
  return true;
}

}  // namespace

std::size_t ToldFace::told() const {
  return weights.size() - static_cast<std::size_t>(std::ranges::count(weights, kUntold));
}

bool is_sound(const ToldFace& face) {
  const std::size_t count = count_of(face.set);
  for (std::size_t i = 0; i < kMostShapes; ++i) {
    if (!is_weight(face.weights[i]) || !is_share(face.confidence[i])) return false;
    if (face.weights[i] == kUntold && face.confidence[i] != kUntold) return false;
    if (i >= count && face.weights[i] != kUntold) return false;
  }
  return static_cast<std::uint8_t>(face.origin) < kOriginCount && (!face.head || is_sound(*face.head));
}

std::size_t samples_of(const ToldFace& face, std::span<Sample, kMostParts> out) {
  std::size_t used = put_parts(face, SampleKind::weights, out, 0);
  used = put_parts(face, SampleKind::weights_confidence, out, used);
  if (!face.head) return used;
  Sample& sample = out[used++];
  sample = {};
  sample.kind = SampleKind::head_pose;
  sample.count = kHeadValues;
  for (std::size_t i = 0; i < 3; ++i) sample.values[i] = face.head->position_m[static_cast<Eigen::Index>(i)];
  std::ranges::copy(face.head->rotation, sample.values.begin() + 3);
  sample.values[7] = face.head->confidence;
  sample.values[8] = static_cast<float>(face.origin);
  sample.values[9] = face.head->position_known ? 1 : 0;
  return used;
}

bool add_sample(const Sample& sample, ToldFace& face) {
  switch (sample.kind) {
    case SampleKind::weights:
    case SampleKind::weights_confidence:
      return add_part(sample, face);
    case SampleKind::head_pose:
      return add_head(sample, face);
    default:
      return false;
  }
}

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
