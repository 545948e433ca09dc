#include "mien/phone/weights_tracker.h"

#include <algorithm>
#include <utility>

#include "mien/sensor/rig_part.h"

namespace mien::phone {
namespace {

using face::Provenance;

/// Where a sensor's time runs back farther than this the sender restarted.
constexpr Duration kRestart = std::chrono::milliseconds(200);

float between(float a, float b, float share) {
  return a + share * (b - a);
}

/// `b` into `a`, where both know a shape.
void blend(InnerFace& a, const InnerFace& b, float share) {
  for (std::size_t k = 0; k < face::kInnerCount; ++k) {
    if (!a.known[k] || !b.known[k]) continue;
    a.weights[k] = between(a.weights[k], b.weights[k], share);
    a.confidence[k] = between(a.confidence[k], b.confidence[k], share);
  }
}

void put_shapes(const InnerFace& inner, Provenance provenance, face::OutputFrame& out) {
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    const bool first = out.provenance[k] == Provenance::neutral;
    if (!inner.known[k] || (!first && inner.confidence[k] <= out.confidence[k])) continue;
    out.weights[k] = inner.weights[k];
    out.confidence[k] = inner.confidence[k];
    out.provenance[k] = provenance;
  }
}

struct Head {
  Quat rotation = Quat::Identity();
  float confidence = 0;
  std::optional<Vec3f> position_m;  // In the sender's world.
};

Head head_of(const ToldFace& face) {
  return {canonical(quat_of(face.head->rotation)), confidence_of(face.head->confidence, face.origin),
          face.head->position_known ? std::optional(face.head->position_m) : std::nullopt};
}

}  // namespace

Result<std::unique_ptr<WeightsTracker>> WeightsTracker::create(const sensor::Rig& rig) {
  std::vector<Channel> channels;
  for (const std::uint16_t number : sensor::sensors_of(rig, "weights"))
    channels.emplace_back().sensor = number;
  if (channels.empty())
    return fail(ErrorCode::mismatch, "no sensor of this rig is of the kind weights", "rig " + rig.name);
  return std::unique_ptr<WeightsTracker>(new WeightsTracker(std::move(channels)));
}

WeightsTracker::Around WeightsTracker::Channel::around(DeviceTime time) const {
  Around found;
  for (std::size_t back = 0; back < faces.size(); ++back) {
    const Seen& seen = faces[back];
    if (seen.time > time) {
      found.after = &seen;
      continue;
    }
    if (time - seen.time > kPresent) return {};
    found.before = &seen;
    if (found.after == nullptr) return found;
    const Duration step = found.after->time - seen.time;
    if (step > kPresent)
      found.after = nullptr;  // A gap: nobody knows what was in it.
    else
      found.share = static_cast<float>(to_seconds(time - seen.time) / to_seconds(step));
    return found;
  }
  return {};
}

void WeightsTracker::Channel::place(const ToldHead& head) {
  if (!head.position_known) return;
  if (!origin_m) origin_m = head.position_m;
  // The head has not moved because its sender has another world now.
  if (std::exchange(begun_anew, false)) *origin_m += head.position_m - newest_m;
  newest_m = head.position_m;
}

void WeightsTracker::add(HostTime, const sensor::Sample& sample) {
  const auto channel = std::ranges::find(channels_, sample.sensor, &Channel::sensor);
  if (channel == channels_.end()) return;
  Seen* const newest = channel->faces.empty() ? nullptr : &channel->faces[0];
  const Duration since = newest == nullptr ? Duration::max() : sample.time - newest->time;
  const bool same = newest != nullptr && since == Duration::zero() && newest->sequence == sample.sequence;
  if (!same && since <= Duration::zero() && since >= -kRestart) return;  // Doubled, or out of order.
  if (same) {
    if (!add_sample(sample, newest->face)) return;
  } else {
    Seen seen{sample.time, sample.sequence, {}};
    if (!add_sample(sample, seen.face)) return;
    if (since < -kRestart) {
      channel->faces.clear();
      channel->begun_anew = channel->origin_m.has_value();
    }
    channel->faces.push(seen);
  }
  if (sample.kind == sensor::SampleKind::head_pose) channel->place(*channel->faces[0].face.head);
}

void WeightsTracker::forget(std::uint16_t sensor) {
  for (Channel& channel : channels_)
    if (channel.sensor == sensor) {
      channel.faces.clear();
      channel.origin_m.reset();
      channel.begun_anew = false;
    }
}

InnerFace WeightsTracker::shapes_at(const Around& around) {
  InnerFace inner = inner_face(around.before->face);
  if (around.after != nullptr) blend(inner, inner_face(around.after->face), around.share);
  return inner;
}

void WeightsTracker::put_head(const Around& around, const Channel& channel, face::OutputFrame& out) {
  const ToldFace& told = around.before->face;
  if (!told.head) return;
  Head head = head_of(told);
  if (around.after != nullptr && around.after->face.head) {
    const Head next = head_of(around.after->face);
    head.rotation = head.rotation.slerp(static_cast<double>(around.share), next.rotation);
    head.confidence = between(head.confidence, next.confidence, around.share);
    if (head.position_m && next.position_m)
      *head.position_m += around.share * (*next.position_m - *head.position_m);
  }
  if (out.head_provenance != Provenance::neutral && head.confidence <= out.head_confidence) return;
  out.head = canonical(head.rotation);
  out.head_confidence = head.confidence;
  out.head_provenance = provenance_of(told.origin);
  out.head_position_known = head.position_m && channel.origin_m;
  out.head_position_m.setZero();
  if (out.head_position_known) out.head_position_m = *head.position_m - *channel.origin_m;
}

tracker::TickResult WeightsTracker::tick(DeviceTime frame, const sensor::TimeLines& lines,
                                         face::OutputFrame& out) {
  tracker::TickResult result;
  out = face::neutral_frame(frame);
  if (!lines.ready()) return result;
  float tongue_confidence = -1;
  for (const Channel& channel : channels_) {
    if (!lines.has_samples(channel.sensor)) continue;
    const Around around = channel.around(lines.from_line(channel.sensor, frame));
    if (around.before == nullptr) continue;
    ++result.sensors_present;
    const InnerFace inner = shapes_at(around);
    put_shapes(inner, provenance_of(around.before->face.origin), out);
    constexpr std::size_t kTongue = face::kShapeCount;
    if (inner.known[kTongue] && inner.confidence[kTongue] > tongue_confidence) {
      tongue_confidence = inner.confidence[kTongue];
      out.tongue_out = inner.weights[kTongue];
    }
    put_head(around, channel, out);
  }
  return result;
}

}  // namespace mien::phone
