// What does each shape of the built-in face look like? Draws them all on one sheet:
//   face_shapes docs/images/face_shapes.png        every shape at weight 1
//   face_shapes docs/images/face_people.png people some of the family's faces
//   face_shapes docs/images/face_cuts.png cuts     the cuts of hair

#include <fmt/format.h>

#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

#include "mien/builtin_face/builtin_face.h"
#include "mien/render/camera.h"
#include "mien/render/lettering.h"
#include "mien/render/renderer.h"

namespace {

using namespace mien;

constexpr int kTile = 180;

render::Image portrait(const face::Face& face, const face::BlendshapeWeights& weights, float tongue_out,
                       render::View view) {
  std::vector<Vec3f> vertices(face.neutral_m.size());
  face::evaluate(face, weights, tongue_out, vertices);
  face::turn_eyes(face, weights, vertices);
  render::Renderer renderer(face);
  return renderer.still(vertices, render::portrait_camera(face, view, kTile, kTile, 1.25F),
                        render::Look::light());
}

/// Every shape, the two sides of a pair together, and two poses that need several.
render::Image all_shapes(const render::Lettering& lettering) {
  const face::Face face = builtin_face::make_builtin({.hair = builtin_face::HairStyle::crop});
  std::vector<std::string> names = {"neutral"};
  for (const std::string_view name : face::kShapeNames)
    if (!name.ends_with("_R") && name != "mouthClose") names.emplace_back(name.substr(0, name.find('_')));
  names.insert(names.end(), {"tongueOut", "jawOpen + mouthClose", "mouthSmile + eyeBlink"});
  constexpr int kColumns = 6;
  const int rows = (static_cast<int>(names.size()) + kColumns - 1) / kColumns;
  render::Image sheet(kColumns * kTile, rows * kTile, {255, 255, 255});
  for (std::size_t i = 0; i < names.size(); ++i) {
    face::BlendshapeWeights weights;
    for (std::size_t k = 0; k < face::kShapeCount; ++k) {
      const std::string_view name = face::kShapeNames[k];
      if (names[i].find(name.substr(0, name.find('_'))) != std::string::npos) weights[k] = 1;
    }
    render::Image tile = portrait(face, weights, names[i] == "tongueOut" ? 1.0F : 0.0F, render::View::front);
    lettering.draw(tile, names[i], kTile / 2.0F, kTile - 5.0F, 12, {40, 40, 40}, render::Align::centre);
    const int at = static_cast<int>(i);
    render::paste(sheet, tile, at % kColumns * kTile, at / kColumns * kTile);
  }
  return sheet;
}

render::Image some_people() {
  constexpr int kColumns = 6, kRows = 3;
  render::Image sheet(kColumns * kTile, kRows * kTile);
  for (int i = 0; i < kColumns * kRows; ++i) {
    Random random(static_cast<std::uint64_t>(i));
    const face::Face face = builtin_face::make_builtin(builtin_face::random_identity(random));
    const auto view = i % 2 == 0 ? render::View::front : render::View::three_quarter;
    render::paste(sheet, portrait(face, {}, 0, view), i % kColumns * kTile, i / kColumns * kTile);
  }
  return sheet;
}

/// The cuts of hair, from the front and from the side.
render::Image cuts() {
  constexpr int kColumns = static_cast<int>(builtin_face::kHairStyleCount);
  render::Image sheet(kColumns * kTile, 2 * kTile);
  for (int i = 0; i < kColumns; ++i) {
    builtin_face::BuiltinParameters who;
    who.hair = static_cast<builtin_face::HairStyle>(i);
    who.hair_tone = 0.2 + 0.15 * i;
    const face::Face face = builtin_face::make_builtin(who);
    render::paste(sheet, portrait(face, {}, 0, render::View::front), i * kTile, 0);
    render::paste(sheet, portrait(face, {}, 0, render::View::side), i * kTile, kTile);
  }
  return sheet;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "usage: face_shapes OUT.png [people | cuts]\n");
    return 2;
  }
  const std::string_view what = argc > 2 ? argv[2] : "shapes";
  const auto lettering = render::Lettering::load();
  if (!lettering) {
    fmt::print(stderr, "{}\n", lettering.error().message());
    return 1;
  }
  const render::Image sheet = what == "people" ? some_people()
                              : what == "cuts" ? cuts()
                                               : all_shapes(*lettering);
  if (const auto written = render::write_png(argv[1], sheet); !written) {
    fmt::print(stderr, "{}\n", written.error().message());
    return 1;
  }
  return 0;
}
