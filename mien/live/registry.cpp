#include "mien/live/registry.h"

#include <sodium.h>

#include <algorithm>
#include <utility>

#include "mien/core/files.h"
#include "mien/eyewear/eyewear_protocol.h"
#include "mien/eyewear/eyewear_tracker.h"
#include "mien/eyewear/marker_network.h"
#include "mien/imu/imu_tracker.h"
#include "mien/imu/node_protocol.h"
#include "mien/imu/slimevr_protocol.h"
#include "mien/model/model_file.h"
#include "mien/tracker/causal_tracker.h"

namespace mien::live {
namespace {

using MadeTracker = Result<std::unique_ptr<tracker::Tracker>>;

MadeTracker make_imu_tracker(const sensor::Rig& rig, const std::filesystem::path& path) {
  MIEN_TRY_ASSIGN(model::ModelFile file, model::read_model(path));
  MIEN_TRY_ASSIGN(tracker::CausalTracker model,
                  tracker::CausalTracker::create(std::move(file), rig.face_sensor_names()));
  return std::make_unique<imu::ImuTracker>(rig, std::make_unique<tracker::CausalTracker>(std::move(model)));
}

MadeTracker make_eyewear_tracker(const sensor::Rig& rig, const std::filesystem::path& path) {
  MIEN_TRY_ASSIGN(const std::filesystem::path markers, find_resource("rigs/markers.toml"));
  MIEN_TRY_ASSIGN(const eyewear::MarkerSet set, eyewear::read_markers(markers));
  MIEN_TRY_ASSIGN(eyewear::MarkerNetworkFile file, eyewear::read_marker_network(path));
  if (!std::ranges::equal(file.markers, set.markers, {}, {}, &eyewear::Marker::name))
    return fail(ErrorCode::mismatch, "the model answers with other markers than " + markers.string(),
                path.string(), "train one with this program's markers");
  std::vector<std::string> sensors;
  for (const std::uint16_t s : eyewear::photo_sensors(rig)) sensors.push_back(rig.sensors[s].name);
  MIEN_TRY_ASSIGN(auto regressor, eyewear::NetworkRegressor::create(std::move(file), sensors));
  return eyewear::EyewearTracker::create(rig, set, std::move(regressor));
}

/// One kind of sensors, and what tracks them.
struct Modality {
  std::string_view kind;  ///< As rigs name it.
  const char* default_model;
  bool window_models;
  MadeTracker (*make)(const sensor::Rig&, const std::filesystem::path& model);
};
constexpr std::array kModalities = {
    Modality{"imu", "models/live.safetensors", true, make_imu_tracker},
    Modality{"photo", "models/eyewear.safetensors", false, make_eyewear_tracker},
};

/// That of the rig's sensors. Errors: unsupported.
Result<const Modality*> modality_of(const sensor::Rig& rig) {
  const std::string& kind = rig.sensors.front().kind;
  const auto found = std::ranges::find(kModalities, kind, &Modality::kind);
  if (found == kModalities.end())
    return fail(ErrorCode::unsupported, "this version knows no sensors of the kind " + kind,
                "rig " + rig.name, "use a rig of the kinds imu or photo");
  for (const sensor::Mount& mount : rig.sensors)
    if (mount.kind != kind)
      return fail(ErrorCode::unsupported,
                  "sensors of the kinds " + kind + " and " + mount.kind + " in one rig", "rig " + rig.name,
                  "use a rig with one kind of sensors");
  return &*found;
}

}  // namespace

Result<std::filesystem::path> live_model(const sensor::Rig& rig, const std::string& named) {
  if (!named.empty()) return named;
  MIEN_TRY_ASSIGN(const Modality* modality, modality_of(rig));
  return find_resource(modality->default_model);
}

bool has_window_models(const sensor::Rig& rig) {
  const auto modality = modality_of(rig);
  return modality && (*modality)->window_models;
}

Result<std::unique_ptr<tracker::Tracker>> make_tracker(const sensor::Rig& rig,
                                                       const std::filesystem::path& model) {
  MIEN_TRY_ASSIGN(const Modality* modality, modality_of(rig));
  return modality->make(rig, model);
}

Result<std::vector<std::unique_ptr<sensor::Protocol>>> make_protocols(const std::vector<PairingKey>& keys) {
  std::vector<std::unique_ptr<sensor::Protocol>> protocols;
  imu::NodeProtocolSettings nodes;
  if (sodium_init() < 0) return fail(ErrorCode::internal, "libsodium does not start", "session");
  do {
    randombytes_buf(&nodes.session, sizeof(nodes.session));
  } while (nodes.session == 0);
  for (const PairingKey& key : keys) nodes.keys.push_back({key.id, key.secret});
  MIEN_TRY_ASSIGN(imu::NodeProtocol node_protocol, imu::NodeProtocol::create(std::move(nodes)));
  // The other languages know no keys: whoever asks for them hears our own nodes only. Eyewear's packets begin
  // as nodes' do, so they are asked about first.
  if (keys.empty()) {
    MIEN_TRY_ASSIGN(eyewear::EyewearProtocol eyewear_protocol, eyewear::EyewearProtocol::create());
    protocols.push_back(std::make_unique<eyewear::EyewearProtocol>(std::move(eyewear_protocol)));
  }
  protocols.push_back(std::make_unique<imu::NodeProtocol>(std::move(node_protocol)));
  if (keys.empty()) protocols.push_back(std::make_unique<imu::SlimeVrProtocol>());
  return protocols;
}

Result<std::unique_ptr<Session>> make_session(const sensor::Rig& rig, const std::filesystem::path& model,
                                              const shaping::ShaperSettings& shaping,
                                              const std::vector<PairingKey>& keys) {
  Session::Parts parts;
  parts.rig = rig;
  parts.shaping = shaping;
  MIEN_TRY_ASSIGN(parts.tracker, make_tracker(rig, model));
  MIEN_TRY_ASSIGN(parts.protocols, make_protocols(keys));
  return Session::create(std::move(parts));
}

}  // namespace mien::live
