#include "app/film.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <vector>

#include "app/media_helper.h"
#include "mien/core/smoothstep.h"
#include "mien/render/comparison.h"

namespace mien::app {
namespace {

/// From the chin down to where nothing turns any more.
constexpr float kNeck_m = 0.075F;

/// Turns the head on its neck: all of it above the chin, nothing at the shoulders, so that a bust stands
/// still.
void turn_head(const face::Face& face, const face::MotionFrame& frame, std::span<Vec3f> vertices_m) {
  float lowest = face.neutral_m.front().y();
  for (const Vec3f& p : face.neutral_m) lowest = std::min(lowest, p.y());
  float chin = lowest;
  if (face.has_landmarks) {
    chin = face.neutral_m[face.landmarks[8]].y();
    lowest = std::max(lowest, chin - kNeck_m);
  }
  // The skull turns about the top of the neck, which lies under the ears, level with the mouth.
  Vec3f pivot = Vec3f(0, chin, 0);
  if (face.has_landmarks)
    pivot.z() =
        0.5F * (face.neutral_m[face.landmarks[0]].z() + face.neutral_m[face.landmarks[16]].z()) - 0.02F;
  const Vec3f turn = log_rotation(frame.head).cast<float>();
  const float angle = turn.norm();
  if (angle < 1e-6F) return;
  const Vec3f axis = turn / angle;
  for (std::size_t i = 0; i < vertices_m.size(); ++i) {
    const float share = chin > lowest ? smoothstep(lowest, chin, face.neutral_m[i].y()) : 1.0F;
    vertices_m[i] = pivot + Eigen::AngleAxisf(share * angle, axis) * (vertices_m[i] - pivot);
  }
}

void pose(const face::Face& face, const face::MotionFrame& frame,
          std::span<const face::Corrective> correctives, std::span<Vec3f> vertices_m) {
  face::evaluate(face, frame.weights, frame.tongue_out, vertices_m);
  face::add_correctives(correctives, frame.weights, vertices_m);
  face::turn_eyes(face, frame.weights, vertices_m);
}

std::optional<Sound> cut(const std::optional<Sound>& sound, double from_s, double until_s) {
  if (!sound) return std::nullopt;
  const auto at = [&](double time_s) {
    return std::min(sound->samples.size(), static_cast<std::size_t>(std::max(0.0, time_s) * sound->rate_hz));
  };
  Sound part{.rate_hz = sound->rate_hz, .samples = {}};
  part.samples.assign(
      sound->samples.begin() + static_cast<std::ptrdiff_t>(at(from_s)),
      sound->samples.begin() + static_cast<std::ptrdiff_t>(std::max(at(from_s), at(until_s))));
  return part;
}

Result<FilmMade> film(double from_s, double until_s, int columns, const FilmOptions& options,
                      const std::filesystem::path& out, const Progress& progress,
                      const std::function<render::Image(double time_s)>& draw) {
  const auto start = std::chrono::steady_clock::now();
  from_s = std::max(from_s, options.from_s);
  until_s = std::min(until_s, options.until_s);
  if (!(until_s >= from_s))
    return fail(ErrorCode::bad_usage,
                fmt::format("there is nothing between {:.3f} s and {:.3f} s", from_s, until_s), out.string(),
                "choose a span inside the motion");
  const auto frames = static_cast<int>(std::floor((until_s - from_s) * options.rate_hz + 1e-6)) + 1;
  MIEN_TRY_ASSIGN(auto writer, FilmWriter::start(out, columns * options.width, options.height,
                                                 options.rate_hz, cut(options.sound, from_s, until_s)));
  for (int i = 0; i < frames; ++i) {
    const Result<void> added = writer.add_frame(draw(from_s + i / options.rate_hz));
    // (A stop from the terminal stops the film's writer as well.)
    if (!progress(static_cast<double>(i + 1) / frames, fmt::format("frame {} of {}", i + 1, frames)))
      return fail(ErrorCode::cancelled, "stopped", out.string(), "nothing was written");
    MIEN_TRY(added);
  }
  MIEN_TRY(writer.finish());
  return FilmMade{.frames = frames,
                  .duration_s = frames / options.rate_hz,
                  .seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count()};
}

}  // namespace

Result<FilmMade> film_motion(const face::Face& face, const face::Motion& motion, const FilmOptions& options,
                             const std::filesystem::path& out, const Progress& progress) {
  if (motion.frames.empty()) return fail(ErrorCode::bad_usage, "the motion has no frames", motion.name);
  const face::MotionCurve curve(motion);
  render::Renderer renderer(face, options.quality, 0, options.folds, options.marks);
  const render::Camera camera =
      render::portrait_camera(face, options.view_rad, options.width, options.height, options.closeness);
  std::vector<Vec3f> vertices_m(face.neutral_m.size());
  return film(0, motion.duration_s(), 1, options, out, progress, [&](double time_s) {
    const face::MotionFrame frame = curve.at(time_s);
    pose(face, frame, options.correctives, vertices_m);
    turn_head(face, frame, vertices_m);
    return renderer.still(vertices_m, camera, options.look);
  });
}

Result<FilmMade> film_comparison(const face::Face& face, const face::Motion& truth,
                                 const face::Motion& capture, double capture_delay_s,
                                 const FilmOptions& options, const std::filesystem::path& out,
                                 const Progress& progress) {
  if (truth.frames.empty() || capture.frames.empty())
    return fail(ErrorCode::bad_usage, "the motion has no frames",
                truth.frames.empty() ? truth.name : capture.name);
  const face::MotionCurve true_curve(truth), capture_curve(capture);
  MIEN_TRY_ASSIGN(const auto lettering, render::Lettering::load());
  render::Renderer renderer(face, options.quality, 0, options.folds, options.marks);
  const render::Camera camera =
      render::portrait_camera(face, options.view_rad, options.width, options.height, options.closeness);
  std::vector<Vec3f> true_m(face.neutral_m.size()), captured_m(face.neutral_m.size());
  const double from_s = std::max(0.0, capture_delay_s);
  const double until_s = std::min(truth.duration_s(), capture.duration_s() + capture_delay_s);
  return film(from_s, until_s, 3, options, out, progress, [&](double time_s) {
    pose(face, true_curve.at(time_s), {}, true_m);
    pose(face, capture_curve.at(time_s - capture_delay_s), {}, captured_m);
    render::ComparisonCaptions captions;
    captions.footer = fmt::format("{:.2f} s", time_s);
    return render::comparison(renderer, lettering, true_m, captured_m, camera, options.look, captions,
                              options.full_scale_m);
  });
}

}  // namespace mien::app
