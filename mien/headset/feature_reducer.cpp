#include "mien/headset/feature_reducer.h"

#include <algorithm>

#include "mien/core/sha256.h"
#include "mien/headset/feature_record.h"
#include "mien/headset/picture_packet.h"
#include "mien/headset/picture_statistics.h"
#include "mien/sensor/bindings.h"

namespace mien::headset {
namespace {

/// To be raised with every change of how a picture becomes numbers.
constexpr std::uint32_t kMethodVersion = 2;

using Bound = std::pair<sensor::DeviceKey, std::uint16_t>;

}  // namespace

FeatureReducer::FeatureReducer(std::shared_ptr<const HeadsetModel> model, PictureDecoder decoder)
    : model_(std::move(model)), decoder_(std::move(decoder)), workspace_(model_->network()) {
  const model::Architecture& architecture = model_->network().architecture();
  view_.resize(architecture.side * architecture.side);
  features_.resize(architecture.features);
}

Result<FeatureReducer> FeatureReducer::create(const sensor::Rig& rig,
                                              std::shared_ptr<const HeadsetModel> model) {
  MIEN_TRY_ASSIGN(const auto bound, sensor::bindings(rig));
  MIEN_TRY_ASSIGN(std::vector<HeadsetCamera> cameras,
                  headset_cameras(rig, model->network().architecture().side));
  MIEN_TRY_ASSIGN(PictureDecoder decoder, PictureDecoder::create());
  FeatureReducer made(std::move(model), std::move(decoder));
  for (HeadsetCamera& camera : cameras) {
    const auto device = std::ranges::find(bound, camera.sensor, &Bound::second);
    if (device != bound.end()) made.bound_.push_back(*device);
    MIEN_TRY_ASSIGN(Camera added, looking_as(std::move(camera)));
    made.cameras_.push_back(std::move(added));
  }
  made.hash_anew();
  return made;
}

Result<FeatureReducer::Camera> FeatureReducer::looking_as(HeadsetCamera camera) {
  MIEN_TRY_ASSIGN(NetworkView view, NetworkView::create(camera.view));
  const auto [width, height] = least_size(camera.view);
  return Camera{
      .camera = std::move(camera), .view = std::move(view), .least_width = width, .least_height = height};
}

void FeatureReducer::hash_anew() {
  Sha256 hash;
  hash.add_value(kMethodVersion);
  hash.add(std::as_bytes(std::span(model_->hash())));
  for (const Camera& camera : cameras_) {
    const NetworkViewSettings& see = camera.camera.view;
    const auto device = std::ranges::find(bound_, camera.camera.sensor, &Bound::second);
    const sensor::DeviceKey key = device == bound_.end() ? sensor::DeviceKey() : device->first;
    hash.add_value(camera.camera.sensor);
    hash.add_value(static_cast<std::uint32_t>(camera.camera.place));
    hash.add_value(key.device);
    hash.add_value(key.channel);
    for (const double edge : {see.left, see.top, see.right, see.bottom}) hash.add_value(edge);
    hash.add_value(static_cast<std::uint32_t>(see.quarter_turns));
    hash.add_value(static_cast<std::uint32_t>(see.mirror ? 1 : 0));
  }
  hash_ = hash.hex();
}

void FeatureReducer::change_view(std::uint16_t sensor, const sensor::PictureView& view) {
  for (Camera& camera : cameras_) {
    if (camera.camera.sensor != sensor) continue;
    HeadsetCamera changed = camera.camera;
    changed.view = network_view_of(view, static_cast<std::size_t>(changed.view.side));
    if (auto looking = looking_as(std::move(changed))) camera = *std::move(looking);
  }
  hash_anew();
}

void FeatureReducer::bind(std::uint16_t sensor, const sensor::DeviceKey& device) {
  std::erase_if(bound_, [&](const Bound& one) { return one.first == device || one.second == sensor; });
  const auto seen = std::ranges::find(cameras_, sensor, [](const Camera& one) { return one.camera.sensor; });
  if (seen != cameras_.end()) bound_.emplace_back(device, sensor);
  hash_anew();
}

std::optional<std::size_t> FeatureReducer::reduce(std::span<const std::byte> datagram,
                                                  std::span<const std::byte> payload,
                                                  std::span<std::byte> out) {
  const auto packet = parse_picture_packet(datagram);
  if (!packet) return std::nullopt;
  const auto bound = std::ranges::find(bound_, packet->from, [](const auto& one) { return one.first; });
  return reduce_picture(bound == bound_.end() ? std::nullopt : std::optional(bound->second), payload, out);
}

std::optional<std::size_t> FeatureReducer::reduce_picture(std::optional<std::uint16_t> sensor,
                                                          std::span<const std::byte> jpeg,
                                                          std::span<std::byte> out) {
  auto picture = decoder_.decode(jpeg, kMeasuredSide, kMeasuredSide);
  if (!picture) return std::nullopt;
  FeatureRecord record{.statistics = statistics_of(*picture),
                       .jpeg_bytes = static_cast<std::uint32_t>(jpeg.size())};
  const auto seen = std::ranges::find_if(
      cameras_, [&](const Camera& camera) { return sensor && camera.camera.sensor == *sensor; });
  if (seen == cameras_.end()) return write_feature_record(record, {}, out);
  record.sensor = sensor;
  if (picture->width < seen->least_width || picture->height < seen->least_height)
    picture = decoder_.decode(jpeg, seen->least_width, seen->least_height);
  if (!picture) return std::nullopt;
  seen->view.make(*picture, view_);
  model_->network().find_one(seen->camera.place, view_, workspace_, features_);
  return write_feature_record(record, features_, out);
}

}  // namespace mien::headset
