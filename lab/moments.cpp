#include "lab/moments.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "mien/render/camera.h"
#include "mien/render/lettering.h"
#include "mien/render/renderer.h"

namespace mien::lab {
namespace {

constexpr int kMomentsGap_px = 2, kLargestSide_px = 16384;
constexpr render::Rgb kMomentsInk = {40, 42, 48}, kUnseenInk = {132, 138, 148};

bool is_seen(const std::optional<face::BlendshapeWeights>& weights) {
  return weights && std::ranges::all_of(weights->values, [](float w) { return std::isfinite(w); });
}

/// A line of words in a box, smaller where it would not fit.
struct MomentsPen {
  render::Image& picture;
  const render::Lettering& lettering;
  float size_px;

  void write(std::string_view words, int left, int middle_y, int width, render::Align align,
             render::Rgb ink) const {
    const auto room = static_cast<float>(width) - size_px;
    const float size = size_px * std::min(1.0F, room / std::max(1.0F, lettering.width(words, size_px)));
    const float x = static_cast<float>(left) +
                    (align == render::Align::centre ? 0.5F * static_cast<float>(width) : 0.5F * size_px);
    lettering.draw(picture, words, x, static_cast<float>(middle_y) + 0.35F * size, size, ink, align);
  }
};

}  // namespace

Result<render::Image> moments_strip(const face::Face& face, std::span<const MomentRow> rows,
                                    std::span<const std::string> captions, int cell_px) {
  if (rows.empty() || captions.empty()) return fail(ErrorCode::bad_usage, "there is no moment to show");
  if (cell_px < 64 || cell_px > 640)
    return fail(ErrorCode::bad_usage, fmt::format("a cell has 64 to 640 pixels, not {}", cell_px));
  for (const MomentRow& row : rows)
    if (row.weights.size() != captions.size())
      return fail(ErrorCode::bad_usage,
                  fmt::format("{} moments are shown, not {}", captions.size(), row.weights.size()), row.name);
  const std::size_t most = static_cast<std::size_t>(kLargestSide_px / (cell_px + kMomentsGap_px)) - 2;
  if (captions.size() > most || rows.size() > most)
    return fail(ErrorCode::bad_usage,
                fmt::format("a picture has room for {} cells of {} pixels either way", most, cell_px));
  MIEN_TRY_ASSIGN(const auto lettering, render::Lettering::load());

  const float size = std::clamp(0.075F * static_cast<float>(cell_px), 11.0F, 20.0F);
  float widest = 0;
  for (const MomentRow& row : rows) widest = std::max(widest, lettering.width(row.name, size));
  const int step = cell_px + kMomentsGap_px, above = static_cast<int>(2 * size);
  const int beside = std::min(cell_px, static_cast<int>(std::ceil(widest + 1.2F * size)));
  const render::Look look = render::Look::light();
  const render::Camera camera = render::portrait_camera(face, render::kFrontView_rad, cell_px, cell_px, 1.3F);
  render::Image picture(beside + static_cast<int>(captions.size()) * step,
                        above + static_cast<int>(rows.size()) * step, look.background_top);
  const MomentsPen pen{picture, lettering, size};
  const auto left_of = [&](std::size_t column) { return beside + static_cast<int>(column) * step; };
  for (std::size_t c = 0; c < captions.size(); ++c)
    pen.write(captions[c], left_of(c), above / 2, cell_px, render::Align::centre, kMomentsInk);

  render::Renderer renderer(face);
  std::vector<Vec3f> vertices_m(face.neutral_m.size());
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const int top = above + static_cast<int>(r) * step, middle = top + cell_px / 2;
    pen.write(rows[r].name, 0, middle, beside, render::Align::left, kMomentsInk);
    for (std::size_t c = 0; c < captions.size(); ++c) {
      if (const auto& weights = rows[r].weights[c]; is_seen(weights)) {
        face::evaluate(face, *weights, 0, vertices_m);
        face::turn_eyes(face, *weights, vertices_m);
        render::paste(picture, renderer.still(vertices_m, camera, look), left_of(c), top);
      } else {
        render::paste(picture, render::Image(cell_px, cell_px, look.background_bottom), left_of(c), top);
        pen.write("no face", left_of(c), middle, cell_px, render::Align::centre, kUnseenInk);
      }
    }
  }
  return picture;
}

}  // namespace mien::lab
