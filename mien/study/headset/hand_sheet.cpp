#include "mien/study/headset/hand_sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

#include "mien/render/camera.h"
#include "mien/render/lettering.h"
#include "mien/render/renderer.h"

namespace mien::study {
namespace {

using face::OutputFrame;

constexpr int kPicture = 150, kSpace = 2, kHead = 22;
constexpr float kCloseness = 2;
constexpr render::Rgb kGround = {24, 24, 24}, kText = {220, 220, 220};
/// Of Multi-PIE: in the middle of the upper lip's lower edge.
constexpr std::size_t kLips = 62;

/// The picture in squares of its own pixels, as large as a face beside it.
render::Image enlarged(const std::vector<std::uint8_t>& view) {
  const auto side = static_cast<int>(std::lround(std::sqrt(static_cast<double>(view.size()))));
  render::Image out(kPicture, kPicture);
  for (int y = 0; y < kPicture; ++y)
    for (int x = 0; x < kPicture; ++x) {
      const auto from = static_cast<std::size_t>(y * side / kPicture * side + x * side / kPicture);
      std::fill_n(out.rgb.begin() + 3 * (static_cast<std::ptrdiff_t>(y) * kPicture + x), 3, view[from]);
    }
  return out;
}

/// Who answers for the jaw.
std::string_view answerer(const OutputFrame& frame) {
  switch (frame.provenance[face::shape("jawOpen")]) {
    case face::Provenance::held:
      return "held";
    case face::Provenance::audio:
      return "sound";
    case face::Provenance::neutral:
      return "neutral";
    default:
      return "cameras";
  }
}

}  // namespace

Result<render::Image> hand_sheet(const HandPerson& person, double hand_s, const face::Face& face,
                                 const std::string& font) {
  if (person.moments.empty()) return fail(ErrorCode::bad_usage, "there are no moments to show");
  std::optional<render::Lettering> lettering;
  if (!font.empty()) {
    MIEN_TRY_ASSIGN(lettering, render::Lettering::load(font));
  }
  const std::array<double, 6> times_s = {-0.2, 0.1, 0.5 * hand_s, hand_s - 0.1, hand_s + 0.1, hand_s + 0.3};
  const int above = lettering ? kHead : 0, row_height = kPicture + above + kSpace;
  render::Image sheet(static_cast<int>(times_s.size()) * (kPicture + kSpace), 4 * row_height, kGround);
  render::Camera camera =
      render::portrait_camera(face, render::kFrontView_rad, kPicture, kPicture, kCloseness);
  if (face.has_landmarks) {
    const float down_m = face.neutral_m[face.landmarks[kLips]].y() - camera.target_m.y();
    camera.position_m.y() += down_m;
    camera.target_m.y() += down_m;
  }
  render::Renderer renderer(face, render::Quality::still);
  std::vector<Vec3f> vertices_m(face.neutral_m.size());
  for (std::size_t c = 0; c < times_s.size(); ++c) {
    const HandMoment& moment = *std::ranges::min_element(
        person.moments, {}, [&](const HandMoment& one) { return std::abs(one.time_s - times_s[c]); });
    const int left = static_cast<int>(c) * (kPicture + kSpace);
    const auto put = [&](int row, const render::Image& picture, const std::string& text) {
      render::paste(sheet, picture, left, row * row_height + above);
      if (lettering)
        lettering->draw(sheet, text, static_cast<float>(left + 4),
                        static_cast<float>(row * row_height + kHead - 7), 14, kText);
    };
    const auto drawn = [&](const OutputFrame& frame) {
      face::evaluate(face, frame.weights, frame.tongue_out, vertices_m);
      face::turn_eyes(face, frame.weights, vertices_m);
      return renderer.still(vertices_m, camera, render::Look::dark());
    };
    put(0, enlarged(moment.mouth_view), fmt::format("{:+.1f} s", moment.time_s));
    put(1, drawn(moment.truth), "as it was");
    put(2, drawn(moment.held), fmt::format("no sound: {}", answerer(moment.held)));
    put(3, drawn(moment.heard), fmt::format("with sound: {}", answerer(moment.heard)));
  }
  return sheet;
}

}  // namespace mien::study
