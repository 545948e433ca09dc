#include "mien/measure/metrics.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string_view>

namespace mien::measure {
namespace {

constexpr std::size_t kBatch = 16;  // Frames at once: the inner loops run over these, one SIMD lane a frame.
using Lanes = std::array<float, kBatch>;

float clipped(float w) {
  return std::clamp(w, 0.0F, 1.0F);
}

MeanStd mean_std(std::span<const float> values) {
  MeanStd out;
  if (values.empty()) return out;
  double sum = 0;
  for (const float v : values) sum += v;
  out.mean = sum / static_cast<double>(values.size());
  double square = 0;
  for (const float v : values) square += (v - out.mean) * (v - out.mean);
  out.std = std::sqrt(square / static_cast<double>(values.size()));
  return out;
}

/// Mean length of the third difference of a track of points, mm/s^3, of which the last four frames are held.
class ThirdDifference {
 public:
  explicit ThirdDifference(std::size_t points) : points_(points), last_mm_(4 * points) {}
  /// Point `p` of frame `f`: frame by frame, all points of each.
  void set(std::size_t f, std::size_t p, const Vec3f& at_mm) {
    last_mm_[f % 4 * points_ + p] = at_mm;
    if (f < 3) return;
    const auto ago = [&](std::size_t frames) -> const Vec3f& {
      return last_mm_[(f - frames) % 4 * points_ + p];
    };
    sum_ += (ago(0) - 3 * ago(1) + 3 * ago(2) - ago(3)).norm();
    ++count_;
  }
  [[nodiscard]] double mean() const {
    return count_ == 0 ? 0 : sum_ / static_cast<double>(count_) * 60.0 * 60.0 * 60.0;
  }

 private:
  std::size_t points_;
  std::vector<Vec3f> last_mm_;
  double sum_ = 0;
  std::size_t count_ = 0;
};

constexpr float kShut = 0.5F;
constexpr std::array<std::size_t, 2> kLids = {face::shape("eyeBlink_L"), face::shape("eyeBlink_R")};

using Weights = std::span<const face::BlendshapeWeights>;
using Frames = std::vector<std::size_t>;

bool is_shut(const face::BlendshapeWeights& weights) {
  return 0.5F * (weights[kLids[0]] + weights[kLids[1]]) >= kShut;
}

/// Frames in which the shape's weight crosses kShut upwards.
Frames blinks(Weights weights, std::size_t shape) {
  Frames frames;
  for (std::size_t f = 1; f < weights.size(); ++f)
    if (weights[f - 1][shape] < kShut && weights[f][shape] >= kShut) frames.push_back(f);
  return frames;
}

/// Those during which the other shape's stays below it, and `around` frames before and after.
Frames winks(Weights weights, std::size_t shape, std::size_t other, std::size_t around) {
  Frames frames = blinks(weights, shape);
  std::erase_if(frames, [&](std::size_t frame) {
    std::size_t end = frame;
    while (end < weights.size() && weights[end][shape] >= kShut) ++end;
    const std::size_t from = frame - std::min(frame, around), to = std::min(weights.size(), end + around);
    return std::ranges::any_of(weights.subspan(from, to - from),
                               [&](const auto& both) { return both[other] >= kShut; });
  });
  return frames;
}

/// F1 of what happens in single frames, each matched to one of the other side within a tolerance.
class EventF1 {
 public:
  explicit EventF1(int tolerance) : tolerance_(tolerance) {}
  /// Both ascend: matching each to the first free partner in reach is the largest one-to-one matching.
  void add(const Frames& truth, const Frames& estimate) {
    events_ += truth.size() + estimate.size();
    for (std::size_t t = 0, e = 0; t < truth.size() && e < estimate.size();) {
      const auto apart = static_cast<std::int64_t>(truth[t]) - static_cast<std::int64_t>(estimate[e]);
      const bool same = std::abs(apart) <= tolerance_;
      hits_ += same ? 1 : 0;
      t += same || apart < 0 ? 1 : 0;
      e += same || apart > 0 ? 1 : 0;
    }
  }
  /// None where neither side has any.
  [[nodiscard]] std::optional<double> value() const {
    if (events_ == 0) return std::nullopt;
    return 2.0 * static_cast<double>(hits_) / static_cast<double>(events_);
  }

