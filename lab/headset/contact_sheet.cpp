#include "lab/headset/contact_sheet.h"

#include <algorithm>
#include <optional>
#include <string_view>
#include <vector>

#include "lab/headset/camera_pictures.h"
#include "mien/render/lettering.h"
#include "mien/virtual/headset/headset_simulator.h"

namespace mien::lab {
namespace {

using face::shape;
using virt::HeadsetFailure;
using virt::HeadsetPose;

struct Named {
  std::string_view name;
  HeadsetPose pose;
};

std::vector<Named> poses() {
  std::vector<Named> all(5);
  all[0].name = "at rest";
  const auto set = [](HeadsetPose& pose, std::initializer_list<std::size_t> shapes, float weight) {
    for (const std::size_t k : shapes) pose.weights[k] = weight;
  };
  all[1].name = "eyes closed";
  set(all[1].pose, {shape("eyeBlink_L"), shape("eyeBlink_R")}, 1);
  all[2].name = "smile, looking right";
  set(all[2].pose, {shape("mouthSmile_L"), shape("mouthSmile_R")}, 1);
  set(all[2].pose, {shape("cheekSquint_L"), shape("cheekSquint_R")}, 0.6F);
  set(all[2].pose, {shape("eyeLookIn_L"), shape("eyeLookOut_R")}, 0.6F);
  all[3].name = "jaw open, looking up";
  set(all[3].pose, {shape("jawOpen")}, 0.8F);
  set(all[3].pose, {shape("eyeLookUp_L"), shape("eyeLookUp_R")}, 0.6F);
  set(all[3].pose, {shape("browInnerUp_L"), shape("browInnerUp_R")}, 1);
  all[4].name = "tongue, looking down";
  set(all[4].pose, {shape("jawOpen")}, 0.4F);
  set(all[4].pose, {shape("eyeLookDown_L"), shape("eyeLookDown_R")}, 0.7F);
  all[4].pose.tongue_out = 1;
  return all;
}

/// Time for exposure and failures to settle, in steps.
constexpr int kSettling = 8;
constexpr double kStep_s = 0.1;
constexpr int kGap = 2, kHeading = 22;
constexpr render::Rgb kPaper = {24, 24, 24}, kInk = {220, 220, 220};

}  // namespace

Result<render::Image> headset_contact_sheet(const ContactSheetRequest& request, const sensor::Rig& rig,
                                            const Progress& progress) {
  if (request.wearers < 1 || request.wearers > 64 || request.side < 16 || request.side > 480)
    return fail(ErrorCode::bad_usage, "a sheet has 1 to 64 wearers, and views of 16 to 480 pixels");
  MIEN_TRY_ASSIGN(const virt::HeadsetFaults faults, virt::parse_headset_faults(rig.faults_toml, rig.name));
  MIEN_TRY(virt::check_network_views(rig));
  std::optional<render::Lettering> lettering;
  if (!request.font.empty()) {
    MIEN_TRY_ASSIGN(lettering, render::Lettering::load(request.font));
  }
  std::vector<Named> columns = poses();
  if (request.failures) columns.resize(1);
  const int rows = request.failures ? static_cast<int>(virt::kHeadsetFailures) - 1 : request.wearers;
  const int views = static_cast<int>(rig.sensors.size()), side = request.side;
  const int block = views * side + kGap, above = lettering ? kHeading : 0;
  const int row_height = side + kGap + (request.failures ? above : 0);
  render::Image sheet(static_cast<int>(columns.size()) * block,
                      rows * row_height + (request.failures ? 0 : above), kPaper);
  const auto write = [&](std::string_view text, int left, int top) {
    if (lettering)
      lettering->draw(sheet, text, static_cast<float>(left + 4), static_cast<float>(top + kHeading - 7), 15,
                      kInk);
  };
  if (!request.failures)
    for (std::size_t c = 0; c < columns.size(); ++c) write(columns[c].name, static_cast<int>(c) * block, 0);

  for (int row = 0; row < rows; ++row) {
    if (!progress(static_cast<double>(row) / rows, "wearers"))
      return fail(ErrorCode::cancelled, "stopped while the sheet was drawn");
    const auto who = static_cast<std::uint64_t>(row % request.wearers);
    const Random root = Random(request.seed).fork("sheet", who);
    MIEN_TRY_ASSIGN(const virt::HeadsetWearer wearer,
                    virt::draw_headset_wearer(rig, faults, root.fork("wearer")));
    const HeadsetFailure failure =
        request.failures ? static_cast<HeadsetFailure>(row + 1) : HeadsetFailure::none;
    virt::HeadsetSimulator simulator(wearer, faults, root.fork("headset"), side, failure);
    simulator.put_on();
    int top = row * row_height + (request.failures ? 0 : above);
    if (request.failures) {
      write(virt::failure_name(failure), 0, top);
      top += above;
    }
    CameraPictures pictures(simulator);
    double time_s = 0;
    for (std::size_t c = 0; c < columns.size(); ++c) {
      for (int step = 0; step < kSettling; ++step, time_s += kStep_s)
        simulator.shoot(time_s, columns[c].pose, columns[c].pose, pictures.out);
      for (std::size_t v = 0; v < pictures.pixels.size(); ++v) {
        const virt::PictureSize size = simulator.size(v);
        render::Image view(size.width, size.height);
        for (std::size_t p = 0; p < pictures.pixels[v].size(); ++p)
          std::fill_n(view.rgb.begin() + static_cast<std::ptrdiff_t>(3 * p), 3, pictures.pixels[v][p]);
        render::paste(sheet, view, static_cast<int>(c) * block + static_cast<int>(v) * side, top);
      }
    }
  }
  return sheet;
}

}  // namespace mien::lab
