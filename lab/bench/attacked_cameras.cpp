#include <utility>  // Before Asio 1.74, which forgets it.

#include "lab/bench/attacked_cameras.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <chrono>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "app/child_program.h"
#include "app/command.h"
#include "app/private_folder.h"
#include "lab/bench/clock.h"
#include "lab/bench/loopback.h"
#include "mien/core/files.h"
#include "mien/modalities/modalities.h"
#include "mien/sensor/rig.h"
#include "mien/session/replay.h"
#include "mien/take/take.h"

namespace mien::lab {
namespace {

namespace asio = boost::asio;

/// In which a session asks its cameras, and ends when it is asked to.
constexpr auto kAnswers = std::chrono::seconds(20);
/// Of a session until it is judged: by then it has asked its cameras and its clocks have settled.
constexpr double kBegins_s = 2;
constexpr std::size_t kPicturesKept = 40;

Result<app::Child> start_headset(const CameraScene& scene, const std::array<std::string, 3>& cameras,
                                 const std::filesystem::path& take, std::uint16_t sink_port) {
  MIEN_TRY_ASSIGN(const std::filesystem::path program, app::find_helper("mien"));
  std::vector<std::string> command = {
      program.string(), "live",        "--rig",  scene.rig,
      "--model",        scene.model,   "--out",  fmt::format("livelink://127.0.0.1:{}", sink_port),
      "--record",       take.string(), "--page", "off",
      "--json"};
  for (const std::string& camera : cameras) command.insert(command.end(), {"--listen", camera});
  return app::Child::start(std::move(command), app::Child::Input::none);
}

/// What the take tells of the time that is judged. `good`: addresses of the cameras that are heard.
Result<void> read_camera_take(const CameraScene& scene, const std::filesystem::path& path,
                              const std::string& hash, const std::array<std::string, 2>& good,
                              AttackFigures& out) {
  MIEN_TRY_ASSIGN(const take::Take take, take::Take::open(path));
  MIEN_TRY_ASSIGN(const std::vector<take::LogEntry> entries, take.entries());
  MIEN_TRY_ASSIGN(const std::vector<take::StoredSample> samples, take.samples());
  MIEN_TRY_ASSIGN(const std::vector<take::Tick> ticks, take.ticks());
  MIEN_TRY_ASSIGN(const auto session, modalities::make_session(take.rig(), scene.model));
  MIEN_TRY(session::replay(take, *session, [](const auto&, const auto&) { return true; }));
  out.same_bits = session->hash() == hash;
  std::optional<HostTime> from;
  for (const take::StoredSample& sample : samples) {
    const std::string& source = entries[static_cast<std::size_t>(sample.entry - 1)].source;
    if (std::ranges::find(good, source) == good.end()) continue;
    if (!from) from = sample.arrival + from_seconds(kBegins_s);
    if (sample.arrival >= *from && sample.arrival < *from + from_seconds(scene.seconds)) ++out.heard;
  }
  if (!from) return {};
  const auto fired = std::ranges::count_if(ticks, [&](const take::Tick& tick) {
    return tick.fired >= *from && tick.fired < *from + from_seconds(scene.seconds);
  });
  out.added = static_cast<double>(fired) - std::round(scene.seconds * kFrameRateHz);
  return {};
}

}  // namespace

Result<CameraScene> set_camera_scene(double seconds, const std::string& model, std::uint64_t seed) {
  CameraScene scene;
  scene.seconds = seconds;
  scene.seed = seed;
  MIEN_TRY_ASSIGN(const std::filesystem::path path, app::path_or("", "rigs/headset.toml"));
  MIEN_TRY_ASSIGN(const sensor::Rig rig, sensor::read_rig(path));
  MIEN_TRY_ASSIGN(const std::filesystem::path its_model, modalities::live_model(rig, model));
  scene.rig = path.string();
  scene.model = its_model.string();
  scene.pictures = made_up_pictures(kPicturesKept);
  return scene;
}

Result<AttackFigures> run_attacked_cameras(const CameraScene& scene, const Attack* attack,
                                           const Progress& progress) {
  MIEN_TRY_ASSIGN(const app::PrivateFolder folder, app::PrivateFolder::make());
  MIEN_TRY_ASSIGN(const auto cameras, GoodCameras::open(scene.pictures, attack == nullptr ? 3 : 2));
  std::unique_ptr<HostileCamera> hostile;
  if (attack != nullptr)
    hostile = std::make_unique<HostileCamera>(attack->camera, scene.pictures, scene.seed);
  asio::io_context io;
  const auto face = loopback(io);  // Somebody who gets the face, and does nothing with it.
  const std::filesystem::path take = folder.path() / "take.mien";
  const std::array<std::string, 2> good = {cameras->address(0), cameras->address(1)};
  const std::string second =
      hostile ? fmt::format("http://127.0.0.1:{}/", hostile->port()) : cameras->address(2);
  MIEN_TRY_ASSIGN(app::Child session,
                  start_headset(scene, {good[0], second, good[1]}, take, face.local_endpoint().port()));
  for (const auto from = Clock::now(); !cameras->are_all_watched();) {
    if (Clock::now() - from > kAnswers)
      return fail(ErrorCode::io, "the session asks for no pictures", good[0]);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  const double lasts_s = kBegins_s + scene.seconds + 0.5;
  for (const auto begun = Clock::now(); seconds_since(begun) < lasts_s;) {
    if (!progress(seconds_since(begun) / lasts_s, attack == nullptr ? "nobody attacks" : attack->name))
      return fail(ErrorCode::cancelled, "stopped", "bench attack");
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  AttackFigures out;
  if (hostile) out.sent = static_cast<double>(hostile->sent());
  // It is asked to end while the camera goes on.
  MIEN_TRY_ASSIGN(const app::ChildOutput said, session.stop(kAnswers));
  MIEN_TRY_ASSIGN(const std::string hash, read_summary(said, out));
  if (out.frames > 0) MIEN_TRY(read_camera_take(scene, take, hash, good, out));
  return out;
}

}  // namespace mien::lab
