#include "mien/performer/gaze.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mien/core/units.h"
#include "mien/performer/canvas.h"

namespace mien::performer {

using face::shape;

namespace {

/// Eye rotation of a full eyeLook weight, rad, in single precision.
constexpr auto kGazeRadiansPerUnit = static_cast<float>(face::kEyeTurnRadPerUnit);
constexpr double kHalfPupilDistance_m = 0.0315;
constexpr double kLargeShift_rad = 8 * kRadPerDeg;

/// Draws one fixation after the other and writes the track as it goes.
class Eyes {
 public:
  Eyes(std::size_t frame_count, const Eigen::Vector2f& rest_rad, double range, Random random)
      : random_(random), rest_(rest_rad.cast<double>()), range_(range), at_(rest_) {
    track_.direction_rad.reserve(frame_count);
    track_.vergence_rad.reserve(frame_count);
    frame_count_ = frame_count;
    vergence_ = draw_vergence();
  }

  GazeTrack run(std::span<const GazeEpisode> episodes) {
    SmoothNoise drift_yaw(0.8, random_);
    SmoothNoise drift_pitch(0.8, random_);
    std::size_t episode = 0;
    while (written() < frame_count_) {
      const double now = time_s();
      while (episode + 1 < episodes.size() && episodes[episode + 1].begin_s <= now) ++episode;
      step(episodes.empty() ? GazeTask::conversation : episodes[episode].task);
    }
    for (std::size_t i = 0; i < frame_count_; ++i) {
      track_.direction_rad[i].x() += static_cast<float>(0.12 * kRadPerDeg * drift_yaw.next(random_));
      track_.direction_rad[i].y() += static_cast<float>(0.12 * kRadPerDeg * drift_pitch.next(random_));
    }
    return std::move(track_);
  }

 private:
  [[nodiscard]] std::size_t written() const { return track_.direction_rad.size(); }
  [[nodiscard]] double time_s() const { return static_cast<double>(written()) / kFrameRateHz; }

  void write(const Eigen::Vector2d& direction, double vergence) {
    if (written() >= frame_count_) return;
    track_.direction_rad.push_back(direction.cast<float>());
    track_.vergence_rad.push_back(static_cast<float>(vergence));
  }
  void fixate(double seconds) {
    const double end = time_s() + seconds;
    do write(at_, vergence_);
    while (time_s() < end && written() < frame_count_);
  }
  /// Eyes turn no further than this; heads turn for the rest.
  static Eigen::Vector2d within_reach(const Eigen::Vector2d& to) {
    return {std::clamp(to.x(), -32 * kRadPerDeg, 32 * kRadPerDeg),
            std::clamp(to.y(), -28 * kRadPerDeg, 24 * kRadPerDeg)};
  }
  void jump(Eigen::Vector2d to) {
    to = within_reach(to);
    const double size = (to - at_).norm();
    if (size > kLargeShift_rad) track_.shifts_s.push_back(time_s());
    const double seconds = 0.021 + 0.0022 * size / kRadPerDeg;
    const double begin = time_s();
    const double new_vergence = size > 4 * kRadPerDeg ? draw_vergence() : vergence_;
    // Vergence itself is slow; it creeps over the fixation's first frames here as part of the saccade.
    for (double u = 0.5 / kFrameRateHz / seconds; u < 1; u = (time_s() - begin) / seconds) {
      if (written() >= frame_count_) break;
      write(at_ + minimum_jerk(u) * (to - at_), vergence_ + minimum_jerk(u) * (new_vergence - vergence_));
    }
    at_ = to;
    vergence_ = new_vergence;
  }
  void pursue() {
    const double seconds = random_.uniform(0.8, 3.0);
    const double heading = random_.uniform(0, 2 * std::numbers::pi);
    const double amplitude = random_.uniform(4, 16) * kRadPerDeg * range_;
    const double cycles = random_.uniform(0.3, 1.2);
    const Eigen::Vector2d axis(std::cos(heading), 0.6 * std::sin(heading));
    const Eigen::Vector2d start = at_;
    const double begin = time_s();
    while (written() < frame_count_ && time_s() - begin < seconds) {
      const double u = (time_s() - begin) / seconds;
      const double sway = std::sin(2 * std::numbers::pi * cycles * u) * std::min(1.0, 6 * u);
      at_ = within_reach(start + amplitude * sway * axis);
      write(at_, vergence_);
    }
  }
  double draw_vergence() {
    // What one looks at stands 0.35 to 4 m away.
    return std::atan(kHalfPupilDistance_m / std::exp(random_.uniform(std::log(0.35), std::log(4.0))));
  }

