#include "app/camera_import.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "app/command.h"
#include "app/footage.h"
#include "mien/core/bytes.h"
#include "mien/core/excerpt.h"
#include "mien/core/files.h"
#include "mien/headset/jpeg_gate.h"
#include "mien/headset/picture_packet.h"
#include "mien/modalities/modalities.h"
#include "mien/render/image.h"
#include "mien/sensor/bindings.h"
#include "mien/sensor/picture_view.h"
#include "mien/session/event_list.h"
#include "mien/session/performed_prologue.h"
#include "mien/session/prompt.h"
#include "mien/session/session.h"
#include "mien/tracker/tracker.h"

namespace mien::app {
namespace {

/// When the first picture was taken, of the cameras' clocks: what came before it has room.
constexpr double kBegin_s = 1;
/// As a rig's camera may have them (docs/guide/rigs.md).
constexpr double kLeastFps = 1, kMostFps = 130;
constexpr int kLeastSide = 16;
constexpr std::size_t kMaxEventBytes = std::size_t{4} << 20U;
/// The finest that a camera's picture has room for.
constexpr int kQualities[] = {95, 85, 70, 50, 30, 10};

struct Named {
  std::string name, value;
};

Result<Named> split(const std::string& text, const char* option, const char* like) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == text.size())
    return fail(ErrorCode::bad_usage, fmt::format("'{}' has no name and value", excerpt(text)), option,
                fmt::format("write it like {}", like));
  return Named{text.substr(0, equals), text.substr(equals + 1)};
}

/// One camera on the way into the take.
struct Recorded {
  std::uint16_t sensor = 0;
  sensor::DeviceKey device;
  std::unique_ptr<Footage> footage;
  std::optional<Footage::Shot> next;
  Duration half_exposure{};
  std::uint32_t sequence = 0;
  ImportedPictures::Camera done;
};

/// The camera of this name. Errors: bad_usage, with those that there are.
Result<std::uint16_t> find_camera(const sensor::Rig& rig, const std::string& name, const char* option) {
  const auto found = rig.find(name);
  if (found && rig.sensors[*found].camera) return *found;
  std::vector<std::string> names;
  for (const sensor::Mount& mount : rig.sensors)
    if (mount.camera) names.push_back(mount.name);
  return fail(ErrorCode::bad_usage, fmt::format("no camera of the rig is called '{}'", excerpt(name)), option,
              names.empty() ? "the rig has no cameras; take another with --rig"
                            : fmt::format("there are {}", fmt::join(names, ", ")));
}

Result<std::array<double, 4>> parse_crop(const std::string& text) {
  constexpr const char* kLike = "eye_L=0.1,0.2,0.8,0.8: left, top, width and height as shares of the picture";
  std::array<double, 4> crop{};
  const char* at = text.data();
  const char* const end = text.data() + text.size();
  for (std::size_t i = 0; i < crop.size(); ++i) {
    const auto [read, wrong] = std::from_chars(at, end, crop[i]);
    const bool last = i + 1 == crop.size();
    if (wrong != std::errc{} || (last ? read != end : read == end || *read != ','))
      return fail(ErrorCode::bad_usage, fmt::format("'{}' is not four numbers", excerpt(text)), "--crop",
                  fmt::format("write it like {}", kLike));
    if (!last) at = read + 1;
  }
  if (!sensor::check_crop(crop, "--crop"))
    return fail(ErrorCode::bad_usage,
                fmt::format("'{}' leaves the picture, or too little of it", excerpt(text)), "--crop",
                fmt::format("write it like {}", kLike));
  return crop;
}

/// The size that a picture has in the take: its own, or the largest of its shape that a camera may have.
std::array<int, 2> size_in_take(const headset::PictureCopy& picture) {
  const double shrink = std::min({1.0, static_cast<double>(headset::kMaxPictureWidth) / picture.width,
                                  static_cast<double>(headset::kMaxPictureHeight) / picture.height});
  return {static_cast<int>(std::lround(picture.width * shrink)),
          static_cast<int>(std::lround(picture.height * shrink))};
}

