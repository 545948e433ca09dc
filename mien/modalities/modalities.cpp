#include "mien/modalities/modalities.h"

#include <fmt/format.h>
#include <sodium.h>

#include <algorithm>
#include <array>
#include <functional>
#include <span>
#include <string_view>
#include <utility>

#include "mien/core/files.h"
#include "mien/eyewear/eyewear_protocol.h"
#include "mien/eyewear/eyewear_tracker.h"
#include "mien/eyewear/marker_network.h"
#include "mien/imu/imu_tracker.h"
#include "mien/imu/packets/node_message.h"
#include "mien/imu/packets/node_protocol.h"
#include "mien/imu/packets/slimevr.h"
#include "mien/imu/packets/slimevr_protocol.h"
#include "mien/mocap/marker_protocol.h"
#include "mien/model/model_file.h"
#include "mien/sensor/rig_part.h"
#include "mien/shaping/combined_tracker.h"
#include "mien/tracker/causal_tracker.h"

namespace mien::modalities {
namespace {

using MadeTracker = Result<std::unique_ptr<tracker::Tracker>>;

MadeTracker make_imu_tracker(const sensor::Rig& rig, const std::filesystem::path& path) {
  MIEN_TRY_ASSIGN(model::ModelFile file, model::read_model(path));
  auto model = tracker::CausalTracker::create(std::move(file), rig.face_sensor_names());
  if (!model) {
    model.error().where = path.string();
    return std::unexpected(std::move(model).error());
  }
  return std::make_unique<imu::ImuTracker>(rig, std::make_unique<tracker::CausalTracker>(*std::move(model)));
}

MadeTracker make_eyewear_tracker(const sensor::Rig& rig, const std::filesystem::path& path) {
  MIEN_TRY_ASSIGN(const std::filesystem::path markers, find_resource("rigs/markers.toml"));
  MIEN_TRY_ASSIGN(const builtin_face::MarkerSet set, builtin_face::read_markers(markers));
  MIEN_TRY_ASSIGN(eyewear::MarkerNetworkFile file, eyewear::read_marker_network(path));
  if (!std::ranges::equal(file.markers, set.markers, {}, {}, &builtin_face::Marker::name))
    return fail(ErrorCode::mismatch, "the model answers with other markers than " + markers.string(),
                path.string(), "train one with this program's markers");
  MIEN_TRY_ASSIGN(auto regressor,
                  eyewear::NetworkRegressor::create(std::move(file), eyewear::photo_sensor_names(rig)));
  return eyewear::EyewearTracker::create(rig, set, std::move(regressor));
}

Result<void> add_imu_protocols(const std::vector<PairingKey>& keys, Protocols& protocols) {
  imu::NodeProtocolSettings nodes;
  if (sodium_init() < 0) return fail(ErrorCode::internal, "libsodium does not start", "session");
  do {
    randombytes_buf(&nodes.session, sizeof(nodes.session));
  } while (nodes.session == 0);
  for (const PairingKey& key : keys) nodes.keys.push_back({key.id, key.secret});
  MIEN_TRY_ASSIGN(imu::NodeProtocol node_protocol, imu::NodeProtocol::create(std::move(nodes)));
  protocols.push_back(std::make_unique<imu::NodeProtocol>(std::move(node_protocol)));
  if (keys.empty()) protocols.push_back(std::make_unique<imu::SlimeVrProtocol>());
  return {};
}

Result<void> add_eyewear_protocols(const std::vector<PairingKey>& keys, Protocols& protocols) {
  if (!keys.empty()) return {};
  MIEN_TRY_ASSIGN(eyewear::EyewearProtocol protocol, eyewear::EyewearProtocol::create());
  protocols.push_back(std::make_unique<eyewear::EyewearProtocol>(std::move(protocol)));
  return {};
}

/// A kind of sensors: a row of the table, and what a live session knows of it. What a virtual performer wears
/// is a row of mien/virtual/stage.cpp and its training one of mien/train/make_task.cpp, by the same kind.
/// What a guided calibration asks for is its tracker's to say (tracker::Tracker::guidance()).
struct Modality {
  std::string_view kind;                 ///< As rigs and its tracker name it (tracker::Tracker::modality()).
  std::string_view default_model;        ///< Path of the live model from the program's root.
  bool window_models;                    ///< See has_window_models().
  std::span<const std::uint16_t> ports;  ///< UDP ports that its devices send to, unless told otherwise.
  /// Errors: the model's.
  Result<std::unique_ptr<tracker::Tracker>> (*make_tracker)(const sensor::Rig& rig,
                                                            const std::filesystem::path& model);
  /// Appends its protocols; with keys only those in which packets can be sealed.
  Result<void> (*add_protocols)(const std::vector<PairingKey>& keys, Protocols& protocols);
  /// Of its protocols with payloads, and only where these are reduced before they are logged; else null.
  std::vector<session::ProtocolReducer> (*make_reducers)() = nullptr;
};

constexpr std::array kImuPorts = {imu::kNodePort, imu::slimevr::kPort};
constexpr std::array kEyewearPorts = {imu::kNodePort};

/// In the order in which their protocols are asked whether a datagram is theirs: eyewear's packets begin as
/// IMU nodes' do.
constexpr std::array kModalities = {
    Modality{.kind = "eyewear",
             .default_model = "models/eyewear.safetensors",
             .window_models = false,
             .ports = kEyewearPorts,
             .make_tracker = make_eyewear_tracker,
             .add_protocols = add_eyewear_protocols},
    Modality{.kind = "imu",
             .default_model = "models/live.safetensors",
             .window_models = true,
             .ports = kImuPorts,
             .make_tracker = make_imu_tracker,
             .add_protocols = add_imu_protocols},
};

/// The row of a kind; null for one that is unknown.
const Modality* find_modality(std::string_view kind) {
  const auto found = std::ranges::find(kModalities, kind, &Modality::kind);
  return found == kModalities.end() ? nullptr : &*found;
}

std::string known_kinds() {
  std::string all;
  for (const Modality& modality : kModalities)
    all += fmt::format("{}{}", all.empty() ? "" : " or ", modality.kind);
  return all;
}

/// Those of the rig's sensors, in the order in which their kinds come. Errors: unsupported.
Result<std::vector<const Modality*>> modalities_of(const sensor::Rig& rig) {
  std::vector<const Modality*> modalities;
  for (const std::string& kind : sensor::kinds_of(rig)) {
    const Modality* found = find_modality(kind);
    if (found == nullptr)
      return fail(ErrorCode::unsupported, "this version knows no sensors of the kind " + kind,
                  "rig " + rig.name, "use a rig of the kinds " + known_kinds());
    modalities.push_back(found);
  }
  return modalities;
}

using Reshape = std::function<void(const shaping::ShaperSettings&)>;

/// The rig's tracker; of several kinds one that merges theirs, each with the model of its default name in the
/// folder. `reshape` becomes what must be told of other settings, where there is somebody to tell.
MadeTracker make(const sensor::Rig& rig, const std::filesystem::path& model,
                 const shaping::ShaperSettings& shaping, Reshape& reshape) {
  MIEN_TRY_ASSIGN(const std::vector<const Modality*> modalities, modalities_of(rig));
  if (modalities.size() == 1) return modalities.front()->make_tracker(rig, model);
  if (!std::filesystem::is_directory(model))
    return fail(ErrorCode::bad_usage, "a rig with sensors of several kinds wants a folder of models",
                model.string(),
                "name the folder, with each kind's model under its default name, as models/ has them");
  std::vector<shaping::CombinedTracker::Part> parts;
  for (const Modality* modality : modalities) {
    const std::filesystem::path its_model = model / std::filesystem::path(modality->default_model).filename();
    MIEN_TRY_ASSIGN(std::unique_ptr<tracker::Tracker> one,
                    modality->make_tracker(sensor::part_of(rig, modality->kind), its_model));
    parts.push_back({std::move(one), sensor::sensors_of(rig, modality->kind)});
  }
  auto combined = std::make_unique<shaping::CombinedTracker>(std::move(parts), shaping);
  reshape = [tracker = combined.get()](const shaping::ShaperSettings& settings) { tracker->set(settings); };
  return combined;
}

}  // namespace

std::vector<std::string> default_listen() {
  std::vector<std::string> addresses;
  for (const Modality& modality : kModalities)
    for (const std::uint16_t port : modality.ports)
      if (std::string address = fmt::format("udp://0.0.0.0:{}", port);
          std::ranges::find(addresses, address) == addresses.end())
        addresses.push_back(std::move(address));
  return addresses;
}

Result<std::filesystem::path> live_model(const sensor::Rig& rig, const std::string& named) {
  if (!named.empty()) return named;
  MIEN_TRY_ASSIGN(const std::vector<const Modality*> modalities, modalities_of(rig));
  MIEN_TRY_ASSIGN(std::filesystem::path model, find_resource(modalities.front()->default_model));
  return modalities.size() == 1 ? model : model.parent_path();
}

bool has_window_models(const sensor::Rig& rig) {
  const auto modalities = modalities_of(rig);
  return modalities && modalities->size() == 1 && modalities->front()->window_models;
}

Result<std::unique_ptr<tracker::Tracker>> make_tracker(const sensor::Rig& rig,
                                                       const std::filesystem::path& model) {
  Reshape nobody_asks;
  return make(rig, model, {}, nobody_asks);
}

Result<Protocols> make_protocols(const std::vector<PairingKey>& keys) {
  Protocols protocols;
  // Markers are truth, no sensors of a rig. Their packets begin as nodes' do, so they are asked about first;
  // no key seals them.
  if (keys.empty()) protocols.push_back(std::make_unique<mocap::MarkerProtocol>());
  for (const Modality& modality : kModalities) MIEN_TRY(modality.add_protocols(keys, protocols));
  return protocols;
}

Result<std::unique_ptr<session::Session>> make_session(const sensor::Rig& rig,
                                                       const std::filesystem::path& model,
                                                       const shaping::ShaperSettings& shaping,
                                                       const std::vector<PairingKey>& keys) {
  session::Session::Parts parts;
  parts.rig = rig;
  parts.shaping = shaping;
  MIEN_TRY_ASSIGN(parts.tracker, make(rig, model, shaping, parts.reshape));
  MIEN_TRY_ASSIGN(parts.protocols, make_protocols(keys));
  for (const Modality& modality : kModalities)
    if (modality.make_reducers != nullptr)
      for (session::ProtocolReducer& one : modality.make_reducers())
        // Protocols without keys are not there when keys are.
        if (std::ranges::find(parts.protocols, one.protocol, [](const auto& p) { return p->name(); }) !=
            parts.protocols.end())
          parts.reducers.push_back(std::move(one));
  return session::Session::create(std::move(parts));
}

}  // namespace mien::modalities
