#include "mien/sink/json_frame.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <span>

#include "mien/sink/arkit_frame.h"

namespace mien::sink {
namespace {

using OrderedJson = nlohmann::ordered_json;

void put_number(std::string& out, double value) {
  // Zero in one letter, and never -0: half of a face at rest is zero.
  if (!std::isfinite(value) || value == 0)
    out += '0';
  else
    fmt::format_to(std::back_inserter(out), "{:.5g}", value);
}

void put_list(std::string& out, std::string_view name, std::span<const float> values) {
  fmt::format_to(std::back_inserter(out), ",\"{}\":[", name);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i > 0) out += ',';
    put_number(out, static_cast<double>(values[i]));
  }
  out += ']';
}

/// In the order of face::Provenance.
char provenance_letter(face::Provenance provenance) {
  constexpr std::string_view kLetters = "miphan";
  return kLetters.at(static_cast<std::size_t>(provenance));
}

void put_sureness(std::string& out, std::string_view name, float confidence, face::Provenance provenance) {
  fmt::format_to(std::back_inserter(out), ",\"{}_confidence\":", name);
  put_number(out, static_cast<double>(confidence));
  fmt::format_to(std::back_inserter(out), ",\"{}_provenance\":\"{}\"", name, provenance_letter(provenance));
}

}  // namespace

std::string hello_json(const Hello& hello) {
  OrderedJson json = {{"type", "hello"}, {"software", hello.software}, {"shapes", face::kShapeNames}};
  if (hello.rig) {
    OrderedJson sensors = OrderedJson::array();
    for (const Hello::Sensor& sensor : hello.rig->sensors) {
      OrderedJson one = {{"name", sensor.name}, {"kind", sensor.kind}, {"site", sensor.site},
                         {"side", sensor.side}, {"role", sensor.role}, {"position_m", nullptr}};
      if (const auto& p = sensor.position_m) one["position_m"] = {p->x(), p->y(), p->z()};
      if (const auto& a = sensor.aim) one["aim"] = {a->x(), a->y(), a->z()};
      sensors.push_back(std::move(one));
    }
    json["rig"] = {{"name", hello.rig->name}, {"sensors", std::move(sensors)}};
  }
  if (hello.face) json["face"] = *hello.face;
  if (hello.model) json["model"] = *hello.model;
  if (hello.mode) json["mode"] = *hello.mode;
  if (hello.listening) json["listening"] = *hello.listening;
  return json.dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
}

void write_frame_json(const face::OutputFrame& frame, std::int64_t frame_index,
                      const face::BlendshapeWeights* truth, std::string& out) {
  out.clear();
  const std::int64_t ns = frame.time.time_since_epoch().count();
  // Whole nanoseconds as a decimal: exact, where a double after a day of them would not be.
  const auto size = ns < 0 ? 0 - static_cast<std::uint64_t>(ns) : static_cast<std::uint64_t>(ns);
  fmt::format_to(std::back_inserter(out), "{{\"type\":\"frame\",\"index\":{},\"time\":{}{}.{:09}",
                 frame_index, ns < 0 ? "-" : "", size / 1'000'000'000, size % 1'000'000'000);
  put_list(out, "weights", frame.weights.values);
  put_list(out, "confidence", frame.confidence);
  put_list(out, "regions", frame.region_confidence);
  out += ",\"provenance\":\"";
  for (const face::Provenance provenance : frame.provenance) out += provenance_letter(provenance);
  out += "\",\"tongue_out\":";
  put_number(out, static_cast<double>(frame.tongue_out));
  const Quat head = sendable_rotation(frame.head);
  out += ",\"head\":[";
  put_number(out, head.w());
  for (const double value : {head.x(), head.y(), head.z()}) {
    out += ',';
    put_number(out, value);
  }
  out += ']';
  put_sureness(out, "head", frame.head_confidence, frame.head_provenance);
  if (frame.head_position_known) put_list(out, "head_position_m", {frame.head_position_m.data(), 3});
  const std::array<float, 4> eyes = {frame.eyes_rad[0].x(), frame.eyes_rad[0].y(), frame.eyes_rad[1].x(),
                                     frame.eyes_rad[1].y()};
  put_list(out, "eyes", eyes);
  put_sureness(out, "eyes", frame.eyes_confidence, frame.eyes_provenance);
  if (truth != nullptr) put_list(out, "truth", truth->values);
  out += '}';
}

}  // namespace mien::sink
