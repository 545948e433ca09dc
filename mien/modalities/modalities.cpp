#include "mien/modalities/modalities.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sodium.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <utility>

#include "mien/core/files.h"
#include "mien/eyewear/eyewear_protocol.h"
#include "mien/eyewear/eyewear_tracker.h"
#include "mien/eyewear/marker_network.h"
#include "mien/gaze/gaze_protocol.h"
#include "mien/gaze/gaze_tracker.h"
#include "mien/headset/feature_reducer.h"
#include "mien/headset/headset_model.h"
#include "mien/headset/headset_tracker.h"
#include "mien/headset/picture_protocol.h"
#include "mien/headset/views_file.h"
#include "mien/imu/imu_tracker.h"
#include "mien/imu/packets/node_message.h"
#include "mien/imu/packets/node_protocol.h"
#include "mien/imu/packets/slimevr.h"
#include "mien/imu/packets/slimevr_protocol.h"
#include "mien/mocap/marker_protocol.h"
#include "mien/modalities/osc_commands.h"
#include "mien/model/linear.h"
#include "mien/model/model_file.h"
#include "mien/phone/ifacialmocap.h"
#include "mien/phone/live_link.h"
#include "mien/phone/weights_protocol.h"
#include "mien/phone/weights_tracker.h"
#include "mien/sensor/rig_part.h"
#include "mien/sensor/sealed_protocol.h"
#include "mien/speech/listeners.h"
#include "mien/speech/sound_protocol.h"
#include "mien/speech/speech_tracker.h"
#include "mien/tracker/causal_tracker.h"

namespace mien::modalities {
namespace {

using MadeTracker = Result<std::unique_ptr<tracker::Tracker>>;
using Reducers = std::vector<session::ProtocolReducer>;

/// The same, where an error says which file it is about.
template <class T>
Result<T> of_file(Result<T> made, const std::filesystem::path& file) {
  if (!made) made.error().where = file.string();
  return made;
}

MadeTracker make_imu_tracker(const sensor::Rig& rig, const LiveModel& from, Reducers&) {
  MIEN_TRY_ASSIGN(model::ModelFile file,
                  from.imu ? Result<model::ModelFile>(*from.imu) : model::read_model(from.path));
  MIEN_TRY_ASSIGN(
      tracker::CausalTracker model,
      of_file(tracker::CausalTracker::create(std::move(file), rig.face_sensor_names()), from.path));
  return std::make_unique<imu::ImuTracker>(rig, std::make_unique<tracker::CausalTracker>(std::move(model)));
}

MadeTracker make_eyewear_tracker(const sensor::Rig& rig, const LiveModel& from, Reducers&) {
  MIEN_TRY_ASSIGN(const std::filesystem::path markers, find_resource("rigs/markers.toml"));
  MIEN_TRY_ASSIGN(const builtin_face::MarkerSet set, builtin_face::read_markers(markers));
  MIEN_TRY_ASSIGN(eyewear::MarkerNetworkFile file, eyewear::read_marker_network(from.path));
  MIEN_TRY_ASSIGN(eyewear::MarkedFace face, of_file(eyewear::MarkedFace::of(file, set), from.path));
  MIEN_TRY_ASSIGN(auto regressor,
                  eyewear::NetworkRegressor::create(std::move(file), eyewear::photo_sensor_names(rig)));
  return eyewear::EyewearTracker::create(rig, std::move(face), std::move(regressor));
}

MadeTracker make_gaze_tracker(const sensor::Rig& rig, const LiveModel&, Reducers&) {
  return gaze::GazeTracker::create(rig);
}

MadeTracker make_weights_tracker(const sensor::Rig& rig, const LiveModel&, Reducers&) {
  return phone::WeightsTracker::create(rig);
}

MadeTracker make_speech_tracker(const sensor::Rig& rig, const LiveModel& from, Reducers&) {
  const std::vector<std::uint16_t> microphones = sensor::sensors_of(rig, "speech");
  // What hears is made when there is sound; that something is missing is said before.
  if (!microphones.empty() && rig.sensors[microphones.front()].hears_by == "phones") {
    MIEN_TRY(speech::PhoneDecoder::check());
    return speech::SpeechTracker::create(rig, []() -> Result<std::unique_ptr<speech::Listener>> {
      MIEN_TRY_ASSIGN(speech::PhoneDecoder decoder, speech::PhoneDecoder::create());
      return std::make_unique<speech::PhoneListener>(std::move(decoder));
    });
  }
  MIEN_TRY_ASSIGN(speech::SpeechNetworkFile file, speech::read_speech_network(from.path));
  return speech::SpeechTracker::create(
      rig, [file = std::move(file)]() -> Result<std::unique_ptr<speech::Listener>> {
        MIEN_TRY_ASSIGN(speech::SpeechNetwork network, speech::SpeechNetwork::create(file));
        return std::make_unique<speech::LearnedListener>(std::move(network));
      });
}

MadeTracker make_camera_tracker(const sensor::Rig& rig, const LiveModel& from, Reducers& reducers) {
  const std::filesystem::path& path = from.path;
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored))
    return fail(ErrorCode::not_found, "no model of a headset's pictures", path.string(),
                "train it: mien train models/recipes/headset.toml --rig rigs/headset.toml --out "
                "models/headset.safetensors");
  MIEN_TRY_ASSIGN(const headset::ViewsFile file, headset::read_views_file(path));
  MIEN_TRY_ASSIGN(const auto model, of_file(headset::HeadsetModel::create(file), path));
  MIEN_TRY_ASSIGN(auto made, headset::HeadsetTracker::create(rig, model));
  MIEN_TRY_ASSIGN(headset::FeatureReducer reducer, headset::FeatureReducer::create(rig, model));
  reducers.push_back({std::string(headset::PictureProtocol::kName),
                      std::make_unique<headset::FeatureReducer>(std::move(reducer))});
  return made;
}