  void step(GazeTask task) {
    switch (task) {
      case GazeTask::still:
        jump(rest_ + 0.4 * kRadPerDeg * Eigen::Vector2d{random_.normal(), random_.normal()});
        fixate(random_.uniform(0.4, 1.5));
        break;
      case GazeTask::conversation: {
        // Two fixations of three on the partner, the rest aside or down.
        if (random_.chance(0.65)) {
          jump(rest_ + range_ * kRadPerDeg * Eigen::Vector2d{2.0 * random_.normal(), 1.5 * random_.normal()});
          fixate(std::clamp(0.9 * random_.log_normal(0.7), 0.2, 5.0));
        } else {
          jump(rest_ +
               range_ * kRadPerDeg * Eigen::Vector2d{11.0 * random_.normal(), 6.0 * random_.normal() - 2});
          fixate(std::clamp(0.5 * random_.log_normal(0.6), 0.15, 2.5));
        }
        break;
      }
      case GazeTask::reading:
        read_on();
        break;
      case GazeTask::wandering:
        if (random_.chance(0.15)) {
          pursue();
        } else {
          jump(rest_ +
               range_ * kRadPerDeg * Eigen::Vector2d{13.0 * random_.normal(), 8.0 * random_.normal()});
          fixate(std::clamp(0.45 * random_.log_normal(0.9), 0.12, 5.0));
        }
        break;
    }
  }
  /// One fixation along the line, or the sweep to the next.
  void read_on() {
    if (line_x_ < -line_half_) {
      line_x_ = line_half_ * random_.uniform(0.9, 1.0);
      line_y_ -= random_.uniform(1.0, 1.6) * kRadPerDeg;
      if (line_y_ < -7 * kRadPerDeg) line_y_ = random_.uniform(0, 3) * kRadPerDeg;
    }
    jump(rest_ + Eigen::Vector2d(line_x_, line_y_) +
         0.15 * kRadPerDeg * Eigen::Vector2d(0, random_.normal()));
    fixate(std::clamp(0.23 * random_.log_normal(0.3), 0.1, 0.6));
    const double hop = random_.uniform(1.2, 3.0) * kRadPerDeg;
    line_x_ += random_.chance(0.1) ? hop : -hop;
  }

  Random random_;
  Eigen::Vector2d rest_;
  double range_;
  Eigen::Vector2d at_;
  double vergence_ = 0;
  double line_half_ = 8 * kRadPerDeg;
  double line_x_ = 8 * kRadPerDeg;
  double line_y_ = 0;
  std::size_t frame_count_ = 0;
  GazeTrack track_;
};

}  // namespace

GazeTrack draw_gaze(std::size_t frame_count, std::span<const GazeEpisode> episodes,
                    const Eigen::Vector2f& rest_rad, double range, Random random) {
  return Eyes(frame_count, rest_rad, range, random).run(episodes);
}

void set_eye_look(face::BlendshapeWeights& weights, const Eigen::Vector2f& direction_rad,
                  float vergence_rad) {
  const auto positive = [](float radians) { return std::max(0.0F, radians / kGazeRadiansPerUnit); };
  const float left = direction_rad.x() - vergence_rad;
  const float right = direction_rad.x() + vergence_rad;
  const float up = direction_rad.y();
  weights[shape("eyeLookOut_L")] = positive(left);
  weights[shape("eyeLookIn_L")] = positive(-left);
  weights[shape("eyeLookIn_R")] = positive(right);
  weights[shape("eyeLookOut_R")] = positive(-right);
  weights[shape("eyeLookUp_L")] = positive(up);
  weights[shape("eyeLookUp_R")] = positive(up);
  weights[shape("eyeLookDown_L")] = positive(-up);
  weights[shape("eyeLookDown_R")] = positive(-up);
}

}  // namespace mien::performer