/// What each option asks of the rig, and the footage with its first pictures.
Result<std::vector<Recorded>> open_cameras(const CameraImport& options, sensor::Rig& rig) {
  std::vector<Recorded> cameras;
  for (const std::string& text : options.cameras) {
    MIEN_TRY_ASSIGN(const Named named, split(text, "--camera", "eye_L=FOLDER"));
    MIEN_TRY_ASSIGN(const std::uint16_t sensor, find_camera(rig, named.name, "--camera"));
    if (std::ranges::count(cameras, sensor, &Recorded::sensor) > 0)
      return fail(ErrorCode::bad_usage, fmt::format("{} is given twice", named.name), "--camera",
                  "name each camera once");
    Recorded& camera = cameras.emplace_back();
    camera.sensor = sensor;
    camera.done.name = named.name;
    MIEN_TRY_ASSIGN(camera.footage, Footage::open(named.value));
    MIEN_TRY_ASSIGN(camera.next, camera.footage->next());
    if (!camera.next)
      return fail(ErrorCode::not_found, "no picture is in this film", named.value, "look whether it plays");
    const auto [width, height] = size_in_take(camera.next->picture);
    if (width < kLeastSide || height < kLeastSide)
      return fail(
          ErrorCode::out_of_range,
          fmt::format("a picture of {} x {}", camera.next->picture.width, camera.next->picture.height),
          camera.next->where, fmt::format("a camera's have {0} x {0} at least", kLeastSide));
    camera.done.width = width;
    camera.done.height = height;
    sensor::CameraMount& mount = *rig.sensors[sensor].camera;
    mount.size = {width, height};
    mount.rate_hz = options.fps;
    mount.exposure_ms = std::min(mount.exposure_ms, 1000 / options.fps);
    camera.half_exposure = from_seconds(mount.exposure_ms / 2000);
  }
  for (const std::string& name : options.mirrored) {
    MIEN_TRY_ASSIGN(const std::uint16_t sensor, find_camera(rig, name, "--mirror"));
    rig.sensors[sensor].camera->mirror = !rig.sensors[sensor].camera->mirror;
  }
  for (const std::string& text : options.crops) {
    MIEN_TRY_ASSIGN(const Named named, split(text, "--crop", "eye_L=0.1,0.2,0.8,0.8"));
    MIEN_TRY_ASSIGN(const std::uint16_t sensor, find_camera(rig, named.name, "--crop"));
    MIEN_TRY_ASSIGN(rig.sensors[sensor].camera->crop, parse_crop(named.value));
  }
  std::ranges::sort(cameras, {}, &Recorded::sensor);
  return cameras;
}

/// Binds every camera that is recorded to a device, and gives the grid a reference that is.
Result<void> bind_cameras(std::vector<Recorded>& cameras, sensor::Rig& rig) {
  MIEN_TRY_ASSIGN(auto bound, sensor::bindings(rig));
  for (Recorded& camera : cameras) {
    auto found = std::ranges::find(bound, camera.sensor, [](const auto& one) { return one.second; });
    if (found == bound.end()) {
      const sensor::DeviceKey device{sensor::virtual_device(camera.sensor), 0};
      rig.sensors[camera.sensor].device = sensor::format_device(device);
      found = bound.emplace(bound.end(), device, camera.sensor);
    }
    camera.device = found->first;
  }
  const auto reference = rig.find(rig.reference);
  if (!reference || std::ranges::count(cameras, *reference, &Recorded::sensor) == 0)
    rig.reference = cameras.front().done.name;
  return {};
}

/// The shot as a camera would have sent it. A JPEG of the right size stays as it is.
Result<std::vector<std::byte>> jpeg_of(Footage::Shot shot, ImportedPictures::Camera& camera) {
  const bool fits = shot.picture.width == camera.width && shot.picture.height == camera.height;
  if (fits && !shot.jpeg.empty()) return std::move(shot.jpeg);
  if (!fits) {
    ++camera.scaled;
    shot.picture = headset::scaled_picture(shot.picture.view(), camera.width, camera.height);
  }
  for (const int quality : kQualities) {
    MIEN_TRY_ASSIGN(std::vector<std::byte> jpeg,
                    render::encode_jpeg(camera.width, camera.height, render::JpegPixels::grey, quality,
                                        shot.picture.pixels));
    if (jpeg.size() <= sensor::kMaxPayload) return jpeg;
  }
  return fail(ErrorCode::out_of_range,
              fmt::format("it does not fit into a camera's picture of {} KiB", sensor::kMaxPayload >> 10U),
              shot.where, "make it smaller");
}

