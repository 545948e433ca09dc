#include "lab/bench/attacked_session.h"

#include <utility>  // Before Asio 1.74, which forgets it.
//
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <chrono>
#include <cmath>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <thread>
#include <vector>

#include "app/child_program.h"
#include "app/chosen_face.h"
#include "app/command.h"
#include "app/live/perform_network.h"
#include "app/private_folder.h"
#include "lab/bench/clock.h"
#include "lab/bench/loopback.h"
#include "mien/core/bytes.h"
#include "mien/core/encoding.h"
#include "mien/core/files.h"
#include "mien/core/median.h"
#include "mien/face/output_frame.h"
#include "mien/measure/evaluation.h"
#include "mien/modalities/modalities.h"
#include "mien/sensor/rig.h"
#include "mien/session/replay.h"
#include "mien/take/take.h"

namespace mien::lab {
namespace {

namespace asio = boost::asio;
using asio::ip::udp;

/// Who speaks first does so this long before the devices, and who speaks second this long after them.
constexpr auto kLead = std::chrono::seconds(1);
/// In which a session listens, asks its cameras, and ends when it is asked to.
constexpr auto kPatience = std::chrono::seconds(20);
/// The devices' source text in a log begins so: strangers have other addresses.
constexpr std::string_view kDevices = "udp://127.0.0.1:";
/// A frame counts as shown from half a period after it is due on.
constexpr Duration kHalfPeriod = std::chrono::microseconds(8333);

/// Sits still before everything else, as the motion begins.
void sit_still(performer::PrologueMotion& motion, double still_s) {
  std::vector<face::MotionFrame>& frames = motion.motion.frames;
  const auto count = static_cast<std::size_t>(std::lround(still_s * kFrameRateHz));
  if (frames.empty() || count == 0) return;
  const double moved_s = static_cast<double>(count) / kFrameRateHz;
  for (face::MotionFrame& frame : frames) frame.time_s += moved_s;
  std::vector<face::MotionFrame> still(count, frames.front());
  for (std::size_t i = 0; i < count; ++i) still[i].time_s = static_cast<double>(i) / kFrameRateHz;
  frames.insert(frames.begin(), still.begin(), still.end());
  performer::PrologueTimes& times = motion.times;
  for (performer::Interval* part : {&times.neutral, &times.nod, &times.shake, &times.anchors,
                                    &times.range_of_motion, &times.gaze, &times.ease}) {
    part->begin_s += moved_s;
    part->end_s += moved_s;
  }
  times.motion_start_s += moved_s;
}

/// A key that devices and session share, for this run.
sensor::SealKey run_key(std::uint64_t seed) {
  sensor::SealKey key{.id = 1, .secret = {}};
  Random random = Random(seed).fork("key");
  for (std::byte& byte : key.secret) byte = static_cast<std::byte>(random.below(256));
  return key;
}

std::string key_text(const sensor::SealKey& key) {
  return fmt::format("{} {}\n", key.id, hex(key.secret));
}

/// Whether a socket of this machine's loopback has that port: Linux lists it.
bool somebody_listens(std::uint16_t port) {
  std::ifstream sockets("/proc/net/udp");
  const std::string entry = fmt::format("0100007F:{:04X}", port);
  for (std::string word; sockets >> word;)
    if (word == entry) return true;
  return false;
}

std::uint16_t free_port() {
  asio::io_context io;
  return loopback(io).local_endpoint().port();
}

/// The performance's time 0 on the session's clock: what devices of ours send is the performance's own bytes.
/// Of others, whose bytes it does not have, the first reading that was accepted is the first that was sent.
std::optional<Duration> begin_of(const virt::VirtualSession& played, std::span<const take::LogEntry> entries,
                                 std::span<const take::StoredSample> samples) {
  std::map<std::string_view, HostTime> sent;
  for (const take::LogEntry& entry : played.entries) sent.emplace(as_text(entry.bytes), entry.arrival);
  std::vector<Duration> begins;
  for (const take::LogEntry& entry : entries) {
    if (!entry.source.starts_with(kDevices)) continue;
    const auto found = sent.find(as_text(entry.bytes));
    if (found != sent.end()) begins.push_back(entry.arrival - found->second);
  }
  if (begins.empty()) {
    for (const take::StoredSample& sample : samples)
      if (entries[static_cast<std::size_t>(sample.entry - 1)].source.starts_with(kDevices))
        return sample.arrival - played.entries.front().arrival;
    return std::nullopt;
  }
  return upper_median(std::move(begins));
}

/// What was shown at each of the performance's moments: the newest frame that had been sent by then, and a
/// face at rest before there was one.
std::vector<face::BlendshapeWeights> shown(const virt::VirtualSession& played, Duration begin,
                                           std::span<const take::Tick> ticks,
                                           std::span<const face::OutputFrame> frames) {
  std::vector<face::BlendshapeWeights> all;
  std::size_t next = 0;
  for (const take::Tick& moment : played.ticks) {
    while (next < ticks.size() && ticks[next].fired <= moment.fired + begin + kHalfPeriod) ++next;
    all.push_back(next == 0 ? face::BlendshapeWeights() : frames[next - 1].weights);
  }
  return all;
}

/// A recorded session, and whether it replays to the same bits.
struct RecordedSession {
  std::vector<take::LogEntry> entries;
  std::vector<take::StoredSample> samples;
  std::vector<take::Tick> ticks;
  std::vector<face::OutputFrame> frames;  ///< One a tick.
  bool same_bits = false;

