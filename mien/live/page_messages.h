#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mien/live/camera_pictures.h"
#include "mien/live/dataset_recording.h"
#include "mien/live/feeds.h"
#include "mien/live/latency.h"
#include "mien/live/network_interfaces.h"
#include "mien/live/page_pictures.h"
#include "mien/live/phone_lesson.h"
#include "mien/live/player.h"
#include "mien/live/recorder.h"
#include "mien/live/serial_port.h"
#include "mien/live/take_listing.h"
#include "mien/live/video_recording.h"
#include "mien/sensor/rig.h"
#include "mien/session/report.h"
#include "mien/sink/json_frame.h"
#include "mien/sink/sink.h"
#include "mien/take/take.h"

// What the page is told, as docs/reference/page_protocol.md has it.
namespace mien::live {

/// One of the places that frames go to, on or off.
struct SinkState {
  std::int64_t id = 0;
  bool on = true;
  sink::Status status;
};

/// Who can reach the session.
struct NetworkState {
  std::vector<std::string> open;             ///< Addresses of ports on every interface.
  std::vector<NetworkInterface> interfaces;  ///< By which these are reached.
  std::string only;                          ///< The entrance that they are narrowed to; empty: none.
  std::uint64_t elsewhere = 0;               ///< Datagrams refused because they came in elsewhere.
  bool sealed = false;                       ///< Only who has the key is received, ...
  std::vector<std::string> unsealed;         ///< ... and these cameras, whose pictures no key seals.
};

struct Status {
  session::Report report;
  std::uint64_t missed = 0;
  Latencies latency;  ///< Of the last ten seconds.
  std::vector<SinkState> sinks;
  std::vector<SerialPort::Status> lines;  ///< Serial ones that devices speak on.
  std::vector<CameraStatus> cameras;      ///< Asked ones, and those of lines that speak.
  NetworkState network;
  Recorder::State recording;
  double recording_megabytes = 0;
  std::optional<double> recording_ends_s;  ///< When the session ends by itself and the recording with it.
  std::optional<Player::View> replay;      ///< Of a take that is played in the place of devices.
  std::optional<DatasetRecording::State> dataset;  ///< None before the first.
  std::optional<VideoState> video;                 ///< None where none was agreed to, or sent.
  PhoneLesson::State lesson;
  HearingState hearing;
  std::optional<PicturesState> pictures;  ///< None of a session without cameras.
};

[[nodiscard]] sink::Hello hello_for(const sensor::Rig& rig, std::string software, std::string model,
                                    std::vector<std::string> listening, bool replay);
/// One camera of a status, or of a session's summary.
[[nodiscard]] nlohmann::json camera_json(const CameraStatus& camera);
[[nodiscard]] std::string status_json(const Status& status, const sensor::Rig& rig);
/// `result` is JSON, or empty for none.
[[nodiscard]] std::string reply_json(std::int64_t number, std::string_view error,
                                     std::string_view result = {});
/// An event of the session in a person's words: "calibrated by itself". Empty for those that need none, and
/// for links and faces lost and back, which LinkNews puts into words.
[[nodiscard]] std::string event_text(const take::Event& event);
[[nodiscard]] std::string event_json(std::string_view kind, std::string_view text);
/// To the browser whose microphone was heard and is heard no more.
[[nodiscard]] std::string microphone_json(std::string_view why);
/// To the browser whose camera was recorded: it is to stop, or to begin anew.
[[nodiscard]] std::string video_json(std::string_view why, bool again);
/// The object of a list of takes.
[[nodiscard]] nlohmann::json takes_json(const std::vector<TakeListing::Entry>& takes);

}  // namespace mien::live
