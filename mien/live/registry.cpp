#include "mien/live/registry.h"

#include <sodium.h>

#include <algorithm>
#include <utility>

#include "mien/eyewear/eyewear_protocol.h"
#include "mien/eyewear/marker_protocol.h"
#include "mien/imu/imu_tracker.h"
#include "mien/imu/node_protocol.h"
#include "mien/imu/slimevr_protocol.h"
#include "mien/tracker/causal_tracker.h"

namespace mien::live {

Result<std::unique_ptr<Session>> make_session(const sensor::Rig& rig, model::ModelFile live_model,
                                              const shaping::ShaperSettings& shaping,
                                              const std::vector<PairingKey>& keys) {
  if (std::ranges::find(rig.sensors, "photo", &sensor::Mount::kind) != rig.sensors.end())
    return fail(ErrorCode::unsupported, "this version has no tracker for photo-reflective sensors",
                "rig " + rig.name, "use a rig of IMUs");
  Session::Parts parts;
  parts.rig = rig;
  parts.shaping = shaping;
  MIEN_TRY_ASSIGN(tracker::CausalTracker model,
                  tracker::CausalTracker::create(std::move(live_model), rig.face_sensor_names()));
  parts.tracker =
      std::make_unique<imu::ImuTracker>(rig, std::make_unique<tracker::CausalTracker>(std::move(model)));

  imu::NodeProtocolSettings nodes;
  if (sodium_init() < 0) return fail(ErrorCode::internal, "libsodium does not start", "session");
  do {
    randombytes_buf(&nodes.session, sizeof(nodes.session));
  } while (nodes.session == 0);
  for (const PairingKey& key : keys) nodes.keys.push_back({key.id, key.secret});
  MIEN_TRY_ASSIGN(imu::NodeProtocol node_protocol, imu::NodeProtocol::create(std::move(nodes)));
  // The other languages know no keys: whoever asks for them hears our own nodes only. Eyewear's and markers'
  // packets begin as nodes' do, so they are asked about first.
  if (keys.empty()) {
    MIEN_TRY_ASSIGN(eyewear::EyewearProtocol eyewear_protocol, eyewear::EyewearProtocol::create());
    parts.protocols.push_back(std::make_unique<eyewear::EyewearProtocol>(std::move(eyewear_protocol)));
    parts.protocols.push_back(std::make_unique<eyewear::MarkerProtocol>());
  }
  parts.protocols.push_back(std::make_unique<imu::NodeProtocol>(std::move(node_protocol)));
  if (keys.empty()) parts.protocols.push_back(std::make_unique<imu::SlimeVrProtocol>());
  return Session::create(std::move(parts));
}

}  // namespace mien::live