/// What devices speak, and what a session with keys makes of it.
struct Language {
  enum class Sealing : std::uint8_t {
    never,     ///< It names no device: not heard.
    possible,  ///< Heard where it is sealed.
    inside,    ///< Only devices inside this program speak it: heard as it is.
  };
  std::unique_ptr<sensor::Protocol> protocol;
  Sealing sealing = Sealing::never;
};

/// The token of a session, by which devices know it from the one before. Errors: internal.
Result<std::uint64_t> draw_session() {
  if (sodium_init() < 0) return fail(ErrorCode::internal, "libsodium does not start", "session");
  std::uint64_t session = 0;
  while (session == 0) randombytes_buf(&session, sizeof(session));
  return session;
}

/// What devices speak to a session of this token, in the order in which it is asked whether a datagram is
/// theirs: packets of markers, gaze, weights, sound and eyewear begin as IMU nodes' do. Errors: the
/// protocols'.
Result<std::vector<Language>> make_languages(std::uint64_t session) {
  using enum Language::Sealing;
  std::vector<Language> all;
  const auto add = [&all]<class P>(P protocol, Language::Sealing sealing) {
    all.push_back({std::make_unique<P>(std::move(protocol)), sealing});
  };
  add(mocap::MarkerProtocol(), never);  // Truth, no sensors of a rig.
  add(OscCommands(), never);            // Gaze takes all other OSC.
  // Packets can be sealed; OSC, lines of text, SlimeVR's nodes and programs of phones seal nothing.
  add(gaze::GazeProtocol(), possible);
  add(phone::WeightsProtocol(), possible);
  add(phone::LiveLinkProtocol(), never);
  add(phone::IFacialMocapProtocol(), never);
  // What is heard or seen inside this program are payloads, which no datagram of a network has.
  add(speech::SoundProtocol(), inside);
  add(speech::MicrophoneProtocol(), possible);
  add(headset::PictureProtocol(), inside);
  MIEN_TRY_ASSIGN(eyewear::EyewearProtocol eyewear, eyewear::EyewearProtocol::create());
  add(std::move(eyewear), possible);
  MIEN_TRY_ASSIGN(imu::NodeProtocol nodes, imu::NodeProtocol::create({.session = session}));
  add(std::move(nodes), possible);
  add(imu::SlimeVrProtocol(), never);
  return all;
}

