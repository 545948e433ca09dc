
#include "mien/live/page_pictures.h"

#include <algorithm>

#include "mien/core/bytes.h"
#include "mien/live/page_server.h"

namespace mien::live {
namespace {

constexpr std::string_view kPictureMagic = "MPIC";
constexpr std::uint8_t kPictureVersion = 1;

/// The place that a device is bound to, if that is a camera's.
std::optional<PictureTap::Wish> wish_for(const std::string& device,
                                         std::span<const session::Report::Link> links) {
  const auto link = std::ranges::find(links, device, &session::Report::Link::device);
  const auto number = static_cast<std::size_t>(link - links.begin());
  if (link == links.end() || !link->view) return std::nullopt;
  return PictureTap::Wish{.sensor = static_cast<std::uint16_t>(number), .part = *link->view};
}

}  // namespace

void PagePictures::open(std::span<const Feed> feeds) {
  for (const Feed& feed : feeds)
    if (feed.tap) taps_.push_back(feed.tap);
}

Result<bool> PagePictures::show(std::uint64_t client, bool on) {
  if (taps_.empty())
    return fail(ErrorCode::unsupported, "this session has no camera", "pictures",
                "start it with a rig that has, and --listen http://HOST:PORT/");
  const bool nobody = clients_.empty();
  if (on)
    clients_.insert(client);
  else
    clients_.erase(client);
  return on && nobody;
}

bool PagePictures::watched(const PageServer& page) {
  std::erase_if(clients_, [&](std::uint64_t client) { return !page.has(client); });
  // A view that was made for somebody who is gone.
  if (clients_.empty())
    for (const auto& tap : taps_) static_cast<void>(tap->take());
  return !clients_.empty();
}

void PagePictures::look(std::span<const session::Report::Link> links, PageServer& page) {
  for (const auto& tap : taps_) {
    if (const auto view = tap->take())
      for (const std::uint64_t client : clients_)
        page.send_picture(client, view->sensor, picture_message(*view));
    if (const auto wish = wish_for(tap->device(), links)) tap->ask(*wish);
  }
}

std::optional<PicturesState> PagePictures::state() const {
  if (taps_.empty()) return std::nullopt;
  return PicturesState{.cameras = taps_.size(), .watchers = clients_.size()};
}

std::string picture_message(const PictureTap::View& view) {
  ByteWriter out;
  out.append(kPictureMagic);
  out.little(kPictureVersion);
  out.little(std::uint8_t{0});
  out.little(view.sensor);
  out.little(static_cast<std::uint16_t>(PictureTap::kSide));
  out.little(static_cast<std::uint16_t>(PictureTap::kSide));
  out.append(std::as_bytes(std::span(view.pixels)));
  return std::string(as_text(out.bytes()));
}

}  // namespace mien::live