/// The take as it grows, received by a session without trackers.
class GrowingTake {
 public:
  GrowingTake(take::TakeWriter writer, std::unique_ptr<session::Session> session, const face::Motion* motion,
              DeviceTime first)
      : writer_(std::move(writer)), session_(std::move(session)), first_(first) {
    if (motion != nullptr) curve_.emplace(*motion);
  }
  /// What happened; before the pictures.
  void add(std::span<const take::Event> events) {
    for (const take::Event& event : events) writer_.add_event(event);
    entry_ = session::begin_log(events, HostTime(first_.time_since_epoch()), writer_);
  }
  /// Errors: malformed (no camera's picture).
  Result<void> add(HostTime arrival, std::span<const std::byte> packet, std::span<const std::byte> jpeg,
                   const std::string& where) {
    fire(arrival);
    const auto received = session_->receive(arrival, kPeer, packet, jpeg);
    if (received.samples.empty()) return fail(ErrorCode::malformed, "a picture that no session takes", where);
    entry_ = writer_.add_entry(arrival, "import", packet, {.bytes = jpeg, .reducer = {}});
    for (const sensor::Sample& sample : received.samples) writer_.add_sample(entry_, arrival, sample);
    fire(arrival);
    return {};
  }
  /// All frames that are due by then.
  void fire(HostTime now) {
    while (const auto due = session_->due(now)) {
      writer_.add_tick({due->index, entry_, due->fired, due->frame});
      ++frames;
      if (!curve_) continue;
      const double motion_s = to_seconds(due->frame - first_);
      const face::MotionFrame moment = curve_->at(motion_s);
      take::TruthFrame known;
      known.time = due->frame;
      known.weights = moment.weights;
      known.tongue_out = moment.tongue_out;
      known.has_face = moment.has_face;
      known.evaluated = motion_s >= 0 && motion_s <= curve_->duration_s();
      truth += known.evaluated && known.has_face ? 1 : 0;
      writer_.add_truth(known);
    }
  }
  [[nodiscard]] take::TakeWriter& writer() { return writer_; }

  std::size_t frames = 0, truth = 0;

 private:
  static constexpr sensor::Peer kPeer = 0;
  take::TakeWriter writer_;
  std::unique_ptr<session::Session> session_;
  std::optional<face::MotionCurve> curve_;
  DeviceTime first_;
  std::int64_t entry_ = 0;
};

take::Event event_of(const session::ListedEvent& listed, DeviceTime first) {
  const DeviceTime begin = first + from_seconds(listed.time_s);
  // What calibrates is an event of its own kind.
  const bool step = tracker::step_named(listed.name) != tracker::Step::none;
  return {step ? listed.name : "prompt", begin, begin + from_seconds(listed.seconds),
          step ? std::string()
               : session::prompt_event_json(
                     {.name = listed.name, .say = {}, .seconds = listed.seconds, .target = {}})};
}

}  // namespace

void CameraImport::add_to(Command command) {
  const Command group = command.add_group("Cameras", "For recorded pictures of a headset's cameras");
  const Option camera =
      group
          .add_option("--camera", cameras,
                      "NAME=FOLDER or NAME=FILM: what the rig's camera NAME recorded, pictures (.jpg, .pgm, "
                      ".ppm) in the order of their names or a film; again for each camera")
          .repeated();
  group.add_option("--fps", fps, "Pictures a second, of each camera")
      .number_between(kLeastFps, kMostFps)
      .needs(camera);
  group
      .add_option("--mirror", mirrored,
                  "NAME: its pictures are mirrored against what the rig says; again for each camera")
      .repeated()
      .needs(camera);
  group
      .add_option("--crop", crops,
                  "NAME=LEFT,TOP,WIDTH,HEIGHT: the part that the network sees, in shares of the picture, "
                  "instead of the rig's; again for each camera")
      .repeated()
      .needs(camera);
  group
      .add_option("--events", events,
                  "A CSV of what was asked for when, 'time_s,name', seconds from the first picture; neutral "
                  "calibrates")
      .needs(camera);
}

