#include <utility>  // Before Asio 1.74, which forgets it.

#include "app/live/session_client.h"

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/status.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>

#include "mien/sink/address.h"

namespace mien::app {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using tcp = asio::ip::tcp;
using BeastCode = beast::error_code;

using Clock = std::chrono::steady_clock;

/// How soon a wish to stop is seen.
constexpr auto kSlice = std::chrono::milliseconds(50);
constexpr std::uint16_t kPagePort = 8740;
constexpr std::size_t kMaxEvents = 64;
const char* const kStartOne = "start mien live first, or say where it is with --at HOST:PORT";

struct Place {
  std::string host;
  std::string port;
  std::string authority;  ///< "127.0.0.1:8740", for people and the Host header.
  std::string target;     ///< "/ws", with the token.
};

Result<Place> parse_place(const std::string& at, const TokenOption& given) {
  MIEN_TRY_ASSIGN(const sink::Address address,
                  sink::parse_address(at.find("://") == std::string::npos ? "http://" + at : at));
  if (address.scheme != "http" || address.host.empty() || (!address.path.empty() && address.path != "/"))
    return fail(ErrorCode::bad_usage, "not a session's address", at,
                "write it as 127.0.0.1:8740, or as mien live prints the page's");
  MIEN_TRY(address.expect_options({"token"}));
  const std::string* const in_address = address.option("token");
  MIEN_TRY_ASSIGN(const std::string token, given_token(given, in_address == nullptr ? "" : *in_address));
  const bool sendable = std::ranges::all_of(
      token, [](char c) { return c > ' ' && c < 0x7F && c != '&' && c != '#' && c != '?'; });
  if (!sendable)
    return fail(ErrorCode::bad_usage, "a token of odd letters", at, "give it as mien live printed it");
  return Place{.host = address.host,
               .port = std::to_string(address.port == 0 ? kPagePort : address.port),
               .authority = address.endpoint(kPagePort),
               .target = token.empty() ? "/ws" : "/ws?token=" + token};
}

}  // namespace

struct SessionClient::State {
  /// Runs the network until `done`. Errors: io (the line broke, or nothing came for too long), cancelled.
  Result<void> wait(const std::function<bool()>& done, const char* silence,
                    const std::atomic<bool>* stop = nullptr);
  Result<void> connect(const Place& place, const std::atomic<bool>& stop);
  void read();
  void take(std::string_view text);
  /// Does one thing that the network has to do, if there is any within a slice and before `until`.
  void run_one(Clock::time_point until = Clock::time_point::max());
  void lose(std::string what, std::string fix = {}) {
    if (!broken) broken = Error{ErrorCode::io, std::move(what), where, std::move(fix)};
  }

  asio::io_context network{1};
  tcp::resolver resolver{network};
  websocket::stream<beast::tcp_stream> socket{network};
  websocket::response_type response;
  beast::flat_buffer received;
  std::string sending;
  bool writing = false;

  Patience patience;
  std::string where;
  std::optional<Error> broken;
  SessionStatus status;
  std::uint64_t statuses = 0;
  Clock::time_point heard;  ///< The last message's arrival.
  std::vector<SessionEvent> events;
  std::int64_t commands = 0;
  std::optional<SessionReply> reply;
};

Result<void> SessionClient::State::wait(const std::function<bool()>& done, const char* silence,
                                        const std::atomic<bool>* stop) {
  const Clock::time_point begin = Clock::now();
  while (!done()) {
    if (broken) return std::unexpected(*broken);
    if (stop != nullptr && *stop) return fail(ErrorCode::cancelled, "stopped", where);
    if (Clock::now() >= std::min(std::max(begin, heard) + patience.silence, begin + patience.answer))
      lose(silence, kStartOne);
    run_one();
  }
  return {};
}

void SessionClient::State::run_one(Clock::time_point until) {
  if (network.stopped()) network.restart();
  network.run_one_until(std::min(until, Clock::now() + kSlice));
}

