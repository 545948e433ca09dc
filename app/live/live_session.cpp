#include "app/live/live_session.h"

#include <utility>  // Before Asio 1.74, which forgets it.
//
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sodium.h>

#include <algorithm>
#include <array>
#include <boost/asio/ip/address.hpp>
#include <chrono>
#include <ctime>
#include <functional>
#include <future>
#include <iterator>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <ranges>

#include "app/command.h"
#include "app/gltf_option.h"
#include "app/live/camera_feed.h"
#include "app/live/page_files.h"
#include "app/live/pairing_key.h"
#include "app/live/phone_feed.h"
#include "app/live/phone_teacher.h"
#include "app/live/prompt_source.h"
#include "app/live/sound_feed.h"
#include "mien/core/encoding.h"
#include "mien/core/files.h"
#include "mien/core/host_port.h"
#include "mien/face/rig_constraints.h"
#include "mien/modalities/modalities.h"
#include "mien/render/face_textures.h"
#include "mien/render/gltf_export.h"
#include "mien/render/surface_paint.h"
#include "mien/sensor/rig_part.h"

namespace mien::app {
namespace {

std::string now_utc() {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(now));
}

/// An error of an output says the option too: there may be several, and other addresses beside them.
Error with_option(Error error, const std::vector<std::string>& outputs) {
  if (std::ranges::find(outputs, error.where) != outputs.end()) error.where = "--out " + error.where;
  return error;
}

/// What the page shows of pairing: of the session's own key file, or of the user's, made where there is none.
Result<live::Pairing> pairing_of(const std::string& given) {
  std::filesystem::path file = given;
  if (file.empty()) {
    MIEN_TRY_ASSIGN(file, default_pairing_key());
  }
  MIEN_TRY_ASSIGN(const sensor::SealKey key, given.empty() ? make_pairing_key(file) : read_pairing_key(file));
  return live::Pairing{.file = file.string(), .firmware = firmware_line(key), .command = keyed_command(file)};
}

/// What `make` makes, once, on a thread of its own, when somebody first asks.
template <class T>
std::function<std::shared_future<Result<T>>()> when_asked(std::function<Result<T>()> make) {
  struct Made {
    std::mutex mutex;
    std::shared_future<Result<T>> future;
  };
  return [made = std::make_shared<Made>(), make = std::move(make)] {
    const std::scoped_lock lock(made->mutex);
    if (!made->future.valid()) made->future = std::async(std::launch::async, make).share();
    return made->future;
  };
}

/// A face as the page loads it, and where it is a built-in one its pictures, which the page asks for when the
/// face is seen. The built-in one takes longer than all else at the beginning of a session and cannot fail:
/// it is made when somebody looks. What is wrong with others is known before the session begins.
Result<std::vector<live::Asset>> face_files(const std::string& name) {
  using Bytes = std::vector<std::byte>;
  const auto face = when_asked<TexturedFace>([name] { return textured_face(name, {}); });
  const auto gltf = when_asked<Bytes>([face]() -> Result<Bytes> {
    const Result<TexturedFace>& made = face().get();
    if (!made) return std::unexpected(made.error());
    render::GltfTextures textures = made->textures;
    textures.beside = textures.side_px > 0;
    textures.side_px = 0;
    return render::encode_gltf(made->face, nullptr, render::GltfKind::binary, render::GltfNames::ict,
                               textures);
  });
  std::vector<live::Asset> files;
  files.push_back(
      {.path = "/face.glb", .type = "model/gltf-binary", .bytes = {}, .open = false, .make = gltf});
  if (name != "builtin") {
    MIEN_TRY(gltf().get());
    if (face().get()->textures.side_px == 0) return files;
  }
  // On one thread: frames go on meanwhile.
  const auto pictures = when_asked<render::TextureFiles>([face]() -> Result<render::TextureFiles> {
    const Result<TexturedFace>& made = face().get();
    if (!made) return std::unexpected(made.error());
    return render::bake_texture_files(made->face, render::SurfacePaint(made->face, made->textures.marks),
                                      made->textures.side_px, 1);
  });
  const auto add = [&](std::string_view path, Bytes render::TextureFiles::*which) {
    const auto make = when_asked<Bytes>([pictures, which]() -> Result<Bytes> {
      const Result<render::TextureFiles>& made = pictures().get();
      if (!made) return std::unexpected(made.error());
      return (*made).*which;
    });
    files.push_back({.path = path, .type = "image/jpeg", .bytes = {}, .open = false, .make = make});
  };
  static const std::array<std::string, 3> kPaths = {fmt::format("/{}", render::kAlbedoFile),
                                                    fmt::format("/{}", render::kRoughnessFile),
                                                    fmt::format("/{}", render::kNormalFile)};
  add(kPaths[0], &render::TextureFiles::albedo);
  add(kPaths[1], &render::TextureFiles::roughness);
  add(kPaths[2], &render::TextureFiles::normal);
  return files;
}

Result<std::optional<live::PageSettings>> page_settings(const LiveRequest& request) {
  if (request.page == "off") return std::optional<live::PageSettings>();
  const auto wrong = [&request] {
    return fail(ErrorCode::bad_usage, "not an address for the page", "--page " + request.page,
                "write it as 127.0.0.1:8740, or off");
  };
  live::PageSettings page;
  const auto address = parse_host_port(request.page);
  boost::system::error_code no_number;
  if (address) static_cast<void>(boost::asio::ip::make_address(address->host, no_number));
  if (!address || (no_number && address->host != "localhost")) return wrong();
  page.host = address->host;
  page.port = address->port.value_or(page.port);
  MIEN_TRY_ASSIGN(page.token, given_token(request.token));
  if (!is_loopback(page.host) && page.token.empty()) {
    // Whoever opens the page to a network gets a token, whether they thought of one or not.
    std::array<std::byte, 16> bytes{};
    randombytes_buf(bytes.data(), bytes.size());
    page.token = hex(bytes);
  }
  page.assets = page_files();
  if (page.assets.empty())
    return fail(ErrorCode::not_found, "this program was built without its page", request.page,
                "run with --page off, or build it with npm installed");
  MIEN_TRY_ASSIGN(std::vector<live::Asset> face, face_files(request.face));
  std::ranges::move(face, std::back_inserter(page.assets));
  return std::optional(std::move(page));
}

/// What puts the rules of a file in force, or none. Errors: RigConstraints::read's, out_of_range (a command
/// cannot hold it).
Result<session::Command> constraints_command(const std::string& file) {
  face::RigConstraints rules;
  if (file != "off") {
    MIEN_TRY_ASSIGN(rules, face::RigConstraints::read(file));
  }
  session::Shape shape{nlohmann::json{{"constraints", true}, {"rules", rules.text()}}.dump()};
  if (const std::size_t bytes = session::write_command(shape).size(); bytes > session::kMaxCommandBytes)
    return fail(ErrorCode::out_of_range,
                fmt::format("{} bytes as a command are more than {}", bytes, session::kMaxCommandBytes), file,
                "take comments out");
  return shape;
}

/// What keeping pictures takes, said before it begins.
std::string pictures_text(const sensor::Rig& rig, const std::vector<std::uint16_t>& cameras) {
  if (cameras.empty()) return "No camera is asked for its pictures, so none are kept";
  const PictureBytes bytes = picture_bytes_an_hour(rig, cameras);
  return fmt::format(
      "Pictures of the face are kept as they come: {:.1f} to {:.1f} GB an hour, in the session's "
      "log and again in a take",
      1e-9 * bytes.least, 1e-9 * bytes.most);
}

}  // namespace

