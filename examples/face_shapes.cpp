// What does the built-in face look like? Draws the pictures of the documents into a folder:
//   face_shapes docs/images            all of them
//   face_shapes docs/images people     face_people.png alone

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "mien/builtin_face/builtin_face.h"
#include "mien/builtin_face/correctives.h"
#include "mien/builtin_face/person.h"
#include "mien/builtin_face/skin_marks.h"
#include "mien/face/target_names.h"
#include "mien/performer/named_pose.h"
#include "mien/render/camera.h"
#include "mien/render/face_textures.h"
#include "mien/render/lettering.h"
#include "mien/render/lights.h"
#include "mien/render/surface_paint.h"

namespace {

using namespace mien;
using performer::StillPose;

/// One picture of a sheet.
struct Shot {
  builtin_face::BuiltinParameters who;
  StillPose pose;
  std::string_view light = "soft";
  float view_rad = render::kFrontView_rad;
  std::string caption;
  float closeness = 1.05F;
};

render::Image draw(const Shot& shot, int side, const render::Lettering& lettering) {
  const render::Look look = render::find_light(shot.light)->look;
  face::Face face = builtin_face::make_builtin(shot.who);
  if (look.infrared) builtin_face::paint_infrared(face, shot.who);
  std::vector<Vec3f> vertices(face.neutral_m.size());
  face::evaluate(face, shot.pose.weights, shot.pose.tongue_out, vertices);
  face::add_correctives(builtin_face::make_correctives(face, shot.who), shot.pose.weights, vertices);
  face::turn_eyes(face, shot.pose.weights, vertices);
  render::Renderer renderer(face, render::Quality::still, 0, builtin_face::skin_folds(shot.who),
                            look.infrared ? face::SkinMarks{} : builtin_face::skin_marks(shot.who, face));
  render::Image tile = renderer.still(
      vertices, render::portrait_camera(face, shot.view_rad, side, side, shot.closeness), look);
  const auto ink = look.background_bottom[1] > 127 ? render::Rgb{40, 42, 48} : render::Rgb{225, 227, 232};
  const auto middle = static_cast<float>(side) / 2, bottom = static_cast<float>(side) - 5;
  lettering.draw(tile, shot.caption, middle, bottom, side < 160 ? 10 : 13, ink, render::Align::centre);
  return tile;
}

struct Sheet {
  std::vector<Shot> shots;
  int columns = 1;
  int side = 100;  ///< Of each picture, pixels.
};

render::Image draw(const Sheet& sheet, const render::Lettering& lettering) {
  const auto count = static_cast<int>(sheet.shots.size());
  const int columns = sheet.columns, side = sheet.side;
  render::Image all(columns * side, (count + columns - 1) / columns * side, {255, 255, 255});
  for (int i = 0; i < count; ++i)
    render::paste(all, draw(sheet.shots[static_cast<std::size_t>(i)], side, lettering), i % columns * side,
                  i / columns * side);
  return all;
}

builtin_face::BuiltinParameters someone(std::string_view name) {
  return builtin_face::find_person(name).value().parameters;
}

/// Neutral, and each of ARKit's 52 at weight 1; mouthClose closes what jawOpen opens.
Sheet shapes() {
  std::vector<Shot> shots = {
      {.who = someone("builtin"), .pose = {}, .caption = "neutral", .closeness = 1.3F}};
  for (const std::string& name : face::arkit52().shapes) {
    StillPose pose;
    for (const std::size_t k : face::shapes_of_name(name))
      (k < face::kShapeCount ? pose.weights[k] : pose.tongue_out) = 1;
    if (name == "mouthClose") pose.weights[face::shape("jawOpen")] = 1;
    shots.push_back({.who = shots[0].who, .pose = pose, .caption = name, .closeness = 1.3F});
  }
  return {std::move(shots), 9, 132};
}

Sheet people() {
  std::vector<Shot> shots;
  for (int seed = 1; seed <= 12; ++seed)
    shots.push_back({.who = someone(fmt::format("builtin:{}", seed)),
                     .pose = {},
                     .view_rad = seed % 2 == 1 ? render::kFrontView_rad : 0.5F,
                     .caption = fmt::format("{}", seed)});
  return {std::move(shots), 6, 210};
}

Sheet performers() {
  std::vector<Shot> shots;
  for (const auto& performer : builtin_face::named_performers())
    shots.push_back({.who = performer.parameters,
                     .pose = performer::named_pose("smile").value(),
                     .light = "studio",
                     .view_rad = 0.35F,
                     .caption = performer.name});
  return {std::move(shots), 5, 240};
}

/// The cuts of hair, from the front and from the side.
Sheet cuts() {
  std::vector<Shot> shots;
  for (const float view_rad : {render::kFrontView_rad, render::kSideView_rad})
    for (const std::string_view cut : builtin_face::kHairStyleNames)
      shots.push_back({.who = someone(fmt::format("builtin,hair={}", cut)),
                       .pose = {},
                       .view_rad = view_rad,
                       .caption = std::string(cut),
                       .closeness = 0.9F});
  return {std::move(shots), 6, 180};
}

/// Performers at 850 nm below themselves in visible light.
Sheet infrared() {
  std::vector<Shot> shots;
  for (const std::string_view light : {"soft", "infrared"})
    for (const std::string_view name : {"ada", "chidi", "emil", "farah", "hana"})
      shots.push_back(
          {.who = someone(fmt::format("builtin:{}", name)), .pose = {}, .light = light, .caption = ""});
  return {std::move(shots), 5, 210};
}

Sheet turntable() {
  std::vector<Shot> shots;
  for (int degrees = 0; degrees < 360; degrees += 45)
    shots.push_back({.who = someone("builtin:dana"),
                     .pose = {},
                     .light = "studio",
                     .view_rad = static_cast<float>(degrees * M_PI / 180),
                     .caption = fmt::format("{}", degrees),
                     .closeness = 0.9F});
  return {std::move(shots), 8, 150};
}

/// The albedo that exported files carry, of three performers.
render::Image textures() {
  constexpr int kSide = 512;
  render::Image all(3 * kSide, kSide);
  int x = 0;
  for (const std::string_view name : {"ada", "goro", "imani"}) {
    const builtin_face::BuiltinParameters who = someone(fmt::format("builtin:{}", name));
    face::Face face = builtin_face::make_builtin(who);
    builtin_face::lay_out_textures(face);
    const render::SurfacePaint paint(face, builtin_face::skin_marks(who, face));
    render::Image picture(kSide, kSide);
    picture.rgb = render::bake_textures(face, paint, kSide).value().albedo;
    render::paste(all, picture, x, 0);
    x += kSide;
  }
  return all;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr,
               "usage: face_shapes FOLDER [shapes | people | performers | cuts | infrared | turntable | "
               "textures]\n");
    return 2;
  }
  const auto lettering = render::Lettering::load();
  if (!lettering) {
    fmt::print(stderr, "{}\n", lettering.error().message());
    return 1;
  }
  const auto sheet = [&lettering](Sheet (*make)()) {
    return [&lettering, make] { return draw(make(), *lettering); };
  };
  const std::pair<std::string_view, std::function<render::Image()>> pictures[] = {
      {"shapes", sheet(shapes)}, {"people", sheet(people)},     {"performers", sheet(performers)},
      {"cuts", sheet(cuts)},     {"infrared", sheet(infrared)}, {"turntable", sheet(turntable)},
      {"textures", textures}};
  for (const auto& [name, make] : pictures) {
    if (argc > 2 && name != argv[2]) continue;
    const std::filesystem::path path = std::filesystem::path(argv[1]) / fmt::format("face_{}.png", name);
    if (const auto written = render::write_png(path, make()); !written) {
      fmt::print(stderr, "{}\n", written.error().message());
      return 1;
    }
  }
  return 0;
}