Result<void> SessionClient::State::connect(const Place& place, const std::atomic<bool>& stop) {
  where = place.authority;
  std::optional<BeastCode> code;
  tcp::resolver::results_type found;
  const auto ended = [&code] { return code.has_value(); };

  resolver.async_resolve(place.host, place.port,
                         [&](BeastCode result, tcp::resolver::results_type endpoints) {
                           code = result;
                           found = std::move(endpoints);
                         });
  MIEN_TRY(wait(ended, "the name was not found in time", &stop));
  if (*code) return fail(ErrorCode::bad_usage, "there is no such host", where, kStartOne);

  code.reset();
  beast::get_lowest_layer(socket).async_connect(
      found, [&](BeastCode result, const tcp::endpoint&) { code = result; });
  MIEN_TRY(wait(ended, "nobody answers there", &stop));
  if (*code) return fail(ErrorCode::io, "no session is there", where, kStartOne);

  code.reset();
  socket.read_message_max(kMaxSessionMessageBytes);
  socket.async_handshake(response, place.authority, place.target, [&](BeastCode result) { code = result; });
  MIEN_TRY(wait(ended, "what is there does not answer as a session does", &stop));
  if (*code && response.result() == beast::http::status::forbidden)
    return fail(ErrorCode::bad_usage, "the session wants its token", where,
                "give --token-file, or the page's address as mien live printed it");
  if (*code) return fail(ErrorCode::io, "what is there is no session", where, kStartOne);

  socket.text(true);
  read();
  return wait([this] { return statuses > 0; }, "what is there is no session: it says nothing of its state",
              &stop);
}

void SessionClient::State::read() {
  socket.async_read(received, [this](BeastCode code, std::size_t) {
    if (code == websocket::error::closed || code == asio::error::eof || code == asio::error::connection_reset)
      return lose("the session has ended", kStartOne);
    if (code) return lose("the line to the session broke: " + code.message());
    const auto data = received.cdata();
    take({static_cast<const char*>(data.data()), data.size()});
    received.consume(received.size());
    if (!broken) read();
  });
}

void SessionClient::State::take(std::string_view text) {
  heard = Clock::now();
  auto message = parse_session_message(text);
  if (!message)
    return lose("what is there speaks no session's language: " + message.error().what,
                "see that mien live and this program are of one version");
  if (auto* news = std::get_if<SessionStatus>(&*message)) {
    status = std::move(*news);
    ++statuses;
  } else if (auto* answer = std::get_if<SessionReply>(&*message)) {
    if (answer->id == commands) reply = std::move(*answer);
  } else if (auto* event = std::get_if<SessionEvent>(&*message)) {
    if (events.size() == kMaxEvents) events.erase(events.begin());
    events.push_back(std::move(*event));
  }
}

SessionClient::SessionClient(std::unique_ptr<State> state) : state_(std::move(state)) {}
SessionClient::~SessionClient() = default;

Result<std::unique_ptr<SessionClient>> SessionClient::open(const std::string& at, const TokenOption& token,
                                                           const std::atomic<bool>& stop, Patience patience) {
  MIEN_TRY_ASSIGN(const Place place, parse_place(at, token));
  auto state = std::make_unique<State>();
  state->patience = patience;
  MIEN_TRY(state->connect(place, stop));
  return std::unique_ptr<SessionClient>(new SessionClient(std::move(state)));
}

Result<void> SessionClient::command(nlohmann::json command) {
  State& s = *state_;
  if (s.broken) return std::unexpected(*s.broken);
  command["id"] = ++s.commands;
  s.reply.reset();
  s.sending = command.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  s.writing = true;
  s.socket.async_write(asio::buffer(s.sending), [&s](BeastCode code, std::size_t) {
    s.writing = false;
    if (code) s.lose("the line to the session broke: " + code.message());
  });
  MIEN_TRY(s.wait([&s] { return s.reply.has_value() && !s.writing; }, "the session does not answer"));
  if (!s.reply->error.empty()) return fail(ErrorCode::bad_usage, s.reply->error, s.where);
  return {};
}

const SessionStatus& SessionClient::status() const {
  return state_->status;
}

Result<void> SessionClient::next_status() {
  State& s = *state_;
  const std::uint64_t known = s.statuses;
  return s.wait([&s, known] { return s.statuses > known; }, "the session says nothing any more");
}

Result<void> SessionClient::listen_until(Clock::time_point until) {
  State& s = *state_;
  while (!s.broken && Clock::now() < until) s.run_one(until);
  if (s.broken) return std::unexpected(*s.broken);
  return {};
}

std::vector<SessionEvent> SessionClient::take_events() {
  return std::exchange(state_->events, {});
}

}  // namespace mien::app
