#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "app/chosen_face.h"
#include "app/command.h"
#include "app/film.h"
#include "app/json_output.h"
#include "app/performance.h"
#include "mien/core/files.h"
#include "mien/core/nearest_word.h"
#include "mien/face/profile_map.h"
#include "mien/face/target_names.h"
#include "mien/performer/named_pose.h"
#include "mien/render/comparison.h"
#include "mien/render/lights.h"

namespace mien::app {
namespace {

struct RenderOptions {
  std::string face;
  std::vector<std::string> weights;
  std::string pose, light, view = "front", size, look = "dark", quality, out;
  std::string motion, truth, capture, audio;
  double rate_hz = 30, from_s = 0, until_s = 0, delay_s = 0, full_scale_mm = 5;
  float closeness = 1;
  bool json = false;
};

std::string unknown_shape(const std::string& name) {
  std::vector<std::string> known(face::kShapeNames.begin(), face::kShapeNames.end());
  known.insert(known.end(), face::arkit52().shapes.begin(), face::arkit52().shapes.end());
  return fmt::format("there is no shape '{}'{}", one_line(name, 40), did_you_mean(name, known));
}

/// Shapes by ICT's names or ARKit's, in either case and each once; without its side a name is both sides.
/// They replace those of `pose`.
Result<void> set_weights(const std::vector<std::string>& entries, performer::StillPose& pose) {
  std::set<std::size_t> given;
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
    for (const std::size_t k : shapes) {
      if (!given.insert(k).second)
        return bad(fmt::format("'{}': {} is given twice", shown, face::inner_name(k)));
      (k < face::kShapeCount ? pose.weights[k] : pose.tongue_out) = value;
    }
  }
  return {};
}

Result<void> parse_size(const std::string& text, bool film, int* width, int* height) {
  // A film's codec has a least size; a picture of the largest takes 0.5 GB while it is written.
  const int least = film ? 16 : 1, most = 8192;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%5dx%5d%c", width, height, &rest) != 2 || *width < least ||
      *height < least || *width > most || *height > most)
    return fail(ErrorCode::bad_usage, fmt::format("'{}' is no size", one_line(text, 40)), "--size",
                fmt::format("write it like 640x480, {} to {} a side", least, most));
  return {};
}

Result<render::Look> chosen_look(const RenderOptions& options) {
  if (options.light.empty()) return options.look == "light" ? render::Look::light() : render::Look::dark();
  if (const render::NamedLight* light = render::find_light(options.light)) return light->look;
  std::vector<std::string> known;
  for (const render::NamedLight& light : render::named_lights()) known.emplace_back(light.name);
  const std::string near = did_you_mean(options.light, known);
  return fail(ErrorCode::bad_usage,
              fmt::format("there is no light '{}'{}", one_line(options.light, 40), near), "--light",
              near.empty() ? fmt::format("there are {}", fmt::join(known, ", ")) : "");
}

Result<void> draw_still(const RenderOptions& options, const FilmOptions& how, const face::Face& face) {
  performer::StillPose pose;
  if (!options.pose.empty()) {
    MIEN_TRY_ASSIGN(pose, performer::named_pose(options.pose));
  }
  MIEN_TRY(set_weights(options.weights, pose));
  std::vector<Vec3f> vertices_m(face.neutral_m.size());
  face::evaluate(face, pose.weights, pose.tongue_out, vertices_m);
  face::add_correctives(how.correctives, pose.weights, vertices_m);
  face::turn_eyes(face, pose.weights, vertices_m);
  render::Renderer renderer(face, how.quality, 0, how.folds, how.marks);
  const render::Camera camera =
      render::portrait_camera(face, how.view_rad, how.width, how.height, how.closeness);
  return render::write_png(options.out, renderer.still(vertices_m, camera, how.look));
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
  MIEN_TRY(check_output(options.out, {ending}));
  if (film && !(options.weights.empty() && options.pose.empty()))
    return fail(ErrorCode::bad_usage, "--weights and --pose make a still, --motion a film", "mien render",
                "choose one");

  FilmOptions how;
  if (options.size.empty()) options.size = film ? "480x480" : "640x640";
  MIEN_TRY(parse_size(options.size, film, &how.width, &how.height));
  const std::optional<float> view_rad = render::view_rad_from_name(options.view);
  if (!view_rad)
    return fail(ErrorCode::bad_usage, fmt::format("there is no view '{}'", one_line(options.view, 40)),
                "--view", "it is front, three-quarter, side or degrees such as 45");
  how.view_rad = *view_rad;
  how.closeness = options.closeness;
  MIEN_TRY_ASSIGN(how.look, chosen_look(options));
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
  MIEN_TRY_ASSIGN(const face::Face face,
                  how.look.infrared ? chosen_infrared_face(options.face) : chosen_face(options.face));
  MIEN_TRY_ASSIGN(how.correctives, correctives_of(options.face, face));
  MIEN_TRY_ASSIGN(how.folds, skin_folds_of(options.face));
  if (!how.look.infrared) {
    MIEN_TRY_ASSIGN(how.marks, skin_marks_of(options.face, face));
  }

  FilmMade made{.frames = 1, .duration_s = 0, .seconds = 0};
  if (!film) {
    MIEN_TRY(draw_still(options, how, face));
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
      commands.add("render", "Draws a face: a still, a film, or truth beside capture",
                   "mien render --face builtin:ada --pose smile --light studio --out smile.png\n"
                   "  mien render --weights jawOpen=0.4,mouthSmile_L=1 --view three-quarter --out smile.png\n"
                   "  mien render --truth take.mien --capture capture.csv --out compare.mp4",
                   [options] { return run_render(*options); });
  command.add_option("--face", options->face, fmt::format("{}; the take's own unless told", kFaceHelp));
  command.add_option("--pose", options->pose,
                     fmt::format("A still's expression: {}, or any of the expressions that performers show",
                                 fmt::join(performer::plain_pose_names(), ", ")));
  command
      .add_option("--weights", options->weights,
                  "Shapes of a still, by ICT's names or ARKit's: jawOpen=1,mouthSmileLeft=0.5; without its "
                  "side a name is both; beyond 0 to 1 is drawn too, up to 10; they replace the --pose's")
      .delimiter(',');
  command
      .add_option("--view", options->view,
                  "front, three-quarter, side, or degrees about the head, positive at the performer's left")
      .show_default();
  command.add_option("--closeness", options->closeness, "1 the head, 2 half of that")
      .number_between(0.2, 20.0)
      .show_default();
  command.add_option("--size", options->size,
                     "Pixels, of one view: 640x640 for a still, 480x480 for a film unless told");
  command.add_option("--look", options->look, "dark or light").one_of({"dark", "light"}).show_default();
  std::vector<std::string> lights;
  for (const render::NamedLight& light : render::named_lights())
    lights.push_back(fmt::format("{} ({})", light.name, light.description));
  command.add_option("--light", options->light,
                     fmt::format("Light and background in place of the --look: {}", fmt::join(lights, ", ")));
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
  add_json_flag(command, options->json);
}

}  // namespace mien::app