  [[nodiscard]] const std::string& source(const take::StoredSample& sample) const {
    return entries[static_cast<std::size_t>(sample.entry - 1)].source;
  }
  /// Frames beyond sixty a second; negative: too few.
  [[nodiscard]] double added(HostTime from, HostTime to) const {
    const auto fired = std::ranges::count_if(
        ticks, [&](const take::Tick& tick) { return tick.fired >= from && tick.fired < to; });
    return static_cast<double>(fired) - std::round(to_seconds(to - from) * kFrameRateHz);
  }
};

Result<RecordedSession> read_recorded(const std::filesystem::path& path, const std::string& model,
                                      const std::string& hash) {
  RecordedSession out;
  MIEN_TRY_ASSIGN(const take::Take take, take::Take::open(path));
  MIEN_TRY_ASSIGN(out.entries, take.entries());
  MIEN_TRY_ASSIGN(out.samples, take.samples());
  MIEN_TRY_ASSIGN(out.ticks, take.ticks());
  MIEN_TRY_ASSIGN(const auto session, modalities::make_session(take.rig(), model));
  MIEN_TRY(session::replay(take, *session, [&](const take::Tick&, const face::OutputFrame& frame) {
    out.frames.push_back(frame);
    return true;
  }));
  out.same_bits = session->hash() == hash;
  return out;
}

/// Starts `mien live` with this rig and model, recording to `take`; `more`: further arguments.
Result<app::Child> start_live(const std::string& rig, const std::string& model,
                              const std::filesystem::path& take, std::uint16_t sink_port,
                              const std::vector<std::string>& more) {
  MIEN_TRY_ASSIGN(const std::filesystem::path program, app::find_helper("mien"));
  std::vector<std::string> command = {
      program.string(), "live",        "--rig",  rig,
      "--model",        model,         "--out",  fmt::format("livelink://127.0.0.1:{}", sink_port),
      "--record",       take.string(), "--page", "off",
      "--json"};
  command.insert(command.end(), more.begin(), more.end());
  return app::Child::start(std::move(command), app::Child::Input::none);
}

/// What the take tells that the session's summary does not.
Result<void> read_take(const AttackScene& scene, const std::filesystem::path& path, const std::string& hash,
                       AttackFigures& out) {
  MIEN_TRY_ASSIGN(const RecordedSession recorded, read_recorded(path, scene.model, hash));
  out.same_bits = recorded.same_bits;
  const auto begin = begin_of(scene.played, recorded.entries, recorded.samples);
  if (!begin) return {};  // No device was heard, and that stands there.
  const auto is_evaluated = [](const take::TruthFrame& truth) { return truth.evaluated; };
  const auto& truth = scene.played.truth;
  const auto first = std::ranges::find_if(truth, is_evaluated) - truth.begin();
  const HostTime from = scene.played.ticks[static_cast<std::size_t>(first)].fired + *begin;
  const HostTime to = scene.played.ticks.back().fired + *begin;
  for (const take::StoredSample& sample : recorded.samples)
    if (sample.arrival >= from && sample.arrival < to)
      ++(recorded.source(sample).starts_with(kDevices) ? out.heard : out.strangers);
  out.added = recorded.added(from, to);
  if (scene.meter)
    out.pve_mm = measure::measure_track(*scene.meter, truth,
                                        shown(scene.played, *begin, recorded.ticks, recorded.frames))
                     .pve_mm.mean;
  return {};
}

std::filesystem::path take_in(const std::filesystem::path& folder) {
  return folder / "take.mien";
}

/// `mien live`, once it listens. Errors: io (it does not).
Result<app::Child> start_session(const AttackScene& scene, const Boards& boards,
                                 const std::filesystem::path& folder, std::uint16_t port,
                                 std::uint16_t sink_port) {
  const std::string address = fmt::format("udp://127.0.0.1:{}", port);
  std::vector<std::string> more = {"--listen", address};
  if (boards.keyed) {
    const std::filesystem::path key = folder / "key";
    MIEN_TRY(write_file(key, key_text(run_key(scene.seed))));
    more.insert(more.end(), {"--key", key.string()});
  }
  MIEN_TRY_ASSIGN(app::Child session, start_live(scene.rig, scene.model, take_in(folder), sink_port, more));
  for (const auto from = Clock::now(); !somebody_listens(port);) {
    if (Clock::now() - from > kPatience) return fail(ErrorCode::io, "the session does not listen", address);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return session;
}

/// The performance. `seen` is asked often: how far it is, and for how long it goes on; false stops it.
/// Errors: the performance's; cancelled.
Result<void> perform_for(const AttackScene& scene, const Boards& boards, std::uint16_t port,
                         Overheard& overheard, const std::function<bool(double share, double time_s)>& seen) {
  app::NetworkOptions network;
  const bool slimevr = boards.language == virt::NodeLanguage::slimevr;
  network.to = fmt::format("{}://127.0.0.1:{}", slimevr ? "slimevr" : "udp", port);
  network.title = "";
  if (boards.keyed) network.key = run_key(scene.seed);
  network.sent = [&](std::span<const std::byte> datagram) { overheard.add(datagram); };
  const double lasts_s = scene.stage.motion.motion.duration_s();
  std::optional<Clock::time_point> begun;
  bool stopped = false;
  network.enough = [&](std::size_t) {
    if (!begun) begun = Clock::now();
    const double time_s = seconds_since(*begun);
    stopped = !seen(std::min(1.0, time_s / lasts_s), time_s);
    return stopped;
  };
  MIEN_TRY_ASSIGN(const app::NetworkSummary performed,
                  app::perform_to_network(virt::Stage(scene.stage), network));
  if (stopped || performed.stopped) return fail(ErrorCode::cancelled, "stopped", "bench attack");
  return {};
}

/// Of a session until it is judged: by then it has asked its cameras and its clocks have settled.
constexpr double kBegins_s = 2;
constexpr std::size_t kPicturesKept = 40;

/// What the take tells of the time that is judged. `good`: addresses of the cameras that are heard.
Result<void> read_camera_take(const CameraScene& scene, const std::filesystem::path& path,
                              const std::string& hash, const std::array<std::string, 2>& good,
                              AttackFigures& out) {
  MIEN_TRY_ASSIGN(const RecordedSession recorded, read_recorded(path, scene.model, hash));
  out.same_bits = recorded.same_bits;
  std::optional<HostTime> from;
  for (const take::StoredSample& sample : recorded.samples) {
    if (std::ranges::find(good, recorded.source(sample)) == good.end()) continue;
    if (!from) from = sample.arrival + from_seconds(kBegins_s);
    if (sample.arrival >= *from && sample.arrival < *from + from_seconds(scene.seconds)) ++out.heard;
  }
  if (from) out.added = recorded.added(*from, *from + from_seconds(scene.seconds));
  return {};
}

}  // namespace

const Columns<AttackFigures>& attack_columns() {
  using F = AttackFigures;
  static const Columns<F> columns = {
      {"frames", "frames", "{:.0f}", &F::frames},
      {"added", "added", "{:.0f}", &F::added},
      {"missed", "missed", "{:.0f}", &F::missed},
      {"p50_ms", "p50 ms", "{:.2f}", &F::p50_ms},
      {"p99_ms", "p99 ms", "{:.2f}", &F::p99_ms},
      {"peak_memory_mb", "MB", "{:.1f}", &F::peak_memory_mb},
      {"dropped", "dropped", "{:.0f}", &F::dropped},
      {"evicted", "", "", &F::evicted},
      {"malformed", "", "", &F::malformed},
      {"heard", "", "", &F::heard},
      {"strangers_heard", "", "", &F::strangers},
      {"pve_mm", "PVE mm", "{:.3f}", [](const F& f) { return or_null(f.pve_mm); }},
      {"sent", "sent", "{:.0f}", &F::sent},
      {"same_bits", "", "", &F::same_bits}};
  return columns;
}

Result<std::string> read_summary(const app::ChildOutput& said, AttackFigures& out) {
  Json summary = Json::parse(said.out, nullptr, false);
  if (summary.is_discarded() || !summary.contains("latency_ms"))
    return fail(ErrorCode::internal, said.complaints.empty() ? "the session said nothing" : said.complaints,
                "bench attack");
  const auto number = [](const Json& object, const char* name) {
    return object[name].is_number() ? object[name].get<double>() : 0.0;
  };
  out.frames = number(summary, "frames");
  out.missed = number(summary, "missed");
  out.p50_ms = number(summary["latency_ms"], "p50");
  out.p99_ms = number(summary["latency_ms"], "p99");
  out.peak_memory_mb = number(summary, "peak_memory_mb");
  out.dropped = number(summary, "dropped");
  out.evicted = number(summary, "evicted");
  out.malformed = number(summary, "malformed");
  return summary["hash"].get<std::string>();
}

Result<AttackScene> set_attack_scene(const SceneRequest& request) {
  AttackScene scene;
  scene.rate = request.rate;
  scene.seed = request.seed;
  MIEN_TRY_ASSIGN(const std::filesystem::path rig, app::path_or(request.rig, "rigs/default.toml"));
  virt::StageRequest performance;
  performance.script = performer::default_script(performer::Block::mixed, request.seconds);
  performance.script_name = "mixed";
  performance.face = fmt::format("builtin:{}", request.seed);
  performance.rig = rig;
  performance.seed = request.seed;
  if (!request.calibrated) performance.prologue = performer::PrologueKind::none;
  MIEN_TRY_ASSIGN(scene.stage, virt::set_stage(performance));
  sit_still(scene.stage.motion, request.still_s);
  MIEN_TRY_ASSIGN(scene.played, virt::play(scene.stage));
  MIEN_TRY_ASSIGN(const std::filesystem::path model, modalities::live_model(scene.stage.rig, request.model));
  scene.rig = rig.string();
  scene.model = model.string();
  if (request.calibrated) {
    MIEN_TRY_ASSIGN(const face::Face face, app::chosen_face(performance.face));
    scene.meter = std::make_unique<measure::Meter>(face);
  }
  return scene;
}

Result<AttackFigures> run_attacked_session(const AttackScene& scene, const Attack* attack,
                                           const Boards& boards, const Progress& progress) {
  MIEN_TRY_ASSIGN(const app::PrivateFolder folder, app::PrivateFolder::make());
  const std::uint16_t port = free_port();
  asio::io_context io;
  const udp::socket face = loopback(io);  // Somebody who gets the face, and does nothing with it.
  MIEN_TRY_ASSIGN(app::Child session,
                  start_session(scene, boards, folder.path(), port, face.local_endpoint().port()));
  Overheard overheard(scene.stage.rig);
  std::unique_ptr<Stranger> stranger;
  const auto attack_now = [&] {
    stranger = std::make_unique<Stranger>(*attack, port, Victims{scene.stage.rig, overheard}, scene.rate,
                                          scene.seed);
  };
  if (attack != nullptr && attack->begins == Attack::Begins::first) {
    attack_now();
    std::this_thread::sleep_for(kLead);
  }
  const auto seen = [&](double share, double performed_s) {
    if (attack != nullptr && !stranger && performed_s > to_seconds(kLead)) attack_now();
    return progress(share, attack == nullptr ? "nobody attacks" : attack->name);
  };
  MIEN_TRY(perform_for(scene, boards, port, overheard, seen));
  AttackFigures out;
  if (stranger) out.sent = static_cast<double>(stranger->sent());
  // It is asked to end while the stranger goes on.
  MIEN_TRY_ASSIGN(const app::ChildOutput said, session.stop(kPatience));
  stranger.reset();
  MIEN_TRY_ASSIGN(const std::string hash, read_summary(said, out));
  if (out.frames > 0) MIEN_TRY(read_take(scene, take_in(folder.path()), hash, out));
  return out;
}

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
                  start_live(scene.rig, scene.model, take, face.local_endpoint().port(),
                             {"--listen", good[0], "--listen", second, "--listen", good[1]}));
  for (const auto from = Clock::now(); !cameras->are_all_watched();) {
    if (Clock::now() - from > kPatience)
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
  MIEN_TRY_ASSIGN(const app::ChildOutput said, session.stop(kPatience));
  MIEN_TRY_ASSIGN(const std::string hash, read_summary(said, out));
  if (out.frames > 0) MIEN_TRY(read_camera_take(scene, take, hash, good, out));
  return out;
}

}  // namespace mien::lab