Result<LiveSession> open_live(LiveRequest request) {
  LiveSession out;
  live::EngineSettings settings;
  MIEN_TRY_ASSIGN(request.rig, path_or(request.rig, "rigs/default.toml"));
  MIEN_TRY_ASSIGN(std::string rig_toml, read_text(request.rig));
  MIEN_TRY_ASSIGN(sensor::Rig rig, sensor::parse_rig(rig_toml, request.rig));
  if (request.audio == "page" && request.page == "off")
    return fail(ErrorCode::bad_usage, "there is no page whose browser could be heard", "--audio page",
                "leave out --page off, or hear this machine's microphone with --audio default");
  // A rig's own microphone is opened, or heard, from the page, and only there, where the command line names
  // none.
  const bool own = request.audio.empty() && !sensor::sensors_of(rig, "speech").empty();
  if (!request.hears_by.empty() && !own && request.audio.empty())
    return fail(ErrorCode::bad_usage, "this rig has no microphone to hear by",
                "--hears-by " + request.hears_by, "give --audio too");
  if (!request.no_audio && (own || !request.audio.empty())) {
    const bool from_network = own ? hears_network(rig) : request.audio == kFromNetwork;
    auto hearing = with_microphone(rig, request.hears_by, from_network);
    // One that is bound to no device yet is nobody's to open.
    if (!hearing && !own) return std::unexpected(std::move(hearing).error());
    if (hearing) {
      rig = *std::move(hearing);
      rig_toml = sensor::write_rig(rig);
      const std::string& microphone = rig.sensors[sensor::sensors_of(rig, "speech").front()].name;
      if (from_network) {
        settings.network_microphone = microphone;
      } else {
        MIEN_TRY_ASSIGN(settings.feeds.emplace_back(), sound_feed(own ? "default" : request.audio));
        settings.feeds.back().sensor = microphone;
      }
    }
  }
  MIEN_TRY_ASSIGN(ListenedPhones phones, listened_phones(request.listen));
  if (!phones.devices.empty() || !request.phone.empty()) {
    MIEN_TRY_ASSIGN(rig, with_listened(std::move(rig), phones.devices, request.phone));
    rig_toml = sensor::write_rig(rig);
  }
  settings.hear = !own && !request.no_audio;
  settings.shut = request.no_audio;
  if (!settings.hear) settings.commands.emplace_back(session::Shape{R"({"merge": {"audio": false}})"});
  MIEN_TRY_ASSIGN(const std::filesystem::path model, modalities::live_model(rig, request.model));
  std::vector<sensor::SealKey> keys;
  if (!request.key.empty()) {
    MIEN_TRY_ASSIGN(keys.emplace_back(), read_pairing_key(request.key));
  }
  if (!request.constraints.empty()) {
    MIEN_TRY_ASSIGN(settings.commands.emplace_back(), constraints_command(request.constraints));
  }
  if (request.blinks_per_min != shaping::ShaperSettings().blinks_per_min)
    settings.commands.emplace_back(
        session::Shape{nlohmann::json{{"blinks_per_min", request.blinks_per_min}}.dump()});
  if (!request.record.empty()) MIEN_TRY(check_output(request.record, {".mien"}));

  MIEN_TRY_ASSIGN(settings.page, page_settings(request));

  MIEN_TRY_ASSIGN(ListenedCameras cameras, listened_cameras(request.listen, rig));
  const auto other_line = [&](const std::string& address) {
    return address.starts_with("serial:") && !cameras.lines.contains(address);
  };
  if (!keys.empty() && std::ranges::any_of(request.listen, other_line))
    return fail(ErrorCode::bad_usage, "with a key only sealed packets are accepted, and none come by cable",
                "--listen serial:", "leave out --key or the serial line");
  if (!keys.empty() && !phones.devices.empty())
    return fail(ErrorCode::bad_usage, "with a key only sealed packets are accepted, and phones seal none",
                "--key " + request.key, "leave out --key or the phone");
  settings.listen = request.listen;
  std::erase_if(settings.listen, is_phone);
  // Who names a phone alone is heard by sensors too.
  if (settings.listen.empty()) settings.listen = modalities::default_listen();
  std::erase_if(settings.listen, is_camera);
  std::ranges::move(phones.ports, std::back_inserter(settings.listen));
  std::ranges::move(phones.feeds, std::back_inserter(settings.feeds));
  out.phones = std::move(phones.asked);
  std::ranges::move(cameras.feeds, std::back_inserter(settings.feeds));
  settings.line_cameras = std::move(cameras.lines);
  out.cameras = std::move(cameras.all);
  for (const std::uint16_t sensor : sensor::sensors_of(rig, "camera") | std::views::drop(out.cameras.size()))
    out.without_address.push_back(rig.sensors[sensor].name);
  if (request.images) {
    if (sensor::sensors_of(rig, "camera").empty())
      return fail(ErrorCode::bad_usage, "this rig has no camera whose pictures could be kept", "--images",
                  "name one that has with --rig, as rigs/headset.toml");
    out.pictures = pictures_text(rig, cameras.sensors);
  }
  settings.sealed = !keys.empty();
  if (settings.sealed)
    std::ranges::copy(out.cameras | std::views::keys, std::back_inserter(settings.unsealed));
  settings.pair = [file = request.key] { return pairing_of(file); };
  settings.out = request.out;
  if (!request.record.empty()) settings.record = request.record;
  settings.replace = request.force;
  if (request.takes.empty()) request.takes = request.record.parent_path();
  settings.takes = request.takes.empty() ? "." : request.takes;
  // Read when somebody asks; one's own first now, to say what is wrong with them.
  if (!request.texts.empty()) MIEN_TRY(recording_scripts(request.texts));
  settings.scripts = [texts = request.texts] { return recording_scripts(texts); };
  settings.lesson = phone_teacher(model, request.face);
  settings.log_limit = static_cast<std::uint64_t>(1e9 * request.log_limit_gb);
  if (request.seconds > 0) settings.seconds = request.seconds;
  settings.prompts = std::move(request.prompts);
  settings.ends_with_recording = request.only_record;
  settings.model = model.filename().string();
  settings.header.software = "mien " MIEN_VERSION;
  settings.header.performer = request.performer;
  settings.header.script = request.script;
  settings.header.devices = "live";
  settings.header.face = request.face;
  settings.header.prologue = "none";
  settings.header.rig_toml = rig_toml;
  settings.rig = request.rig;
  settings.header.created_utc = now_utc();
  settings.make_session =
      [named = request.model](const sensor::Rig& taken) -> Result<std::unique_ptr<session::Session>> {
    MIEN_TRY_ASSIGN(const std::filesystem::path its_model, modalities::live_model(taken, named));
    return modalities::make_session(taken, its_model);
  };

  const auto pictures = request.images ? modalities::Pictures::kept : modalities::Pictures::reduced;
  MIEN_TRY_ASSIGN(std::unique_ptr<session::Session> session,
                  modalities::make_session(rig, model, {}, keys, pictures));
  auto engine = live::Engine::open(std::move(settings), std::move(session));
  if (!engine) return std::unexpected(with_option(std::move(engine).error(), request.out));
  out.engine = *std::move(engine);
  out.out = std::move(request.out);
  return out;
}

}  // namespace mien::app
