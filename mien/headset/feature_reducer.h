#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "mien/core/error.h"
#include "mien/headset/headset_camera.h"
#include "mien/headset/headset_model.h"
#include "mien/headset/network_view.h"
#include "mien/headset/picture_decoder.h"
#include "mien/sensor/payload.h"
#include "mien/sensor/protocol.h"
#include "mien/sensor/rig.h"

namespace mien::headset {

/// Makes of a camera's picture its statistics and what the network's backbone finds in it (FeatureRecord),
/// so that no picture needs to be kept. Thread: one at a time.
class FeatureReducer final : public sensor::Reducer {
 public:
  /// Errors: headset_cameras', sensor::bindings', PictureDecoder::create's.
  [[nodiscard]] static Result<FeatureReducer> create(const sensor::Rig& rig,
                                                     std::shared_ptr<const HeadsetModel> model);

  [[nodiscard]] std::string_view hash() const override { return hash_; }
  /// Of the camera that the device of the packet is bound to: by the rig (sensor::bindings), or by bind()
  /// since. A picture of any other has statistics alone.
  [[nodiscard]] std::optional<std::size_t> reduce(std::span<const std::byte> datagram,
                                                  std::span<const std::byte> payload,
                                                  std::span<std::byte> out) override;
  void change_view(std::uint16_t sensor, const sensor::PictureView& view) override;
  void bind(std::uint16_t sensor, const sensor::DeviceKey& device) override;
  /// The same of a picture of the camera that is this sensor of the rig; none: of one that is none. None
  /// comes back where the picture does not decode.
  [[nodiscard]] std::optional<std::size_t> reduce_picture(std::optional<std::uint16_t> sensor,
                                                          std::span<const std::byte> jpeg,
                                                          std::span<std::byte> out);

 private:
  struct Camera {
    HeadsetCamera camera;
    NetworkView view;
    int least_width = 0;  // Of a picture: least_size().
    int least_height = 0;
  };
  FeatureReducer(std::shared_ptr<const HeadsetModel> model, PictureDecoder decoder);
  /// A camera that looks as its settings say. Errors: NetworkView::create's.
  [[nodiscard]] static Result<Camera> looking_as(HeadsetCamera camera);
  void hash_anew();

  std::shared_ptr<const HeadsetModel> model_;
  PictureDecoder decoder_;
  model::ViewsNetwork::Workspace workspace_;
  std::vector<Camera> cameras_;
  std::vector<std::pair<sensor::DeviceKey, std::uint16_t>> bound_;
  std::string hash_;
  std::vector<float> view_;
  std::vector<float> features_;
};

}  // namespace mien::headset
