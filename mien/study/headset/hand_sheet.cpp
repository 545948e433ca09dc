#include "mien/study/headset/hand_sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>
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

struct HandPainter::State {
  State(const face::Face& drawn, std::optional<render::Lettering> letters)
      : face(drawn),
        lettering(std::move(letters)),
        above(lettering ? kHead : 0),
        camera(render::portrait_camera(face, render::kFrontView_rad, kPicture, kPicture, kCloseness)),
        renderer(face, render::Quality::still),
        vertices_m(face.neutral_m.size()) {
    if (!face.has_landmarks) return;
    const float down_m = face.neutral_m[face.landmarks[kLips]].y() - camera.target_m.y();
    camera.position_m.y() += down_m;
    camera.target_m.y() += down_m;
  }

  render::Image panel(const render::Image& picture, const std::string& heading) const {
    render::Image out(kPicture + kSpace, kPicture + above + kSpace, kGround);
    render::paste(out, picture, 0, above);
    if (lettering) lettering->draw(out, heading, 4, kHead - 7, 14, kText);
    return out;
  }
  render::Image draw(const OutputFrame& frame) {
    face::evaluate(face, frame.weights, frame.tongue_out, vertices_m);
    face::turn_eyes(face, frame.weights, vertices_m);
    return renderer.still(vertices_m, camera, render::Look::dark());
  }

  const face::Face& face;
  std::optional<render::Lettering> lettering;
  int above;
  render::Camera camera;
  render::Renderer renderer;
  std::vector<Vec3f> vertices_m;
};

HandPainter::HandPainter(std::unique_ptr<State> state) : state_(std::move(state)) {}
HandPainter::HandPainter(HandPainter&&) noexcept = default;
HandPainter& HandPainter::operator=(HandPainter&&) noexcept = default;
HandPainter::~HandPainter() = default;

Result<HandPainter> HandPainter::create(const face::Face& face, const std::string& font) {
  std::optional<render::Lettering> lettering;
  if (!font.empty()) {
    MIEN_TRY_ASSIGN(lettering, render::Lettering::load(font));
  }
  return HandPainter(std::make_unique<State>(face, std::move(lettering)));
}

std::array<render::Image, HandPainter::kPanels> HandPainter::panels(const HandMoment& moment) {
  State& s = *state_;
  return {s.panel(enlarged(moment.mouth_view), fmt::format("{:+.1f} s", moment.time_s)),
          s.panel(s.draw(moment.truth), "as it was"),
          s.panel(s.draw(moment.held), fmt::format("no sound: {}", answerer(moment.held))),
          s.panel(s.draw(moment.heard), fmt::format("with sound: {}", answerer(moment.heard)))};
}

render::Image HandPainter::across(const HandMoment& moment) {
  const auto drawn = panels(moment);
  render::Image out(static_cast<int>(kPanels) * drawn.front().width, drawn.front().height, kGround);
  for (std::size_t p = 0; p < kPanels; ++p)
    render::paste(out, drawn[p], static_cast<int>(p) * drawn[p].width, 0);
  return out;
}

Result<render::Image> hand_sheet(const HandPerson& person, double hand_s, const face::Face& face,
                                 const std::string& font) {
  if (person.moments.empty()) return fail(ErrorCode::bad_usage, "there are no moments to show");
  MIEN_TRY_ASSIGN(HandPainter painter, HandPainter::create(face, font));
  const std::array<double, 6> times_s = {-0.2, 0.1, 0.5 * hand_s, hand_s - 0.1, hand_s + 0.1, hand_s + 0.3};
  std::optional<render::Image> sheet;
  for (std::size_t c = 0; c < times_s.size(); ++c) {
    const HandMoment& moment = *std::ranges::min_element(
        person.moments, {}, [&](const HandMoment& one) { return std::abs(one.time_s - times_s[c]); });
    const auto drawn = painter.panels(moment);
    const int width = drawn.front().width, height = drawn.front().height;
    if (!sheet)
      sheet.emplace(static_cast<int>(times_s.size()) * width, static_cast<int>(drawn.size()) * height,
                    kGround);
    for (std::size_t row = 0; row < drawn.size(); ++row)
      render::paste(*sheet, drawn[row], static_cast<int>(c) * width, static_cast<int>(row) * height);
  }
  return *std::move(sheet);
}

}  // namespace mien::study