 private:
  int tolerance_;
  std::size_t hits_ = 0, events_ = 0;
};

/// Of a shape's weights over all frames; none where either side is still.
std::optional<double> pearson(std::span<const Stretch> stretches, std::size_t shape) {
  const auto over_frames = [&](const auto& add) {
    for (const Stretch& s : stretches)
      for (std::size_t f = 0; f < s.truth.size(); ++f)
        add(clipped(s.truth[f][shape]), clipped(s.estimate[f][shape]));
  };
  double count = 0, truth_mean = 0, estimate_mean = 0;
  over_frames([&](float truth, float estimate) {
    ++count;
    truth_mean += truth;
    estimate_mean += estimate;
  });
  truth_mean /= count;
  estimate_mean /= count;
  double tt = 0, ee = 0, te = 0;
  over_frames([&](float truth, float estimate) {
    const double t = truth - truth_mean, e = estimate - estimate_mean;
    tt += t * t;
    ee += e * e;
    te += t * e;
  });
  constexpr double kStill = 1e-12;
  if (!(tt > kStill * count && ee > kStill * count)) return std::nullopt;
  return te / std::sqrt(tt * ee);
}

}  // namespace

bool counts_in_mse_observed(std::size_t shape) {
  const std::string_view name = face::kShapeNames[shape];
  return !name.starts_with("eyeLook") && !name.starts_with("eyeWide") && name != "mouthShrugUpper";
}

std::optional<double> blink_f1(std::span<const Stretch> stretches, int tolerance) {
  EventF1 f1(tolerance);
  for (const Stretch& stretch : stretches)
    for (const std::size_t lid : kLids) f1.add(blinks(stretch.truth, lid), blinks(stretch.estimate, lid));
  return f1.value();
}

std::optional<double> wink_f1(std::span<const Stretch> stretches, int tolerance) {
  EventF1 f1(tolerance);
  const auto around = static_cast<std::size_t>(std::max(0, tolerance));
  for (const Stretch& stretch : stretches)
    for (std::size_t eye = 0; eye < 2; ++eye) {
      const auto of = [&](Weights weights) { return winks(weights, kLids[eye], kLids[1 - eye], around); };
      f1.add(of(stretch.truth), of(stretch.estimate));
    }
  return f1.value();
}

Meter::Meter(const face::Face& face) : eyes_and_lips_(face) {
  const std::size_t vertices = face.neutral_m.size();
  shapes_.first.assign(vertices + 1, 0);
  const std::size_t shape_count = std::min(face.shapes.size(), face::kShapeCount);
  for (std::size_t k = 0; k < shape_count; ++k)
    for (const std::uint32_t v : face.shapes[k].vertex) ++shapes_.first[v + 1];
  for (std::size_t v = 0; v < vertices; ++v) shapes_.first[v + 1] += shapes_.first[v];
  shapes_.shape.resize(shapes_.first[vertices]);
  shapes_.delta_mm.resize(shapes_.first[vertices]);
  std::vector<std::uint32_t> next(shapes_.first.begin(), shapes_.first.end() - 1);
  for (std::size_t k = 0; k < shape_count; ++k)
    for (std::size_t i = 0; i < face.shapes[k].vertex.size(); ++i) {
      const std::uint32_t slot = next[face.shapes[k].vertex[i]]++;
      shapes_.shape[slot] = static_cast<std::uint16_t>(k);
      shapes_.delta_mm[slot] = 1000.0F * face.shapes[k].delta_m[i];
    }
  // How many ribbons a head of hair, a brow or a lash is drawn with, and how much of a shirt, says nothing
  // about an estimate.
  const std::vector<bool> hair = face.vertices_of(face::Material::strands);
  const std::vector<bool> cloth = face.vertices_of(face::Material::cloth);
  in_pve_.assign(vertices, 1);
  for (std::size_t v = 0; v < vertices; ++v)
    if (hair[v] || cloth[v]) in_pve_[v] = 0;
  in_pve_count_ = static_cast<std::size_t>(std::max<std::ptrdiff_t>(1, std::ranges::count(in_pve_, 1)));
  in_skin_.assign(vertices, 0);
  if (const face::Region* skin = face.region("skin"))
    for (const std::uint32_t v : skin->vertex) in_skin_[v] = 1;
  skin_count_ = static_cast<std::size_t>(std::ranges::count(in_skin_, 1));
  if (face.has_landmarks)
    for (const std::uint32_t v : face.landmarks) {
      landmarks_.push_back(v);
      landmark_neutral_mm_.push_back(1000.0F * face.neutral_m[v]);
    }
}

struct Meter::Sums {
  double squares = 0;           ///< Of all shapes' errors, ...
  double observed_squares = 0;  ///< ... and of those that count in mse_observed.
  std::vector<float> pve_face_mm;
  /// Of stretches that are long enough, weighed by their frames.
  double truth_jitter = 0, estimate_jitter = 0;
  std::size_t jitter_frames = 0;
};

/// Errors of the weights, one lane a frame.
struct Meter::Batch {
  std::size_t frames = 0;
  std::array<Lanes, face::kShapeCount> error{};
};

Meter::Batch Meter::add_weights(const Stretch& stretch, std::size_t first, Sums& sums, Metrics& out) {
  Batch batch{.frames = std::min(kBatch, stretch.truth.size() - first)};
  for (std::size_t f = 0; f < batch.frames; ++f) {
    double frame_squares = 0;
    for (std::size_t k = 0; k < face::kShapeCount; ++k) {
      const float e = clipped(stretch.estimate[first + f][k]) - clipped(stretch.truth[first + f][k]);
      batch.error[k][f] = e;
      const double square = static_cast<double>(e) * e;
      frame_squares += square;
      if (counts_in_mse_observed(k)) sums.observed_squares += square;
      out.per_shape[k].mae += std::abs(e);
    }
    sums.squares += frame_squares;
    out.mse_curve.push_back(static_cast<float>(frame_squares / face::kShapeCount));
  }
  return batch;
}

void Meter::add_vertices(const Batch& batch, Sums& sums, Metrics& out) const {
  std::array<double, kBatch> all_mm{};
  std::array<double, kBatch> skin_mm{};
  for (std::size_t v = 0; v < in_skin_.size(); ++v) {
    const std::uint32_t begin = shapes_.first[v];
    const std::uint32_t end = shapes_.first[v + 1];
    if (begin == end || in_pve_[v] == 0) continue;
    Lanes x{};
    Lanes y{};
    Lanes z{};
    for (std::uint32_t i = begin; i < end; ++i) {
      const Lanes& e = batch.error[shapes_.shape[i]];
      const Vec3f& d = shapes_.delta_mm[i];
      for (std::size_t f = 0; f < kBatch; ++f) {
        x[f] += d.x() * e[f];
        y[f] += d.y() * e[f];
        z[f] += d.z() * e[f];
      }
    }
    for (std::size_t f = 0; f < kBatch; ++f) {
      const float length = std::sqrt(x[f] * x[f] + y[f] * y[f] + z[f] * z[f]);
      all_mm[f] += length;
      if (in_skin_[v] != 0) skin_mm[f] += length;
    }
  }
  for (std::size_t f = 0; f < batch.frames; ++f) {
    out.pve_mm_curve.push_back(static_cast<float>(all_mm[f] / static_cast<double>(in_pve_count_)));
    if (skin_count_ > 0)
      sums.pve_face_mm.push_back(static_cast<float>(skin_mm[f] / static_cast<double>(skin_count_)));
  }
}

void Meter::add_landmarks(const Stretch& stretch, Sums& sums, Metrics& out) const {
  const std::size_t frames = stretch.truth.size();
  ThirdDifference truth_track(landmarks_.size()), estimate_track(landmarks_.size());
  for (std::size_t f = 0; f < frames; ++f) {
    double sum = 0;
    for (std::size_t p = 0; p < landmarks_.size(); ++p) {
      Vec3f truth = landmark_neutral_mm_[p];
      Vec3f estimate = truth;
      for (std::uint32_t i = shapes_.first[landmarks_[p]]; i < shapes_.first[landmarks_[p] + 1]; ++i) {
        truth += clipped(stretch.truth[f][shapes_.shape[i]]) * shapes_.delta_mm[i];
        estimate += clipped(stretch.estimate[f][shapes_.shape[i]]) * shapes_.delta_mm[i];
      }
      truth_track.set(f, p, truth);
      estimate_track.set(f, p, estimate);
      sum += (estimate - truth).norm();
    }
    out.lmk_mm_curve.push_back(static_cast<float>(sum / static_cast<double>(landmarks_.size())));
  }
  if (frames <= 3) return;
  const auto weight = static_cast<double>(frames - 3);
  sums.truth_jitter += weight * truth_track.mean();
  sums.estimate_jitter += weight * estimate_track.mean();
  sums.jitter_frames += frames - 3;
}

Metrics Meter::measure(std::span<const Stretch> stretches) const {
  Metrics out;
  Sums sums;
  for (const Stretch& stretch : stretches) {
    for (std::size_t first = 0; first < stretch.truth.size(); first += kBatch)
      add_vertices(add_weights(stretch, first, sums, out), sums, out);
    if (!landmarks_.empty()) add_landmarks(stretch, sums, out);
    out.frames += stretch.truth.size();
  }
  if (out.frames == 0) return out;

  std::size_t observed_shapes = 0;
  for (std::size_t k = 0; k < face::kShapeCount; ++k) observed_shapes += counts_in_mse_observed(k) ? 1 : 0;
  const auto count = static_cast<double>(out.frames);
  out.mse = sums.squares / (count * face::kShapeCount);
  out.mse_observed = sums.observed_squares / (count * static_cast<double>(observed_shapes));
  out.pve_mm = mean_std(out.pve_mm_curve);
  if (skin_count_ > 0) out.pve_face_mm = mean_std(sums.pve_face_mm);
  if (!landmarks_.empty()) out.lmk_mm = mean_std(out.lmk_mm_curve);
  if (sums.jitter_frames > 0 && sums.truth_jitter > 0)
    out.jitter_ratio = sums.estimate_jitter / sums.truth_jitter;
  out.blink_f1 = blink_f1(stretches);
  for (const Stretch& stretch : stretches) {
    out.truth_shut += static_cast<double>(std::ranges::count_if(stretch.truth, is_shut)) / count;
    out.shut += static_cast<double>(std::ranges::count_if(stretch.estimate, is_shut)) / count;
  }
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    out.per_shape[k].mae /= count;
    out.per_shape[k].pearson = pearson(stretches, k);
  }
  return out;
}

}  // namespace mien::measure
