#include <utility>  // Before Asio 1.74, which forgets it.

#include "mien/live/serial_port.h"

#include <fmt/format.h>
#include <sys/file.h>

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <cerrno>
#include <charconv>
#include <system_error>

#include "mien/core/ascii.h"
#include "mien/live/serial_speed.h"

namespace mien::live {
namespace {

namespace asio = boost::asio;

constexpr std::string_view kScheme = "serial:";
constexpr std::uint32_t kLeastBaud = 300;
constexpr std::uint32_t kMostBaud = 4'000'000;
/// How often it is looked whether pictures come, and when a line that sends too much is read on.
constexpr auto kLookAtPictures = std::chrono::milliseconds(100);
constexpr auto kReadOn = std::chrono::milliseconds(5);
/// What a take keeps as a source has room for it.
constexpr std::size_t kMaxDevicePath = 200;

}  // namespace

Result<SerialAddress> parse_serial_address(std::string_view text) {
  const auto bad = [&](std::string what) {
    return fail(ErrorCode::bad_usage, std::move(what), std::string(text.substr(0, kMaxDevicePath)),
                "write it as serial:/dev/ttyUSB0 or serial:/dev/ttyUSB0?baud=115200");
  };
  if (!text.starts_with(kScheme)) return bad("not a serial line");
  std::string_view rest = text.substr(kScheme.size());
  SerialAddress address;
  const std::size_t question = rest.rfind('?');
  if (question != std::string_view::npos) {
    std::string_view option = rest.substr(question + 1);
    rest = rest.substr(0, question);
    if (!option.starts_with("baud=")) return bad("the only option is baud");
    option.remove_prefix(5);
    const auto [end, wrong] = std::from_chars(option.data(), option.data() + option.size(), address.baud);
    if (wrong != std::errc{} || end != option.data() + option.size() || address.baud < kLeastBaud ||
        address.baud > kMostBaud)
      return bad(fmt::format("the rate is no number from {} to {}", kLeastBaud, kMostBaud));
  }
  if (!rest.starts_with('/') || rest.size() > kMaxDevicePath || has_control(rest))
    return bad("the device is no absolute path");
  address.device = rest;
  return address;
}

SerialPort::SerialPort(asio::io_context& network, SerialAddress address, OnFrame on_frame)
    : address_(std::move(address)),
      on_frame_(std::move(on_frame)),
      port_(network),
      timer_(network),
      watch_(network) {}

Result<std::unique_ptr<SerialPort>> SerialPort::open(asio::io_context& network, SerialAddress address,
                                                     OnFrame on_frame, std::optional<LineCamera> camera,
                                                     sensor::PayloadStream::OnPayload on_payload,
                                                     CameraPictures::Clock clock) {
  std::unique_ptr<SerialPort> made(new SerialPort(network, std::move(address), std::move(on_frame)));
  if (camera)
    made->camera_ =
        std::make_unique<CameraPictures>(made->address_.source(), std::move(camera->sensor),
                                         std::move(camera->stream), std::move(on_payload), std::move(clock));
  MIEN_TRY(made->try_open());
  made->read();
  if (made->camera_) made->watch();
  return made;
}

Result<void> SerialPort::try_open() {
  const auto failed = [&](int number) {
    boost::system::error_code ignored;
    if (port_.is_open()) port_.close(ignored);
    const std::string why = std::generic_category().message(number);
    switch (number) {
      case ENOENT:
      case ENODEV:
      case ENXIO:
        return fail(ErrorCode::not_found, "no such device: " + why, address_.source(),
                    "plug it in; ls /dev/serial/by-id lists what is there");
      case EACCES:
      case EPERM:
        return fail(ErrorCode::bad_usage, "not allowed: " + why, address_.source(),
                    "add yourself to the group dialout, and log in again");
      case EWOULDBLOCK:
      case EBUSY:
        return fail(ErrorCode::bad_usage, "another program has it", address_.source(),
                    "close that, the serial monitor perhaps");
      default:
        return fail(ErrorCode::bad_usage, "cannot be opened as a serial line: " + why, address_.source());
    }
  };
  boost::system::error_code code;
  port_.open(address_.device, code);
  if (code) return failed(code.value());
  // Two that read one line would each get half of it.
  if (::flock(port_.native_handle(), LOCK_EX | LOCK_NB) != 0) return failed(errno);
  if (const int wrong = set_serial_speed(port_.native_handle(), address_.baud); wrong != 0)
    return failed(wrong);
  problem_.clear();
  framer_.restart();
  if (camera_) camera_->begin();
  return {};
}

void SerialPort::read() {
  port_.async_read_some(asio::buffer(bytes_), [this](boost::system::error_code code, std::size_t size) {
    if (closed_ || code == asio::error::operation_aborted) return;
    if (code) return lose(code.message());
    pause_ = kFirstRetry;
    received_ += size;
    take(std::span(bytes_).first(size));
    read_when_due(size);
  });
}

void SerialPort::read_when_due(std::size_t size) {
  if (!camera_ || camera_->may_read_on(size)) return read();
  timer_.expires_after(kReadOn);
  timer_.async_wait([this, size](boost::system::error_code code) {
    if (!closed_ && !code) read_when_due(size);
  });
}

void SerialPort::take(std::span<const std::byte> bytes) {
  if (camera_) {
    // A stream of a line has no end that it could tell of; one that does is read anew.
    if (!camera_->read(bytes)) camera_->begin();
    if (camera_->has_spoken()) return;
  }
  for (const std::byte byte : bytes)
    if (const auto frame = framer_.add(byte); !frame.empty()) on_frame_(frame);
}

void SerialPort::watch() {
  watch_.expires_after(kLookAtPictures);
  watch_.async_wait([this](boost::system::error_code code) {
    if (closed_ || code) return;
    if (camera_->open() && camera_->is_overdue()) camera_->end("stalled: " + camera_->no_picture());
    watch();
  });
}

void SerialPort::lose(const std::string& problem) {
  boost::system::error_code ignored;
  port_.close(ignored);
  problem_ = "unplugged (" + problem + ")";
  if (camera_) camera_->end(problem_ + "; it is opened again when it is back");
  ++unplugged_;
  retry();
}

void SerialPort::retry() {
  timer_.expires_after(pause_);
  pause_ = std::min<std::chrono::milliseconds>(2 * pause_, kLastRetry);
  timer_.async_wait([this](boost::system::error_code code) {
    if (closed_ || code) return;
    if (const auto opened = try_open()) return read();
    retry();
  });
}

void SerialPort::close() {
  closed_ = true;
  boost::system::error_code ignored;
  port_.close(ignored);
  timer_.cancel(ignored);
  watch_.cancel(ignored);
}

SerialPort::Status SerialPort::status() const {
  Status status{.address = address_.source(),
                .open = port_.is_open(),
                .problem = problem_,
                .unplugged = unplugged_,
                .bytes = received_,
                .overlong = framer_.overlong()};
  if (!camera_) return status;
  CameraStatus camera = camera_->status();
  if (camera.pictures.all() > 0) status.camera = std::move(camera);
  return status;
}

}  // namespace mien::live