/// A kind of sensors: a row of the table, and what a live session knows of it. What a virtual performer wears
/// is a row of mien/virtual/stage.cpp and its training one of mien/train/make_task.cpp, by the same kind.
/// What a guided calibration asks for is its tracker's to say (tracker::Tracker::guidance()), and what its
/// devices speak stands in make_languages().
struct Modality {
  std::string_view kind;  ///< As rigs and its tracker name it (tracker::Tracker::modality()).
  /// Path of the live model from the program's root; empty for a kind whose tracker needs none.
  std::string_view default_model;
  bool window_models = false;            ///< See has_window_models().
  std::span<const std::uint16_t> ports;  ///< UDP ports that its devices send to, unless told otherwise.
  /// Appends what reduces the payloads of its protocols, where they are reduced before they are logged.
  /// Errors: the model's.
  MadeTracker (*make_tracker)(const sensor::Rig& rig, const LiveModel& model, Reducers& reducers);
  /// Where another kind's model is named, this one's is the default, or what has its name in the folder.
  bool model_beside = false;
  model::Precision precision = model::Precision::fp32;  ///< Of its networks.
};

constexpr std::array kNodePorts = {imu::kNodePort};
constexpr std::array kImuPorts = {imu::kNodePort, imu::slimevr::kPort};

