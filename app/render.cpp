#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <vector>

#include "app/command.h"
#include "app/film.h"
#include "app/json_output.h"
#include "app/nearest_word.h"
#include "app/one_line.h"
#include "app/performance.h"
#include "mien/builtin_face/load_face.h"
#include "mien/core/files.h"
#include "mien/face/load_motion.h"
#include "mien/face/shapes_named.h"
#include "mien/face/target_names.h"
#include "mien/render/comparison.h"

namespace mien::app {
namespace {

struct RenderOptions {
  std::string face;
  std::vector<std::string> weights;
  std::string view = "front", size, look = "dark", quality, out;
  std::string motion, truth, capture, audio;
  double rate_hz = 30, from_s = 0, until_s = 0, delay_s = 0, full_scale_mm = 5;
  float closeness = 1;
  bool json = false;
};

std::string unknown_shape(const std::string& name) {
  std::vector<std::string> known(face::kShapeNames.begin(), face::kShapeNames.end());
  known.insert(known.end(), face::arkit52().shapes.begin(), face::arkit52().shapes.end());
  const std::string near = nearest_word(name, known);
  return fmt::format("there is no shape '{}'{}", one_line(name, 40),
                     near.empty() ? "" : fmt::format("; did you mean {}?", near));
}

/// Shapes by ICT's names or ARKit's, in either case; without its side a name is both sides.
Result<face::BlendshapeWeights> parse_weights(const std::vector<std::string>& entries, float* tongue_out) {
  face::BlendshapeWeights weights;
  for (const std::string& entry : entries) {
    const auto bad = [&](std::string what) {
      return fail(ErrorCode::bad_usage, std::move(what), "--weights",
                  "write them like jawOpen=1,mouthSmile_L=0.5");
    };
    const std::size_t equals = entry.find('=');
    const std::string name = entry.substr(0, equals);
    const std::string shown = one_line(entry, 40);
    float value = 0;
    char rest = 0;
    if (equals == std::string::npos || std::sscanf(entry.c_str() + equals + 1, "%f%c", &value, &rest) != 1)
      return bad(fmt::format("'{}' has no number", shown));
    if (!std::isfinite(value) || std::abs(value) > 10) return bad(fmt::format("'{}' is out of range", shown));
    std::vector<std::size_t> shapes = face::shapes_of_name(name);
    if (shapes.empty()) shapes = face::shapes_named(name);
    if (shapes.empty()) return bad(unknown_shape(name));
    for (const std::size_t k : shapes) (k < face::kShapeCount ? weights[k] : *tongue_out) = value;
  }
  return weights;
}

Result<void> parse_size(const std::string& text, int* width, int* height) {
  char rest = 0;
  if (std::sscanf(text.c_str(), "%5dx%5d%c", width, height, &rest) != 2 || *width < 16 || *height < 16 ||
      *width > 8192 || *height > 8192)
    return fail(ErrorCode::bad_usage, fmt::format("'{}' is no size", text), "--size",
                "write it like 640x480, 16 to 8192 a side");
  return {};
}

Result<void> run_render(RenderOptions options) {
  const bool comparison = !options.truth.empty() || !options.capture.empty();
  const bool film = comparison || !options.motion.empty();
  if (comparison && (options.truth.empty() || options.capture.empty() || !options.motion.empty()))
    return fail(ErrorCode::bad_usage, "a comparison needs --truth and --capture, and no --motion",
                "mien render", "see mien render --help");
  const std::string ending = std::filesystem::path(options.out).extension().string();
  if (film && ending != ".mp4")
    return fail(ErrorCode::bad_usage, "a film is written as .mp4", options.out, "change the ending");
  if (!film && ending != ".png")
    return fail(ErrorCode::bad_usage, "a still is written as .png", options.out,
                "change the ending, or give a --motion");
  if (film && !options.weights.empty())
    return fail(ErrorCode::bad_usage, "--weights makes a still, --motion a film", "mien render",
                "choose one");

  FilmOptions how;
  if (options.size.empty()) options.size = film ? "480x480" : "640x640";
  MIEN_TRY(parse_size(options.size, &how.width, &how.height));
  how.view = *render::view_from_name(options.view);
  how.closeness = options.closeness;
  how.look = options.look == "light" ? render::Look::light() : render::Look::dark();
  how.quality = options.quality == "still" || (options.quality.empty() && !film) ? render::Quality::still
                                                                                 : render::Quality::video;
  how.rate_hz = options.rate_hz;
  how.from_s = options.from_s;
  if (options.until_s > 0) how.until_s = options.until_s;
  how.full_scale_m = static_cast<float>(options.full_scale_mm * 1e-3);

  Performance performance;
  if (film) {
    MIEN_TRY_ASSIGN(performance, load_performance(comparison ? options.truth : options.motion));
  }
  how.sound = std::move(performance.sound);
  if (!options.audio.empty()) {
    MIEN_TRY_ASSIGN(const auto bytes, read_file(options.audio));
    MIEN_TRY_ASSIGN(how.sound, parse_wav(bytes, options.audio));
  }
  if (options.face.empty()) options.face = performance.face.empty() ? "builtin" : performance.face;
  MIEN_TRY_ASSIGN(const face::Face face, builtin_face::load_face(options.face));

  FilmMade made{.frames = 1, .duration_s = 0, .seconds = 0};
  if (!film) {
    float tongue_out = 0;
    MIEN_TRY_ASSIGN(const auto weights, parse_weights(options.weights, &tongue_out));
    std::vector<Vec3f> vertices_m(face.neutral_m.size());
    face::evaluate(face, weights, tongue_out, vertices_m);
    face::turn_eyes(face, weights, vertices_m);
    render::Renderer renderer(face, how.quality);
    const render::Camera camera = portrait_camera(face, how.view, how.width, how.height, how.closeness);
    MIEN_TRY(render::write_png(options.out, renderer.still(vertices_m, camera, how.look)));
  } else if (comparison) {
    MIEN_TRY_ASSIGN(const Performance capture, load_performance(options.capture));
    MIEN_TRY_ASSIGN(made, film_comparison(face, performance.motion, capture.motion, options.delay_s, how,
                                          options.out, terminal_progress("render")));
  } else {
    MIEN_TRY_ASSIGN(made,
                    film_motion(face, performance.motion, how, options.out, terminal_progress("render")));
  }
  if (options.json)
    print_json({{"out", options.out},
                {"face", options.face},
                {"frames", made.frames},
                {"duration_s", made.duration_s},
                {"seconds", made.seconds}});
  else
    fmt::print("wrote {}\n", options.out);
  return {};
}

}  // namespace

void add_render_command(Commands& commands) {
  auto options = std::make_shared<RenderOptions>();
  const Command command =
      commands.add("render", "Draws a face: a still, a film of a motion, or truth beside capture",
                   "mien render --weights jawOpen=0.4,mouthSmile_L=1 --view three-quarter --out smile.png\n"
                   "  mien render --truth take.mien --capture capture.csv --out compare.mp4",
                   [options] { return run_render(*options); });
  command.add_option(
      "--face", options->face,
      "builtin, a folder with generic_neutral_mesh.obj, or a .glb or .vrm; the take's own unless told");
  command
      .add_option(
          "--weights", options->weights,
          "Shapes of a still, by ICT's names or ARKit's: jawOpen=1,mouthSmileLeft=0.5; without its side a "
          "name is both; beyond 0 to 1 is drawn too, up to 10")
      .delimiter(',');
  command.add_option("--view", options->view, "front, three-quarter or side")
      .one_of({"front", "three-quarter", "side"})
      .show_default();
  command.add_option("--closeness", options->closeness, "1 the head, 2 half of that")
      .number_between(0.2, 20.0)
      .show_default();
  command.add_option("--size", options->size,
                     "Pixels, of one view: 640x640 for a still, 480x480 for a film unless told");
  command.add_option("--look", options->look, "dark or light").one_of({"dark", "light"}).show_default();
  command.add_option("--quality", options->quality, "still (slow, fine) or video (fast)")
      .one_of({"still", "video"});
  command.add_option("--motion", options->motion, "A Live Link CSV, or a take, whose truth it is");
  command.add_option("--truth", options->truth, "The same, to compare with --capture");
  command.add_option("--capture", options->capture, "What was captured");
  command.add_option("--delay", options->delay_s, "Seconds from the truth's start to the capture's");
  command.add_option("--full-scale", options->full_scale_mm, "The error that is painted darkest, mm")
      .number_between(0.01, 1000.0)
      .show_default();
  command.add_option("--fps", options->rate_hz, "Frames a second of a film")
      .number_between(1.0, 240.0)
      .show_default();
  command.add_option("--from", options->from_s, "Where a film begins, seconds").not_negative();
  command.add_option("--until", options->until_s, "Where it ends, seconds").positive();
  command.add_option("--audio", options->audio, "A WAV file to play along; a take's own sound unless told");
  command.add_option("--out", options->out, "The .png or .mp4 to write").required();
  command.add_flag("--json", options->json, "Print one JSON object");
}

}  // namespace mien::app
