#include "mien/mocap/marker_cleaning.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "mien/mocap/rigid_points.h"

namespace mien::mocap {
namespace {

const char* const kMarkerCleaning = "marker cleaning";
/// Slack of markers on a rigid body on the head: the cameras' noise, m.
constexpr double kBodySlackM = 0.5e-3;

/// The markers of a frame from which the head pose is fitted.
struct References {
  const MarkerTrack* track = nullptr;
  std::vector<std::size_t> markers;
  std::vector<double> slack_m;

  [[nodiscard]] std::vector<Vec3f> seen(std::size_t frame) const {
    std::vector<Vec3f> points;
    for (const std::size_t m : markers) points.push_back(track->frame(frame)[m]);
    return points;
  }
};

/// Reference markers' relative places, from the recording itself, in the axes of its first complete frame.
/// None where no frame has three.
std::optional<RigidPoints> learn_body(const References& references) {
  std::size_t best = 0, most = 0;
  for (std::size_t i = 0; i < references.track->frames(); ++i) {
    const auto count = static_cast<std::size_t>(
        std::ranges::count_if(references.seen(i), [](const Vec3f& p) { return is_seen(p); }));
    if (count <= most) continue;
    best = i;
    most = count;
    if (most == references.markers.size()) break;
  }
  RigidPoints body;
  body.slack_m = references.slack_m;
  for (const Vec3f& point : references.seen(best)) body.place_m.emplace_back(point.cast<double>());
  // The initial frame may contain an expression, medians contain less of it. Two rounds, since the first is
  // aligned to that frame.
  for (int round = 0; round < 2; ++round) {
    // Markers missing in the initial frame come from the frames that have them.
    RigidPoints known = body;
    for (std::size_t k = 0; k < known.place_m.size(); ++k)
      if (!known.place_m[k].allFinite()) {
        known.place_m[k].setZero();
        known.slack_m[k] = 1e3;
      }
    MarkerTrack aligned;
    aligned.markers.resize(references.markers.size());
    for (std::size_t i = 0; i < references.track->frames(); ++i) {
      std::vector<Vec3f> seen = references.seen(i);
      std::vector<Vec3f> used = seen;
      for (std::size_t k = 0; k < used.size(); ++k)
        if (!body.place_m[k].allFinite()) used[k] = kLostMarker;
      const auto fit = fit_rigid(known, used);
      if (!fit) continue;
      aligned.time_s.push_back(references.track->time_s[i]);
      for (const Vec3f& point : seen)
        aligned.position_m.push_back(is_seen(point) ? Vec3f((*fit * point.cast<double>()).cast<float>())
                                                    : kLostMarker);
    }
    if (aligned.frames() == 0) return std::nullopt;
    const std::vector<Vec3f> places = usual_places(aligned);
    for (std::size_t k = 0; k < places.size(); ++k) body.place_m[k] = places[k].cast<double>();
  }
  // One never seen together with the others is never needed.
  for (std::size_t k = 0; k < body.place_m.size(); ++k)
    if (!body.place_m[k].allFinite()) body.place_m[k] = Vec3::Constant(1e3);
  return body;
}

MarkerTrack moved(const MarkerTrack& track, std::span<const std::optional<Eigen::Isometry3d>> fits) {
  MarkerTrack out = track;
  for (std::size_t i = 0; i < out.frames(); ++i)
    for (Vec3f& point : out.frame(i))
      point =
          fits[i] && is_seen(point) ? Vec3f((*fits[i] * point.cast<double>()).cast<float>()) : kLostMarker;
  return out;
}

std::vector<std::optional<Eigen::Isometry3d>> fit_frames(const References& references,
                                                         const RigidPoints& body) {
  std::vector<std::optional<Eigen::Isometry3d>> fits;
  for (std::size_t i = 0; i < references.track->frames(); ++i)
    fits.push_back(fit_rigid(body, references.seen(i)));
  return fits;
}

/// Marker positions at neutral; kLostMarker where not seen then.
Result<std::vector<Vec3f>> neutral_places(const MarkerTrack& track, std::pair<double, double> span_s) {
  MarkerTrack neutral;
  neutral.markers = track.markers;
  for (std::size_t i = 0; i < track.frames(); ++i) {
    const double from_start_s = track.time_s[i] - track.time_s.front();
    if (from_start_s < span_s.first || from_start_s > span_s.second) continue;
    neutral.time_s.push_back(track.time_s[i]);
    neutral.position_m.insert(neutral.position_m.end(), track.frame(i).begin(), track.frame(i).end());
  }
  if (neutral.frames() == 0)
    return fail(ErrorCode::bad_usage, "no frame lies in the neutral's time", kMarkerCleaning,
                "give it in seconds from the recording's start");
  return usual_places(neutral);
}

/// From the aligned head frame to the model's frame H: rotation (p_h = turn * p) and scale.
struct ToModel {
  Eigen::Isometry3d turn = Eigen::Isometry3d::Identity();
  double scale = 1;
};

Result<ToModel> to_model(const std::vector<Vec3f>& places, const builtin_face::PlacedMarkers& placed,
                         bool with_scale) {
  std::vector<std::size_t> used;
  if (with_scale) {
    for (std::size_t i = 0; i < places.size(); ++i) used.push_back(i);
  } else {
    for (const ReferenceMarker& reference : reference_markers(placed)) used.push_back(reference.marker);
  }
  std::erase_if(used, [&](std::size_t i) { return !is_seen(places[i]); });
  Eigen::Matrix3Xd from(3, static_cast<Eigen::Index>(used.size())), to = from;
  for (std::size_t k = 0; k < used.size(); ++k) {
    from.col(static_cast<Eigen::Index>(k)) = places[used[k]].cast<double>();
    to.col(static_cast<Eigen::Index>(k)) = placed.neutral_m()[used[k]];
  }
  // A pose needs three markers not on one line.
  const Eigen::Matrix3Xd spread = to.colwise() - to.rowwise().mean();
  const Vec3 square = Eigen::SelfAdjointEigenSolver<Mat3>(spread * spread.transpose(), Eigen::EigenvaluesOnly)
                          .eigenvalues();  // Of the singular values, the smallest first.
  if (used.size() < 3 || square[1] < 5e-3 * 5e-3)
    return fail(ErrorCode::not_found, "too few markers to lay the recording onto the face", kMarkerCleaning,
                "three that are not in one line are the least");
  const Eigen::Matrix4d fit = Eigen::umeyama(from, to, with_scale);
  ToModel model;
  model.scale = with_scale ? std::cbrt(fit.topLeftCorner<3, 3>().determinant()) : 1;
  model.turn.linear() = fit.topLeftCorner<3, 3>() / model.scale;
  model.turn.translation() = fit.topRightCorner<3, 1>();
  return model;
}

std::size_t lose_outliers(MarkerTrack& track, double sigmas) {
  std::size_t rejected = 0;
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(track.frames()), 3);
  for (std::size_t m = 0; m < track.count(); ++m) {
    std::size_t seen = 0;
    for (std::size_t i = 0; i < track.frames(); ++i) {
      const Vec3f& point = track.frame(i)[m];
      seen += is_seen(point) ? 1 : 0;
      rows.row(static_cast<Eigen::Index>(i)) = point.cast<double>().transpose();
    }
    const Kept kept = reject_outliers(rows, sigmas);
    rejected += seen - kept.rows.size();
    auto next = kept.rows.begin();
    for (std::size_t i = 0; i < track.frames(); ++i) {
      if (next != kept.rows.end() && *next == i)
        ++next;
      else
        track.frame(i)[m] = kLostMarker;
    }
  }
  return rejected;
}

std::size_t count_lost(const MarkerTrack& track) {
  return static_cast<std::size_t>(
      std::ranges::count_if(track.position_m, [](const Vec3f& point) { return !is_seen(point); }));
}

}  // namespace

