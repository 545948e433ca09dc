
#include "mien/live/page_requests.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/ip/address.hpp>
#include <chrono>
#include <ctime>
#include <vector>

#include "mien/sensor/rig_views.h"
#include "mien/session/json_fields.h"
#include "mien/sink/address.h"

namespace mien::live {

Result<bool> switch_field(const nlohmann::json& command, const std::string& name) {
  const auto on = command.find("on");
  if (on == command.end() || !on->is_boolean()) return fail(ErrorCode::malformed, "\"on\" is missing", name);
  return on->get<bool>();
}

Result<void> check_file_name(const std::string& name, const std::string& what) {
  const bool odd =
      name.empty() || name.size() > 100 || name.front() == '.' ||
      std::ranges::any_of(name, [](char c) { return c == '/' || c == '\\' || (c >= 0 && c < ' '); });
  if (!odd) return {};
  return fail(ErrorCode::bad_usage, "not a name for a " + what, name.substr(0, 40),
              "letters, digits, - and _");
}

std::filesystem::path unused(const std::filesystem::path& take) {
  std::filesystem::path path = take;
  std::error_code ignored;
  for (int i = 2; std::filesystem::exists(path, ignored); ++i)
    path.replace_filename(fmt::format("{}_{}{}", take.stem().string(), i, take.extension().string()));
  return path;
}

Result<std::filesystem::path> take_path(const std::filesystem::path& folder, const std::string& name) {
  if (name.empty()) {
    const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
    return unused(folder / fmt::format("take_{:%Y-%m-%d_%H-%M-%S}.mien", fmt::localtime(now)));
  }
  MIEN_TRY(check_file_name(name, "take"));
  return folder / (name.ends_with(".mien") ? name : name + ".mien");
}

Result<void> check_page_sink(const std::string& text) {
  MIEN_TRY_ASSIGN(const sink::Address address, sink::parse_address(text));
  if (address.scheme == "csv" || address.option("avatar") != nullptr)
    return fail(ErrorCode::bad_usage, "the page opens no files", text, "start mien live with --out for it");
  boost::system::error_code code;
  static_cast<void>(boost::asio::ip::make_address(address.host, code));
  if (code && address.host != "localhost")
    return fail(ErrorCode::bad_usage, "the page sends to IP addresses and localhost only", text,
                "start mien live with --out for a host's name");
  return {};
}

Result<std::string> save_views(const std::filesystem::path& rig_file, const sensor::Rig& rig,
                               std::span<const session::Report::Link> links) {
  std::vector<sensor::SensorView> views;
  for (std::size_t i = 0; i < std::min(links.size(), rig.sensors.size()); ++i)
    if (links[i].view) views.push_back({.sensor = rig.sensors[i].name, .view = *links[i].view});
  if (rig_file.empty() || views.empty())
    return fail(ErrorCode::unsupported, "this session has no cameras' rig file", "save_rig",
                "start it with a rig that has, as rigs/headset.toml");
  MIEN_TRY(sensor::write_views(rig_file, views));
  return session::dumped({{"rig", rig_file.string()}});
}

}  // namespace mien::live
