#include "lab/bench/benchmarks.h"

#include <fmt/format.h>

#include <ctime>
#include <memory>
#include <string>
#include <vector>

#include "app/chosen_face.h"
#include "lab/bench/clock.h"
#include "lab/commands/output.h"
#include "mien/builtin_face/builtin_face.h"
#include "mien/builtin_face/skin_folds.h"
#include "mien/face/motion.h"
#include "mien/performer/performer.h"
#include "mien/render/comparison.h"
#include "mien/render/raster.h"
#include "mien/render/ray_scene.h"

namespace mien::lab {
namespace {

/// One view of the demo's film, pixels; the film has three beside each other.
constexpr int kWidth = 428, kHeight = 480;
constexpr double kRate_hz = 30;
/// What is compared in the film lags so much, as a capture does.
constexpr double kLag_s = 0.05;

struct RenderBench {
  int frames = 60;
  int faces = 20;
  std::string face = "builtin";
  Output to;
};

template <class Work>
double seconds_of(const Work& work) {
  const auto from = Clock::now();
  work();
  return seconds_since(from);
}

/// Of how long something took each time, s.
app::Json times_ms(std::vector<double> took_s) {
  const Spread spread = spread_of(std::move(took_s));
  return {{"median_ms", 1e3 * spread.p50_s}, {"worst_ms", 1e3 * spread.worst_s}};
}

app::Json face_figures(int faces) {
  // The first builds what all share; it has to come before any other face of this process.
  const double first_s = seconds_of([] { (void)builtin_face::make_builtin(builtin_face::without_hair({})); });
  std::vector<double> bare_s, haired_s;
  Random random(1);
  for (int i = 0; i < faces; ++i) {
    const builtin_face::BuiltinParameters who = builtin_face::random_identity(random);
    haired_s.push_back(seconds_of([&] { (void)builtin_face::make_builtin(who); }));
    bare_s.push_back(seconds_of([&] { (void)builtin_face::make_builtin(builtin_face::without_hair(who)); }));
  }
  return {{"first_ms", 1e3 * first_s}, {"further", times_ms(bare_s)}, {"with_hair", times_ms(haired_s)}};
}

/// One ray through each pixel of a picture, on one thread, nothing shaded: what Embree takes at least.
double rays_alone_s(const face::Face& face, const render::Camera& camera) {
  const render::RayScene scene(face.neutral_m, face.triangles);
  const render::Projection view(camera);
  std::size_t hit = 0;
  const double took_s = seconds_of([&] {
    for (int y = 0; y < camera.height; ++y)
      for (int x = 0; x < camera.width; ++x)
        hit +=
            scene.first_hit(view.eye_m, view.ray(static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F))
                .any();
  });
  return hit > 0 ? took_s : 0;
}

Result<app::Json> film_figures(const face::Face& face, int frames) {
  MIEN_TRY_ASSIGN(const render::Lettering lettering, render::Lettering::load());
  performer::Script script = performer::default_script(performer::Block::mixed, frames / kRate_hz + 2);
  const Random random(1);
  const face::MotionCurve curve(performer::perform(script, {}, random));
  const render::Camera camera = render::portrait_camera(face, render::kFrontView_rad, kWidth, kHeight);
  render::Renderer renderer(face, render::Quality::video, 0, builtin_face::skin_folds({}));
  std::vector<Vec3f> truth_m(face.neutral_m.size()), capture_m(face.neutral_m.size());
  const auto pose = [&](double time_s, std::vector<Vec3f>& vertices_m) {
    const face::MotionFrame frame = curve.at(time_s);
    face::evaluate(face, frame.weights, frame.tongue_out, vertices_m);
    face::turn_eyes(face, frame.weights, vertices_m);
  };
  const Progress progress = app::terminal_progress("bench render");
  std::vector<double> took_s;
  const std::clock_t cpu = std::clock();
  for (int i = 0; i < frames; ++i) {
    took_s.push_back(seconds_of([&] {
      pose(1 + i / kRate_hz, truth_m);
      pose(1 + i / kRate_hz - kLag_s, capture_m);
      (void)render::comparison(renderer, lettering, truth_m, capture_m, camera, render::Look::dark(), {});
    }));
    if (!progress((i + 1.0) / frames, fmt::format("frame {} of {}", i + 1, frames)))
      return fail(ErrorCode::cancelled, "stopped", "bench render");
  }
  const double cpu_s = static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC;
  app::Json film = times_ms(took_s);
  film["first_ms"] = 1e3 * took_s.front();
  film["cpu_ms_a_frame"] = 1e3 * cpu_s / frames;
  film["frames"] = frames;
  const double rays_s = 3 * rays_alone_s(face, camera);
  film["rays_alone_ms"] = 1e3 * rays_s;
  film["vs_rays_alone"] = rays_s > 0 ? cpu_s / frames / rays_s : 0;
  return film;
}

double still_s(const face::Face& face) {
  const render::Camera camera = render::portrait_camera(face, render::kFrontView_rad, 640, 640);
  return seconds_of([&] {
    render::Renderer renderer(face);
    (void)renderer.still(face.neutral_m, camera, render::Look::dark());
  });
}

Result<void> run_render_bench(const RenderBench& options) {
  const app::Json faces = face_figures(options.faces);
  MIEN_TRY_ASSIGN(const face::Face face, app::chosen_face(options.face));
  std::vector<double> stills_s;
  for (int i = 0; i < 5; ++i) stills_s.push_back(still_s(face));
  MIEN_TRY_ASSIGN(const app::Json film, film_figures(face, options.frames));
  const app::Json measured = {{"builtin_face", faces}, {"still", times_ms(stills_s)}, {"film", film}};
  measure::Table table{.caption = "", .columns = {"", "ms", "worst"}, .rows = {}, .strong_rows = {}};
  const auto line = [&](const std::string& what, const app::Json& ms, const app::Json& worst = {}) {
    table.rows.push_back({what, cell_text(ms, "{:.1f}"), cell_text(worst, "{:.1f}")});
  };
  const auto spread = [&](const std::string& what, const app::Json& times) {
    line(what, times["median_ms"], times["worst_ms"]);
  };
  line("the first built-in face, bare", faces["first_ms"]);
  spread(fmt::format("each of {} strangers, bare", options.faces), faces["further"]);
  spread("the same with hair", faces["with_hair"]);
  spread("a still, 640 x 640", measured["still"]);
  spread(fmt::format("a frame of the demo's film, {} x {}", 3 * kWidth, kHeight), film);
  line("the same, CPU time", film["cpu_ms_a_frame"]);
  line("a ray of Embree's for each of its pixels, no shading", film["rays_alone_ms"]);
  measure::Report report("Faces, stills and films", "face " + options.face);
  report.table(table);
  return put_out(options.to, report, measured);
}

}  // namespace

void add_render_bench(app::Commands& commands, app::Command bench) {
  auto options = std::make_shared<RenderBench>();
  const app::Command command = commands.add_under(bench, "render",
                                                  "How long built-in faces, a still and the frames of a "
                                                  "comparison's film take; beside them what Embree's "
                                                  "rays alone take, one for each pixel on one thread",
                                                  "mien bench render --frames 120 --json",
                                                  [options] { return run_render_bench(*options); });
  command.add_option("--frames", options->frames, "Frames of the film, 30 a second")
      .in_range(2, 3600)
      .show_default();
  command.add_option("--strangers", options->faces, "How many drawn faces are made")
      .in_range(1, 1000)
      .show_default();
  command.add_option("--face", options->face, fmt::format("Whom stills and film show: {}", app::kFaceHelp))
      .show_default();
  app::add_json_flag(command, options->to.json);
}

}  // namespace mien::lab
