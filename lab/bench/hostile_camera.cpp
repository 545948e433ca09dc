#include "lab/bench/hostile_camera.h"

#include <utility>  // Before Asio 1.74, which forgets it.
//
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <span>
#include <string_view>

#include "lab/bench/attack.h"
#include "mien/core/bytes.h"
#include "mien/render/image.h"

namespace mien::lab {
namespace {

constexpr double kCameraHz = 60;
constexpr int kPixels = 240;
constexpr int kQuality = 80;

namespace asio = boost::asio;
using asio::ip::tcp;
using std::chrono::microseconds;

constexpr microseconds kPicturePeriod(16'667);
/// Of good pictures, before a camera turns hostile.
constexpr std::uint64_t kGoodPictures = 60;
constexpr std::size_t kPiece = std::size_t{1} << 16U;
constexpr std::uint64_t kMicroseconds = 1'000'000;

std::string head(std::string_view more = "") {
  return fmt::format("HTTP/1.1 200 OK\r\nContent-Type: multipart/x-mixed-replace;boundary=b\r\n{}\r\n", more);
}

std::string part(std::string_view jpeg, std::string_view length, std::string_view time) {
  return fmt::format("\r\n--b\r\nContent-Type: image/jpeg\r\nContent-Length: {}\r\nX-Timestamp: {}\r\n\r\n{}",
                     length, time, jpeg);
}

/// The picture of this number, taken in its turn.
std::string good_part(const Pictures& pictures, std::uint64_t number) {
  const std::string_view jpeg = as_text(pictures[number % pictures.size()]);
  const std::uint64_t us = kMicroseconds + number * static_cast<std::uint64_t>(kPicturePeriod.count());
  return part(jpeg, std::to_string(jpeg.size()),
              fmt::format("{}.{:06}", us / kMicroseconds, us % kMicroseconds));
}

/// Where the marker of this code stands in a picture of ours, which has it.
std::size_t marker(std::string_view jpeg, char code) {
  const std::array<char, 2> mark = {'\xFF', code};
  return jpeg.find(std::string_view(mark.data(), mark.size()));
}

/// A picture with something wrong in it.
std::string hostile_picture(std::string_view jpeg, Random& random) {
  std::string wrong(jpeg);
  const std::size_t frame = marker(jpeg, '\xC0'), scan = marker(jpeg, '\xDA');
  switch (random.below(8)) {
    case 0:
      return wrong.substr(0, random.below(wrong.size()));
    case 1:  // 65,535 x 65,535 pixels.
      std::fill_n(wrong.begin() + static_cast<std::ptrdiff_t>(frame + 5), 4, '\xFF');
      return wrong;
    case 2:
      wrong[frame + 1] = '\xC2';
      return wrong;
    case 3: {  // A thousand scans.
      const std::string one = wrong.substr(scan, wrong.size() - 2 - scan);
      std::string many = wrong.substr(0, scan);
      for (int i = 0; i < 1000 && many.size() < 4 * kPiece; ++i) many += one.substr(0, 40);
      return many + "\xFF\xD9";
    }
    case 4: {  // Longer than any picture may be, by comments.
      const std::string comment = "\xFF\xFE\xFF\xFF" + std::string(0xFFFD, 'c');
      for (int i = 0; i < 6; ++i) wrong.insert(2, comment);
      return wrong;
    }
    case 5:
      return "\xFF\xD8\xFF\xD9";
    case 6:
      for (char& byte : wrong) byte = static_cast<char>(random.below(256));
      return wrong;
    default: {
      const auto bytes = std::as_bytes(std::span(wrong));
      return std::string(as_text(damaged({bytes.begin(), bytes.end()}, random)));
    }
  }
}

}  // namespace

Pictures made_up_pictures(std::size_t count) {
  Pictures all;
  std::vector<std::uint8_t> grey(static_cast<std::size_t>(kPixels * kPixels));
  for (std::size_t n = 0; n < count; ++n) {
    for (int y = 0; y < kPixels; ++y)
      for (int x = 0; x < kPixels; ++x) {
        const double distance = std::hypot(x - 70.0 - static_cast<double>(n), y - 120.0);
        grey[static_cast<std::size_t>(y * kPixels + x)] =
            static_cast<std::uint8_t>(128 + 90 * std::cos(distance / 6));
      }
    all.push_back(render::encode_jpeg(kPixels, kPixels, render::JpegPixels::grey, kQuality, grey).value());
  }
  return all;
}

Result<std::unique_ptr<GoodCameras>> GoodCameras::open(const Pictures& pictures, std::size_t count) {
  std::unique_ptr<GoodCameras> made(new GoodCameras(pictures));
  for (std::size_t c = 0; c < count; ++c) {
    MIEN_TRY_ASSIGN(made->servers_.emplace_back(), live::PictureServer::open(made->io_, {}));
  }
  made->show();
  made->thread_ = std::jthread([&cameras = *made] { cameras.io_.run(); });
  return made;
}

std::string GoodCameras::address(std::size_t camera) const {
  return fmt::format("http://127.0.0.1:{}/", servers_[camera]->port());
}

bool GoodCameras::are_all_watched() const {
  return std::ranges::all_of(servers_, [](const auto& server) { return server->counts().clients > 0; });
}

void GoodCameras::show() {
  const auto since = from_seconds(static_cast<double>(number_) / kCameraHz);
  timer_.expires_at(begun_ + std::chrono::duration_cast<Clock::duration>(since));
  timer_.async_wait([this, since](boost::system::error_code code) {
    if (code) return;
    for (std::size_t c = 0; c < servers_.size(); ++c)
      servers_[c]->send(DeviceTime(std::chrono::floor<std::chrono::microseconds>(
                            since + from_seconds(5.0 + 3.0 * static_cast<double>(c)))),
                        pictures_[(number_ + 7 * c) % pictures_.size()]);
    ++number_;
    show();
  });
}

CameraTalk camera_endless_part(const Pictures& pictures, Random) {
  return [&pictures, begun = false]() mutable -> CameraTurn {
    if (std::exchange(begun, true)) return {.bytes = std::string(kPiece, 'x')};
    const std::string_view jpeg = as_text(pictures.front());
    return {.bytes = head() + part(jpeg.substr(0, jpeg.size() - 2), "10737418240", "1.0")};
  };
}

CameraTalk camera_endless_head(const Pictures&, Random) {
  return [begun = false]() mutable -> CameraTurn {
    if (!std::exchange(begun, true)) return {.bytes = "HTTP/1.1 200 OK\r\n"};
    return {.bytes = "X-Filler: " + std::string(1000, 'x') + "\r\n"};
  };
}

CameraTalk camera_flood(const Pictures& pictures, Random) {
  return [&pictures, number = std::uint64_t{0}]() mutable -> CameraTurn {
    std::string bytes = number == 0 ? head() : std::string();
    while (bytes.size() < kPiece) bytes += good_part(pictures, number++);
    return {.bytes = std::move(bytes)};
  };
}

CameraTalk camera_lying_lengths(const Pictures& pictures, Random random) {
  static constexpr std::array<std::string_view, 7> kLengths = {
      "-1", "0", "7", "4294967296", "18446744073709551616", "10737418240", "many"};
  static constexpr std::array<std::string_view, 4> kChunks = {"ffffffffffffffff", "-1", "100000000", "3"};
  const bool chunked = random.chance(0.5);
  return [&pictures, random, chunked, number = std::uint64_t{0}]() mutable -> CameraTurn {
    std::string bytes;
    if (number == 0) bytes = head(chunked ? "Transfer-Encoding: chunked\r\n" : "");
    const std::string_view jpeg = as_text(pictures[number++ % pictures.size()]);
    const std::string one = part(jpeg, kLengths[random.below(kLengths.size())], fmt::format("{}.0", number));
    // A chunk that lies ends the conversation.
    const bool lies = chunked && number % 20 == 0;
    if (lies)
      bytes += fmt::format("{}\r\n{}\r\n", kChunks[random.below(kChunks.size())], one);
    else
      bytes += chunked ? fmt::format("{:x}\r\n{}\r\n", one.size(), one) : one;
    return {.bytes = std::move(bytes), .pause = kPicturePeriod};
  };
}

CameraTalk camera_trickle(const Pictures& pictures, Random) {
  return [text = head() + good_part(pictures, 0), at = std::size_t{0}, begin = head().size()]() mutable {
    const std::size_t size = at == 0 ? begin : 1;
    CameraTurn turn{.bytes = text.substr(at, size), .pause = std::chrono::seconds(1)};
    at = std::min(at + size, text.size() - 1);
    return turn;
  };
}

CameraTalk camera_turned_hostile(const Pictures& pictures, Random random) {
  return [&pictures, random, number = std::uint64_t{0}]() mutable -> CameraTurn {
    std::string bytes = number == 0 ? head() : std::string();
    const std::uint64_t now = number++;
    if (now < kGoodPictures) return {.bytes = bytes + good_part(pictures, now), .pause = kPicturePeriod};
    for (int i = 0; i < 4; ++i) {
      const std::string jpeg = hostile_picture(as_text(pictures[now % pictures.size()]), random);
      bytes += part(jpeg, std::to_string(random.chance(0.5) ? jpeg.size() : random.below(kPiece)),
                    fmt::format("{}.5", now));
    }
    return {.bytes = std::move(bytes), .pause = std::chrono::milliseconds(1)};
  };
}

CameraTalk camera_redirect(const Pictures&, Random) {
  return []() -> CameraTurn {
    return {.bytes = "HTTP/1.1 302 Found\r\nLocation: http://127.0.0.1:1/\r\n\r\n", .hangs_up = true};
  };
}

CameraTalk camera_hangs_up(const Pictures& pictures, Random random) {
  return [&pictures, random]() mutable -> CameraTurn {
    return {.bytes = head() + good_part(pictures, random.below(1000)), .hangs_up = true};
  };
}

CameraTalk camera_wild_clock(const Pictures& pictures, Random random) {
  return [&pictures, random, number = std::uint64_t{0}]() mutable -> CameraTurn {
    std::string bytes = number == 0 ? head() : std::string();
    const std::string_view jpeg = as_text(pictures[number % pictures.size()]);
    const std::uint64_t us = number * static_cast<std::uint64_t>(kPicturePeriod.count());
    const std::uint64_t second = us / kMicroseconds, hour = 3600;
    // A second each: right, an hour ahead by turns, backwards, anything.
    std::string time = fmt::format("{}.{:06}", second, us % kMicroseconds);
    if (second % 4 == 1 && number % 2 == 0) time = fmt::format("{}.{:06}", second + hour, us % kMicroseconds);
    if (second % 4 == 2) time = fmt::format("{}.0", 1'000'000 - number);
    if (second % 4 == 3) time = fmt::format("{}.{}", random.below(kMicroseconds), random.below(999));
    ++number;
    return {.bytes = bytes + part(jpeg, std::to_string(jpeg.size()), time), .pause = kPicturePeriod};
  };
}

struct HostileCamera::Visitor {
  Visitor(tcp::socket its, CameraTalk says, const asio::any_io_executor& network)
      : socket(std::move(its)), talk(std::move(says)), timer(network) {}
  tcp::socket socket;
  CameraTalk talk;
  asio::steady_timer timer;
  std::string request;
  CameraTurn turn;
};

HostileCamera::HostileCamera(Begin talk, const Pictures& pictures, std::uint64_t seed)
    : talk_(talk),
      pictures_(pictures),
      random_(Random(seed).fork("camera")),
      io_(1),
      acceptor_(io_, {asio::ip::address_v4::loopback(), 0}) {
  accept();
  thread_ = std::jthread([this] { io_.run(); });
}

HostileCamera::~HostileCamera() {
  io_.stop();
}

void HostileCamera::accept() {
  acceptor_.async_accept([this](boost::system::error_code code, tcp::socket socket) {
    if (!code) {
      const auto visitor =
          std::make_shared<Visitor>(std::move(socket), talk_(pictures_, random_.fork("visitor", visitors_++)),
                                    acceptor_.get_executor());
      asio::async_read_until(visitor->socket, asio::dynamic_buffer(visitor->request), "\r\n\r\n",
                             [this, visitor](boost::system::error_code failed, std::size_t) {
                               if (!failed) say(visitor);
                             });
    }
    accept();
  });
}

void HostileCamera::say(const std::shared_ptr<Visitor>& visitor) {
  visitor->turn = visitor->talk();
  asio::async_write(visitor->socket, asio::buffer(visitor->turn.bytes),
                    [this, visitor](boost::system::error_code code, std::size_t size) {
                      sent_ += size;
                      if (code || visitor->turn.hangs_up) return;
                      visitor->timer.expires_after(visitor->turn.pause);
                      visitor->timer.async_wait([this, visitor](boost::system::error_code over) {
                        if (!over) say(visitor);
                      });
                    });
}

}  // namespace mien::lab