Result<CleanMarkers> clean_markers(const MatchedTrack& matched, const builtin_face::PlacedMarkers& placed,
                                   const CleaningSettings& settings) {
  if (matched.face.count() != placed.count() || matched.face.frames() == 0)
    return fail(ErrorCode::mismatch, "the recording's markers are not those on the face", kMarkerCleaning);
  if (!(settings.outlier_sigmas >= 1) ||
      (settings.neutral_s &&
       !(settings.neutral_s->first >= 0 && settings.neutral_s->second > settings.neutral_s->first)))
    return fail(ErrorCode::bad_usage, "less than one sigma, or a neutral that ends before it begins",
                kMarkerCleaning);
  CleanMarkers clean;
  CleaningReport& report = clean.report;
  report.frames = matched.face.frames();
  report.samples = matched.face.position_m.size();
  report.lost = count_lost(matched.face);

  // First the labels, in a head-fixed frame; then the head pose again, by correctly labelled markers.
  std::vector<std::optional<Eigen::Isometry3d>> fits(report.frames, Eigen::Isometry3d::Identity());
  MarkerTrack named = matched.face;  // In the cameras' frame.
  if (settings.remove_head) {
    References references;
    const bool body_worn = matched.head.count() > 0;
    references.track = body_worn ? &matched.head : &named;
    for (std::size_t m = 0; m < matched.head.count(); ++m) {
      references.markers.push_back(m);
      references.slack_m.push_back(kBodySlackM);
    }
    if (!body_worn)
      for (const ReferenceMarker& reference : reference_markers(placed)) {
        references.markers.push_back(reference.marker);
        references.slack_m.push_back(reference.slack_m);
      }
    for (int round = 0; round < (body_worn ? 1 : 2); ++round) {
      const auto body = learn_body(references);
      if (!body)
        return fail(ErrorCode::not_found, "no frame has three of the markers that tell the head's place",
                    kMarkerCleaning,
                    "see docs/method/markers.md for which these are, or wear a body on the head and name it "
                    "with --head");
      fits = fit_frames(references, *body);
      if (body_worn || round > 0) break;
      MarkerTrack still = moved(named, fits);
      const std::vector<MarkerSwap> swaps = mend_swaps(still);
      for (const MarkerSwap& swap : swaps)
        for (std::size_t i = swap.begin; i < swap.end; ++i)
          if (swap.mended)
            std::swap(named.frame(i)[swap.a], named.frame(i)[swap.b]);
          else
            named.frame(i)[swap.a] = named.frame(i)[swap.b] = kLostMarker;
      clean.swaps = swaps;
    }
  }
  report.without_head =
      static_cast<std::size_t>(std::ranges::count_if(fits, [](const auto& fit) { return !fit.has_value(); }));
  clean.track = moved(named, fits);
  // Swaps visible with the better head pose, and all of them where the first round had none to correct.
  for (const MarkerSwap& swap : mend_swaps(clean.track)) clean.swaps.push_back(swap);
  for (const MarkerSwap& swap : clean.swaps) {
    const std::size_t samples = 2 * (swap.end - swap.begin);
    (swap.mended ? report.mended : report.not_mended) += samples;
  }
  report.swaps = clean.swaps.size();
  clean.strays = lose_strays(clean.track);
  report.strays = clean.strays.size();
  for (const MarkerStray& stray : clean.strays) report.strayed += stray.end - stray.begin;

  std::vector<Vec3f> places = usual_places(clean.track);
  if (settings.neutral_s) {
    MIEN_TRY_ASSIGN(places, neutral_places(clean.track, *settings.neutral_s));
  }
  ToModel model;
  if (settings.remove_head) {
    MIEN_TRY_ASSIGN(model, to_model(places, placed, settings.neutral_s.has_value()));
  }
  report.scale = model.scale;
  report.outliers = lose_outliers(clean.track, settings.outlier_sigmas);
  for (std::size_t i = 0; i < clean.track.frames(); ++i) {
    const auto frame = clean.track.frame(i);
    for (std::size_t m = 0; m < frame.size(); ++m) {
      if (!is_seen(frame[m])) continue;
      // Only the displacement from the performer's neutral is used, at the model's scale.
      Vec3 p = frame[m].cast<double>();
      if (settings.neutral_s) {
        const Vec3 from_neutral = model.scale * (model.turn.linear() * (p - places[m].cast<double>()));
        p = is_seen(places[m]) ? Vec3(placed.neutral_m()[m] + from_neutral)
                               : Vec3(kLostMarker.cast<double>());
      } else {
        p = model.turn * p;
      }
      frame[m] = p.cast<float>();
    }
    clean.head.push_back(fits[i] ? std::optional(Eigen::Isometry3d((model.turn * *fits[i]).inverse()))
                                 : std::nullopt);
  }
  return clean;
}

}  // namespace mien::mocap