Result<ImportedPictures> import_pictures(const CameraImport& options, const std::filesystem::path& rig_file,
                                         take::Header header, const face::Motion* truth,
                                         const std::filesystem::path& out, bool replace) {
  if (options.fps == 0)
    return fail(ErrorCode::bad_usage, "nothing says how fast the cameras were", "--fps",
                "give the pictures a second: --fps 25");
  MIEN_TRY_ASSIGN(sensor::Rig rig, sensor::read_rig(rig_file));
  std::vector<session::ListedEvent> events;
  if (!options.events.empty()) {
    MIEN_TRY_ASSIGN(const std::string csv, read_text(options.events, kMaxEventBytes));
    MIEN_TRY_ASSIGN(events, session::parse_event_list(csv, options.events));
  }
  MIEN_TRY_ASSIGN(std::vector<Recorded> cameras, open_cameras(options, rig));
  MIEN_TRY(bind_cameras(cameras, rig));
  header.rig_toml = sensor::write_rig(rig);
  MIEN_TRY_ASSIGN(auto receiving, modalities::make_receiving_session(rig));
  MIEN_TRY_ASSIGN(take::TakeWriter writer,
                  take::TakeWriter::create(out, header, replace, take::Appears::when_finished));
  const DeviceTime first(from_seconds(kBegin_s));
  GrowingTake growing(std::move(writer), std::move(receiving), truth, first);
  std::vector<take::Event> happened;
  for (const session::ListedEvent& event : events) happened.push_back(event_of(event, first));
  growing.add(happened);

  std::size_t about = 0;
  for (const Recorded& camera : cameras) about = std::max(about, camera.footage->about());
  const Duration last_read = std::ranges::max_element(cameras, {}, &Recorded::half_exposure)->half_exposure;
  const Progress progress = terminal_progress("import");
  std::size_t moment = 0;
  HostTime arrival;
  for (bool more = true; more; ++moment) {
    const double share = about > 0 ? static_cast<double>(moment) / static_cast<double>(about) : 0;
    if (!progress(std::min(0.999, share), fmt::format("picture {}", moment + 1)))
      return fail(ErrorCode::cancelled, "stopped", out.string(), "nothing was kept");
    const DeviceTime taken = first + from_seconds(static_cast<double>(moment) / options.fps);
    arrival = HostTime(taken.time_since_epoch() + last_read);
    more = false;
    for (Recorded& camera : cameras) {
      if (!camera.next) continue;
      const std::string where = camera.next->where;
      MIEN_TRY_ASSIGN(const std::vector<std::byte> jpeg, jpeg_of(*std::move(camera.next), camera.done));
      ByteWriter packet;
      MIEN_TRY(headset::write_picture_packet({.from = camera.device,
                                              .sequence = camera.sequence,
                                              .time = taken + camera.half_exposure,
                                              .first = camera.sequence == 0},
                                             packet));
      MIEN_TRY(growing.add(arrival, packet.bytes(), jpeg, where));
      ++camera.sequence;
      ++camera.done.pictures;
      MIEN_TRY_ASSIGN(camera.next, camera.footage->next());
      more = more || camera.next.has_value();
    }
    MIEN_TRY(growing.writer().status());
  }
  growing.fire(arrival + from_seconds(1 / options.fps));
  MIEN_TRY(growing.writer().finish());
  progress(1, "written");
  ImportedPictures imported{.cameras = {},
                            .frames = growing.frames,
                            .truth = growing.truth,
                            .events = events.size(),
                            .seconds = static_cast<double>(moment) / options.fps};
  for (Recorded& camera : cameras) imported.cameras.push_back(std::move(camera.done));
  return imported;
}

std::string pictures_text(const ImportedPictures& imported) {
  std::string text;
  std::size_t most = 0;
  for (const ImportedPictures::Camera& camera : imported.cameras) most = std::max(most, camera.pictures);
  for (const ImportedPictures::Camera& camera : imported.cameras) {
    text += fmt::format("  {:<10} {} pictures of {} x {}", camera.name, camera.pictures, camera.width,
                        camera.height);
    if (camera.scaled > 0) text += fmt::format(", {} of them scaled to that", camera.scaled);
    if (camera.pictures < most) text += fmt::format(", {} fewer than the longest", most - camera.pictures);
    text += "\n";
  }
  return text;
}

nlohmann::json pictures_json(const ImportedPictures& imported) {
  nlohmann::json cameras = nlohmann::json::array();
  for (const ImportedPictures::Camera& camera : imported.cameras)
    cameras.push_back({{"name", camera.name},
                       {"pictures", camera.pictures},
                       {"width", camera.width},
                       {"height", camera.height},
                       {"scaled", camera.scaled}});
  return cameras;
}

}  // namespace mien::app
