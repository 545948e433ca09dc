#pragma once

#include <algorithm>
#include <array>
#include <iterator>
#include <memory>
#include <vector>

#include "mien/headset/feature_reducer.h"
#include "mien/headset/headset_tracker.h"
#include "mien/headset/picture_statistics.h"
#include "mien/sensor/clock_model.h"
#include "tests/headset/small_jpeg.h"
#include "tests/headset/small_model.h"

// A headset on a face, for tests of its tracker.
namespace mien::headset::test {

inline const std::size_t kJaw = face::shape("jawOpen"), kBlinkL = face::shape("eyeBlink_L");

/// A network whose answer is the same whatever it sees, as its output layer's bias has it.
inline ViewsFile constant_file(const Answer& answer) {
  ViewsFile file = small_views_file();
  std::array<float, kAnswerOutputs> outputs{};
  encode_answer(answer, outputs);
  model::Tensor& weight = file.network[file.network.size() - 2];
  model::Tensor& bias = file.network.back();
  std::ranges::fill(weight.values, 0.0F);
  std::ranges::copy(outputs, bias.values.begin());
  return file;
}

/// A headset that is worn for a while: pictures at 60 Hz, frames between them.
class Worn {
 public:
  explicit Worn(std::shared_ptr<const HeadsetModel> model = small_model())
      : tracker(HeadsetTracker::create(headset_rig(), model).value()),
        reducer_(FeatureReducer::create(headset_rig(), model).value()) {}

  std::unique_ptr<HeadsetTracker> tracker;
  sensor::TimeLines lines{4, std::uint16_t{0}};
  std::array<bool, 4> sends{true, true, true, true};
  std::array<bool, 4> stands_still{};
  int first_picture = 0, pictures = 40;  // What the cameras see is of these.
  bool raw = false;
  std::int64_t index = 0;
  face::OutputFrame frame;
  tracker::TickResult result;
  std::vector<tracker::CalibrationEvent> events;
  std::vector<tracker::RestOutcome> rests;

  DeviceTime now() const { return DeviceTime(frame_offset(index)); }
  void step() {
    for (std::uint16_t c = 0; c < 4; ++c)
      if (sends[c])
        send(c, stands_still[c] ? 0 : first_picture + static_cast<int>((index + 7 * c) % pictures));
    result = tracker->tick(now(), lines, frame);
    std::ranges::copy(result.calibration, std::back_inserter(events));
    if (result.rested) rests.push_back(*result.rested);
    ++index;
  }
  void run(double seconds) {
    for (auto n = static_cast<int>(60 * seconds); n > 0; --n) step();
  }
  /// A picture whose exposure's middle is at the frame.
  void send(std::uint16_t camera, int number) {
    const Bytes& jpeg = picture(number);
    sensor::Sample sample;
    sample.sensor = camera;
    sample.kind = sensor::SampleKind::picture;
    sample.time = now() + std::chrono::milliseconds(2);
    const HostTime arrival(sample.time.time_since_epoch() + std::chrono::milliseconds(3));
    lines.add(arrival, sample);
    std::span<const std::byte> payload = jpeg;
    if (!raw) payload = std::span(record_).first(reducer_.reduce_picture(camera, jpeg, record_).value());
    tracker->add_with_payload(arrival, sample, payload);
  }

 private:
  static const Bytes& picture(int number) {
    static const std::vector<Bytes> pictures = [] {
      std::vector<Bytes> made;
      for (int n = 0; n < 40; ++n) made.push_back(grey_jpeg(64, 64, n));
      return made;
    }();
    return pictures[static_cast<std::size_t>(number)];
  }
  FeatureReducer reducer_;
  Bytes record_ = Bytes(sensor::kMaxPayload);
};

inline Answer telling_answer() {
  Answer answer;
  answer.weights[kJaw] = 0.5F;
  answer.weights[kBlinkL] = 0.25F;
  answer.tongue_out = 0.2F;
  answer.gaze_rad = {0.2F, -0.1F, 0.15F, -0.1F};
  return answer;
}

}  // namespace mien::headset::test