constexpr std::array kModalities = {
    Modality{.kind = "gaze", .ports = kNodePorts, .make_tracker = make_gaze_tracker},
    Modality{.kind = "weights", .ports = kNodePorts, .make_tracker = make_weights_tracker},
    Modality{.kind = "speech",
             .default_model = "models/speech.safetensors",
             .ports = kNodePorts,
             .make_tracker = make_speech_tracker,
             .model_beside = true},
    // This program asks cameras; they send to no port of it.
    Modality{.kind = "camera",
             .default_model = "models/headset.safetensors",
             .make_tracker = make_camera_tracker,
             .precision = headset::kHeadsetPrecision},
    Modality{.kind = "eyewear",
             .default_model = "models/eyewear.safetensors",
             .ports = kNodePorts,
             .make_tracker = make_eyewear_tracker},
    Modality{.kind = "imu",
             .default_model = "models/live.safetensors",
             .window_models = true,
             .ports = kImuPorts,
             .make_tracker = make_imu_tracker,
             .precision = tracker::kLivePrecision},
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

/// Those of them whose trackers need a model.
std::vector<const Modality*> with_models(std::vector<const Modality*> modalities) {
  std::erase_if(modalities, [](const Modality* one) { return one->default_model.empty(); });
  if (modalities.size() > 1) std::erase_if(modalities, [](const Modality* one) { return one->model_beside; });
  return modalities;
}

/// The model of one of a rig's modalities, where `model` is that of all.
Result<std::filesystem::path> model_of(const Modality& modality, const std::vector<const Modality*>& wanting,
                                       const std::filesystem::path& model) {
  const std::filesystem::path in_folder = model / std::filesystem::path(modality.default_model).filename();
  if (std::ranges::find(wanting, &modality) != wanting.end()) return wanting.size() > 1 ? in_folder : model;
  if (modality.default_model.empty()) return std::filesystem::path();
  std::error_code ignored;
  if (std::filesystem::exists(in_folder, ignored)) return in_folder;
  return find_resource(std::string(modality.default_model));
}

/// A tracker for each kind of the rig's sensors; of several kinds each with the model of its default name in
/// the folder. `reducers` gains theirs.
Result<std::vector<std::unique_ptr<tracker::Tracker>>> make_trackers(const sensor::Rig& rig,
                                                                     const LiveModel& model,
                                                                     Reducers& reducers) {
  MIEN_TRY_ASSIGN(const std::vector<const Modality*> modalities, modalities_of(rig));
  const std::vector<const Modality*> wanting = with_models(modalities);
  if (wanting.size() > 1 && !std::filesystem::is_directory(model.path))
    return fail(ErrorCode::bad_usage, "a rig with sensors of several kinds wants a folder of models",
                model.path.string(),
                "name the folder, with each kind's model under its default name, as models/ has them");
  std::vector<std::unique_ptr<tracker::Tracker>> trackers;
  for (const Modality* modality : modalities) {
    LiveModel its_own = model;
    if (modalities.size() > 1) {
      MIEN_TRY_ASSIGN(its_own.path, model_of(*modality, wanting, model.path));
    }
    MIEN_TRY_ASSIGN(trackers.emplace_back(),
                    modality->make_tracker(sensor::part_of(rig, modality->kind), its_own, reducers));
  }
  return trackers;
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
  const std::vector<const Modality*> wanting = with_models(modalities);
  if (wanting.empty()) return std::filesystem::path();
  MIEN_TRY_ASSIGN(std::filesystem::path model, find_resource(wanting.front()->default_model));
  return wanting.size() == 1 ? model : model.parent_path();
}

bool has_window_models(const sensor::Rig& rig) {
  const auto modalities = modalities_of(rig);
  return modalities && modalities->size() == 1 && modalities->front()->window_models;
}

std::string live_kernels(const sensor::Rig& rig) {
  std::vector<std::string> names;
  for (const std::string& kind : sensor::kinds_of(rig)) {
    const Modality* const modality = find_modality(kind);
    if (modality == nullptr || modality->default_model.empty()) continue;
    std::string name = model::kernel_name(modality->precision);
    if (std::ranges::find(names, name) == names.end()) names.push_back(std::move(name));
  }
  return names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
}

Result<Protocols> make_protocols(const std::vector<sensor::SealKey>& keys) {
  MIEN_TRY_ASSIGN(const std::uint64_t session, draw_session());
  MIEN_TRY_ASSIGN(std::vector<Language> languages, make_languages(session));
  Protocols protocols;
  Protocols inside;
  for (Language& language : languages) {
    if (language.sealing == Language::Sealing::inside && !keys.empty())
      inside.push_back(std::move(language.protocol));
    else if (language.sealing != Language::Sealing::never || keys.empty())
      protocols.push_back(std::move(language.protocol));
  }
  if (keys.empty()) return protocols;
  MIEN_TRY_ASSIGN(sensor::SealedProtocol sealed,
                  sensor::SealedProtocol::create(session, keys, std::move(protocols)));
  inside.push_back(std::make_unique<sensor::SealedProtocol>(std::move(sealed)));
  return inside;
}

Result<std::unique_ptr<session::Session>> make_session(const sensor::Rig& rig, const LiveModel& model,
                                                       const shaping::ShaperSettings& shaping,
                                                       const std::vector<sensor::SealKey>& keys,
                                                       Pictures pictures) {
  session::Session::Parts parts;
  parts.rig = rig;
  parts.shaping = shaping;
  MIEN_TRY_ASSIGN(parts.trackers, make_trackers(rig, model, parts.reducers));
  MIEN_TRY_ASSIGN(parts.protocols, make_protocols(keys));
  if (pictures == Pictures::kept) parts.reducers.clear();
  return session::Session::create(std::move(parts));
}

Result<std::unique_ptr<session::Session>> make_receiving_session(const sensor::Rig& rig) {
  session::Session::Parts parts;
  parts.rig = rig;
  MIEN_TRY_ASSIGN(parts.protocols, make_protocols());
  return session::Session::create(std::move(parts));
}

}  // namespace mien::modalities
