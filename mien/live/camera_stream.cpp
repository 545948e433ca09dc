#include <utility>  // Before Asio 1.74, which forgets it.

#include "mien/live/camera_stream.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <boost/asio/connect.hpp>
#include <boost/asio/write.hpp>

#include "mien/core/excerpt.h"
#include "mien/core/host_port.h"
#include "mien/sensor/payload.h"

namespace mien::live {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;
using tcp = asio::ip::tcp;

constexpr std::string_view kHttp = "http://";
constexpr std::uint16_t kHttpPort = 80;
/// What a log keeps as a source (Intake::add_source).
constexpr std::size_t kMaxAddress = 100;
/// How often it is looked whether pictures come.
constexpr auto kWatchEvery = std::chrono::milliseconds(100);
constexpr auto kHoldBack = std::chrono::milliseconds(5);

bool is_letter_of_host(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' || c == '-' ||
         c == '_' || c == ':' || c == '%';
}
bool is_letter_of_path(char c) {
  return c > ' ' && c < '\x7f' && c != '#';
}

/// As the header Host and an address have it.
std::string authority_of(const CameraAddress& address) {
  const bool numbers = address.host.find(':') != std::string::npos;
  std::string text = numbers ? "[" + address.host + "]" : address.host;
  if (address.port != kHttpPort) text += fmt::format(":{}", address.port);
  return text;
}

}  // namespace

std::string CameraAddress::source() const {
  return fmt::format("{}{}{}", kHttp, authority_of(*this), path);
}

Result<CameraAddress> parse_camera_address(std::string_view text) {
  const auto bad = [&](std::string_view what) {
    return fail(ErrorCode::bad_usage, std::string(what), excerpt(text, kMaxAddress),
                "write it as http://HOST:PORT/PATH");
  };
  if (!text.starts_with(kHttp)) return bad("no address of a camera");
  if (text.size() > kMaxAddress) return bad(fmt::format("over {} letters", kMaxAddress));
  std::string_view rest = text.substr(kHttp.size());
  CameraAddress address;
  const std::size_t slash = std::min(rest.find('/'), rest.size());
  if (const auto path = rest.substr(slash); !path.empty()) address.path = path;
  rest = rest.substr(0, slash);
  if (rest.find('@') != std::string_view::npos) return bad("a user or a password, which is never sent");
  const auto host = parse_host_port(rest);
  if (!host) return bad(host.error().what);
  address.host = host->host;
  address.port = host->port.value_or(kHttpPort);
  if (address.host.empty() || !std::ranges::all_of(address.host, is_letter_of_host)) return bad("no host");
  if (address.port == 0) return bad("port 0");
  if (!std::ranges::all_of(address.path, is_letter_of_path)) return bad("the path has letters that none has");
  return address;
}

CameraStream::CameraStream(asio::io_context& network, CameraAddress address,
                           std::unique_ptr<sensor::PayloadStream> stream,
                           sensor::PayloadStream::OnPayload on_payload, Clock clock)
    : address_(std::move(address)),
      stream_(std::move(stream)),
      clock_(std::move(clock)),
      request_(fmt::format("GET {} HTTP/1.1\r\nHost: {}\r\nUser-Agent: mien\r\nConnection: close\r\n\r\n",
                           address_.path, authority_of(address_))),
      resolver_(network),
      socket_(network),
      retry_(network),
      watch_(network) {
  on_payload_ = [this, hand_on = std::move(on_payload)](std::span<const std::byte> datagram,
                                                        std::span<const std::byte> payload) {
    const HostTime now = clock_();
    deadline_ = now + kPatience;
    if (!open_) {
      open_ = true;
      problem_.clear();
      pause_ = kFirstRetry;
    }
    if (picture_budget_.spend(now, kMaxPicturesPerSecond))
      hand_on(datagram, payload);
    else
      ++too_fast_;
  };
  ask();
  watch();
}

void CameraStream::ask() {
  const std::uint64_t attempt = ++attempt_;
  asking_ = true;
  stream_->restart();
  overlong_before_ = stream_->counts().overlong;
  deadline_ = clock_() + kPatience;
  resolver_.async_resolve(
      address_.host, std::to_string(address_.port), [this, attempt](error_code code, const auto& found) {
        if (attempt != attempt_) return;
        if (code) return lose("no such host (" + code.message() + "); look at its name, or give its number");
        asio::async_connect(socket_, found, [this, attempt](error_code failed, const tcp::endpoint&) {
          if (attempt != attempt_) return;
          if (failed) return lose("not there (" + failed.message() + "); switch it on, and look at its port");
          send_request(attempt);
        });
      });
}

void CameraStream::send_request(std::uint64_t attempt) {
  asio::async_write(socket_, asio::buffer(request_), [this, attempt](error_code code, std::size_t) {
    if (attempt != attempt_) return;
    if (code) return lose("it hung up (" + code.message() + ")");
    read(attempt);
  });
}

void CameraStream::read(std::uint64_t attempt) {
  socket_.async_read_some(asio::buffer(bytes_), [this, attempt](error_code code, std::size_t size) {
    if (attempt != attempt_) return;
    if (code) return lose("it hung up (" + code.message() + ")");
    received_ += size;
    if (const auto taken = stream_->read(std::span(bytes_).first(size), on_payload_); !taken)
      return lose(taken.error().message());
    read_when_due(attempt, size);
  });
}

void CameraStream::read_when_due(std::uint64_t attempt, std::size_t size) {
  if (byte_budget_.spend(clock_(), kMaxBytesPerSecond, static_cast<double>(size))) return read(attempt);
  ++held_back_;
  retry_.expires_after(kHoldBack);
  retry_.async_wait([this, attempt, size](error_code code) {
    if (attempt == attempt_ && !code) read_when_due(attempt, size);
  });
}

void CameraStream::watch() {
  watch_.expires_after(kWatchEvery);
  watch_.async_wait([this](error_code code) {
    if (code) return;
    if (asking_ && clock_() >= deadline_) lose(no_picture());
    watch();
  });
}

std::string CameraStream::no_picture() const {
  const std::string text = "no whole picture for two seconds; ";
  if (stream_->counts().overlong > overlong_before_)
    return text +
           fmt::format("its pictures are over {} KiB, let it make smaller ones", sensor::kMaxPayload >> 10U);
  return text + "look at its power and its radio, and whether another program has its stream";
}

void CameraStream::lose(const std::string& problem) {
  ++attempt_;
  asking_ = false;
  error_code ignored;
  resolver_.cancel();
  socket_.close(ignored);
  if (open_) ++lost_;
  open_ = false;
  problem_ = problem;
  ask_again();
}

void CameraStream::ask_again() {
  retry_.expires_after(pause_);
  pause_ = std::min<std::chrono::milliseconds>(2 * pause_, kLastRetry);
  retry_.async_wait([this, attempt = attempt_](error_code code) {
    if (attempt == attempt_ && !code) ask();
  });
}

void CameraStream::close() {
  ++attempt_;
  asking_ = false;
  open_ = false;
  error_code ignored;
  resolver_.cancel();
  socket_.close(ignored);
  retry_.cancel();
  watch_.cancel();
}

CameraStream::Status CameraStream::status() const {
  return {.address = address_.source(),
          .open = open_,
          .problem = problem_,
          .lost = lost_,
          .bytes = received_,
          .pictures = stream_->counts(),
          .too_fast = too_fast_,
          .held_back = held_back_};
}

}  // namespace mien::live
