#include "mien/performer/canvas.h"

#include <algorithm>
#include <cstdlib>
#include <numbers>
#include <string>
#include <vector>

#include "mien/face/target_names.h"

namespace mien::performer {

using face::kShapeCount;
using face::kShapeNames;
using face::shape_index;

namespace {

/// The frames that an envelope touches.
struct Span {
  std::size_t begin;
  std::size_t end;
};

Span frames_of(const Envelope& envelope, std::size_t frame_count) {
  const auto count = static_cast<double>(frame_count);
  const double begin = std::clamp(std::ceil(envelope.begin_s * kFrameRateHz), 0.0, count);
  const double end = std::clamp(std::ceil(envelope.end_s() * kFrameRateHz), begin, count);
  return {static_cast<std::size_t>(begin), static_cast<std::size_t>(end)};
}

std::array<std::uint8_t, kShapeCount> make_other_sides() {
  std::array<std::uint8_t, kShapeCount> other{};
  for (std::size_t k = 0; k < kShapeCount; ++k) {
    other[k] = static_cast<std::uint8_t>(k);
    std::string name(kShapeNames[k]);
    if (name.ends_with("_L")) {
      name.back() = 'R';
    } else if (name.ends_with("_R")) {
      name.back() = 'L';
    } else {
      continue;
    }
    other[k] = static_cast<std::uint8_t>(shape_index(name));
  }
  return other;
}

}  // namespace

Pose pose_of(std::initializer_list<NamedPart> parts) {
  Pose pose;
  for (const NamedPart& part : parts) {
    const std::vector<std::size_t> shapes = face::shapes_named(part.stem);
    if (shapes.empty()) std::abort();
    for (const std::size_t shape : shapes) pose.push_back({static_cast<std::uint8_t>(shape), part.weight});
  }
  return pose;
}

std::size_t other_side(std::size_t shape_of_one_side) {
  static const auto other = make_other_sides();
  return other[shape_of_one_side];
}

bool is_driven_by_others(std::size_t shape) {
  return kShapeNames[shape].starts_with("eyeLook") || shape == face::shape("mouthClose");
}

Canvas::Canvas(std::size_t frame_count)
    : weights(frame_count),
      tongue_out(frame_count, 0.0F),
      lip_closure(frame_count, 0.0F),
      gaze_rad(frame_count, Eigen::Vector2f::Zero()),
      gaze_held(frame_count, 0.0F),
      head_rad(frame_count, Vec3::Zero()) {}

void Canvas::add(std::size_t shape, const Envelope& envelope, double peak) {
  const Span span = frames_of(envelope, frame_count());
  for (std::size_t i = span.begin; i < span.end; ++i)
    weights[i][shape] += static_cast<float>(peak * envelope.at(static_cast<double>(i) / kFrameRateHz));
}

void Canvas::add(const Pose& pose, const Envelope& envelope, double peak) {
  const Span span = frames_of(envelope, frame_count());
  for (std::size_t i = span.begin; i < span.end; ++i) {
    const auto now = static_cast<float>(peak * envelope.at(static_cast<double>(i) / kFrameRateHz));
    for (const PosePart& part : pose) weights[i][part.shape] += part.weight * now;
  }
}

void Canvas::add_tongue(const Envelope& envelope, double peak) {
  const Span span = frames_of(envelope, frame_count());
  for (std::size_t i = span.begin; i < span.end; ++i)
    tongue_out[i] += static_cast<float>(peak * envelope.at(static_cast<double>(i) / kFrameRateHz));
}

void Canvas::lay(const Canvas& part, std::ptrdiff_t first_frame, std::size_t fade_frames) {
  const auto total = static_cast<std::ptrdiff_t>(frame_count());
  const auto length = static_cast<std::ptrdiff_t>(part.frame_count());
  const bool cut_front = first_frame <= 0;
  const bool cut_back = first_frame + length >= total;
  const auto fade = static_cast<double>(fade_frames);
  for (std::ptrdiff_t j = std::max<std::ptrdiff_t>(0, -first_frame); j < length && first_frame + j < total;
       ++j) {
    double share = 1;
    if (!cut_front) share *= minimum_jerk((static_cast<double>(j) + 0.5) / fade);
    if (!cut_back) share *= minimum_jerk((static_cast<double>(length - 1 - j) + 0.5) / fade);
    const auto s = static_cast<float>(share);
    const auto from = static_cast<std::size_t>(j);
    const auto to = static_cast<std::size_t>(first_frame + j);
    for (std::size_t k = 0; k < kShapeCount; ++k) weights[to][k] += s * part.weights[from][k];
    tongue_out[to] += s * part.tongue_out[from];
    lip_closure[to] = std::max(lip_closure[to], s * part.lip_closure[from]);
    gaze_rad[to] += s * part.gaze_rad[from];
    gaze_held[to] = std::max(gaze_held[to], s * part.gaze_held[from]);
    head_rad[to] += share * part.head_rad[from];
  }
  for (const double pause_s : part.pauses_s) {
    const double time_s = pause_s + static_cast<double>(first_frame) / kFrameRateHz;
    if (time_s >= 0 && time_s < duration_s()) pauses_s.push_back(time_s);
  }
}

SmoothNoise::SmoothNoise(double cutoff_hz, Random& random)
    : keep_(std::exp(-2 * std::numbers::pi * cutoff_hz / kFrameRateHz)) {
  // Variance of two cascaded one-pole filters fed with unit white noise: (1-a)^4 (1+a^2) / (1-a^2)^3.
  const double a = keep_;
  const double variance = std::pow(1 - a, 4) * (1 + a * a) / std::pow(1 - a * a, 3);
  scale_ = 1 / std::sqrt(variance);
  // Near the stationary state, so that motion does not begin at a standstill.
  first_ = std::sqrt((1 - a) / (1 + a)) * random.normal();
  second_ = 0.6 * first_ + 0.4 * std::sqrt(variance) * random.normal();
}

double SmoothNoise::next(Random& random) {
  first_ = keep_ * first_ + (1 - keep_) * random.normal();
  second_ = keep_ * second_ + (1 - keep_) * first_;
  return scale_ * second_;
}

}  // namespace mien::performer
