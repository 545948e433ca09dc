#include "app/live/phone_feed.h"

#include <utility>  // Before Asio 1.74, which forgets it.

#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/error.hpp>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cstddef>
#include <cstdint>

#include "mien/core/host_port.h"
#include "mien/face/ifacialmocap_request.h"
#include "mien/live/name_lookup.h"
#include "mien/phone/ifacialmocap.h"
#include "mien/phone/live_link.h"
#include "mien/phone/phone_mount.h"
#include "mien/sink/live_link.h"

namespace mien::app {
namespace {

namespace asio = boost::asio;
using asio::ip::udp;

constexpr std::string_view kLiveLink = "livelink:", kIFacialMocap = "ifacialmocap:";
/// Between two looks at whether the session is over.
constexpr auto kLook = std::chrono::milliseconds(50);
/// A phone that sleeps, or whose program was begun anew, has forgotten who asked.
constexpr auto kAsksAgain = std::chrono::seconds(2);
/// No more is told of one question.
constexpr int kMostTold = 16;
/// So many questions in a row that met no trouble end one that there was.
constexpr int kUnhindered = 3;
/// Who takes so many questions in a row and sends nothing is told of.
constexpr int kUnanswered = 3;

/// Asks one phone for its frames, again and again.
class Asker {
 public:
  Asker(std::string host, std::uint16_t port, std::string address, live::FeedPort& session)
      : host_(std::move(host)), port_(port), address_(std::move(address)), session_(session) {}

  void run() {
    ask();
    while (!session_.stopped()) network_.run_for(kLook);
  }

 private:
  void ask() {
    lookup_.find(host_, port_, [this](const live::NameLookup::Answer& answer) {
      boost::system::error_code code = answer.error;
      // Answers come to an IPv4 port here.
      const auto found =
          std::ranges::find_if(answer.found, [](const auto& one) { return one.address().is_v4(); });
      if (!code && found == answer.found.end()) code = asio::error::host_not_found;
      if (!code) send(udp::endpoint(found->address(), port_), code);
      tell(code);
      tell_of_answers();
      timer_.expires_after(kAsksAgain);
      timer_.async_wait([this](boost::system::error_code over) {
        if (!over) ask();
      });
    });
  }

  /// Asks there. `code`: what stood against it, now or when it was asked last.
  void send(const udp::endpoint& phone, boost::system::error_code& code) {
    if (!socket_.is_open()) {
      socket_.open(udp::v4(), code);
      if (code) return;
      // That nobody has an address is told to those alone who ask for all that is told.
      const int yes = 1;
      static_cast<void>(::setsockopt(socket_.native_handle(), IPPROTO_IP, IP_RECVERR, &yes, sizeof(yes)));
    }
    // Connected, so that it is heard when the phone refuses, or nobody has its address.
    if (!code && phone != asked_) {
      socket_.connect(phone, code);
      if (!code) {
        asked_ = phone;
        session_.await(phone.address().to_string());
      }
    }
    if (code) return;
    socket_.send(asio::buffer(request_), 0, code);
    if (!code) return;
    // What was told of the last time kept this one from being sent, and stays until it is read.
    std::array<std::byte, 512> told{};
    for (int i = 0; i < kMostTold; ++i)
      if (::recv(socket_.native_handle(), told.data(), told.size(), MSG_ERRQUEUE | MSG_DONTWAIT) < 0) break;
    boost::system::error_code again;
    socket_.send(asio::buffer(request_), 0, again);
  }

  /// Says what stands against asking, and that nothing does any more.
  void tell(boost::system::error_code code) {
    // Who has no such address is not known each time that it is asked.
    unhindered_ = code ? 0 : unhindered_ + 1;
    if (code == trouble_ || (!code && unhindered_ < kUnhindered)) return;
    trouble_ = code;
    session_.tell(
        code ? "phone_unreachable" : "phone_asked",
        code ? fmt::format("{} cannot be asked: {}", address_, why(code)) : address_ + " is asked again");
  }

  /// Says that a phone which takes the questions sends nothing, and that it does after all.
  void tell_of_answers() {
    if (trouble_) {  // Of which is told.
      unanswered_ = 0;
      mute_ = false;
    } else if (session_.answered()) {
      unanswered_ = 0;
      if (std::exchange(mute_, false)) session_.tell("phone_answers", address_ + " sends its frames");
    } else if (++unanswered_ == kUnanswered) {
      mute_ = true;
      session_.tell("phone_missing",
                    fmt::format("{} was asked {} times and no frame comes from it: open iFacialMocap on the "
                                "phone and leave it in front, with the phone on this machine's network; a "
                                "firewall here has to let UDP {} in",
                                address_, unanswered_, face::kIFacialMocapPort));
    }
  }

  static std::string why(boost::system::error_code code) {
    if (code == asio::error::connection_refused)
      return "nothing there takes the question; open iFacialMocap on the phone";
    if (code == asio::error::host_unreachable || code == asio::error::network_unreachable)
      return "no device has that address here; is the phone on, on this network, and its address the one "
             "that "
             "iFacialMocap shows?";
    return code.message();
  }

  std::string host_;
  std::uint16_t port_;
  std::string address_;
  std::string request_ = face::ifacialmocap_request();
  live::FeedPort& session_;
  asio::io_context network_{1};
  // A name may be looked up for longer than anything else here waits.
  asio::executor_work_guard<asio::io_context::executor_type> working_ = asio::make_work_guard(network_);
  live::NameLookup lookup_{network_};
  udp::socket socket_{network_};
  asio::steady_timer timer_{network_};
  udp::endpoint asked_;
  boost::system::error_code trouble_;
  int unhindered_ = 0;  // How often it was asked since without trouble, ...
  int unanswered_ = 0;  // ... and since anything came of it.
  bool mute_ = false;   // So it was said.
};

}  // namespace

bool is_phone(std::string_view address) {
  return address.starts_with(kLiveLink) || address.starts_with(kIFacialMocap);
}

Result<ListenedPhones> listened_phones(const std::vector<std::string>& listen) {
  ListenedPhones out;
  std::uint64_t live_links = 0, asked = 0;
  for (const std::string& text : listen) {
    if (!is_phone(text)) continue;
    const bool asks = text.starts_with(kIFacialMocap);
    std::string_view rest = std::string_view(text).substr(asks ? kIFacialMocap.size() : kLiveLink.size());
    const auto bad = [&](std::string what) {
      return fail(ErrorCode::bad_usage, std::move(what), text,
                  asks ? "write it as ifacialmocap://PHONE, as the phone shows its address"
                       : "write it as livelink://0.0.0.0, and name this machine in the phone's program");
    };
    if (!rest.starts_with("//")) return bad("no address of a phone");
    rest.remove_prefix(2);
    while (rest.ends_with('/')) rest.remove_suffix(1);
    const auto parsed = parse_host_port(rest);
    if (!parsed) return bad(parsed.error().what);
    if (std::ranges::count(listen, text) > 1) return bad("given twice");
    if (!asks) {
      const std::string_view host = parsed->host.empty() ? "0.0.0.0" : parsed->host;
      const bool brackets = host.find(':') != std::string_view::npos;
      std::string port = fmt::format("udp://{}{}{}:{}", brackets ? "[" : "", host, brackets ? "]" : "",
                                     parsed->port.value_or(sink::kLiveLinkPort));
      if (std::ranges::find(out.ports, port) != out.ports.end()) return bad("given twice");
      out.ports.push_back(std::move(port));
      out.devices.push_back({phone::kLiveLinkDevice + live_links++, 0});
      continue;
    }
    if (parsed->host.empty()) return bad("no host");
    if (parsed->host.find(':') != std::string_view::npos) return bad("IPv6, in which phones do not answer");
    if (asked == 0) out.ports.push_back(fmt::format("udp://0.0.0.0:{}", face::kIFacialMocapPort));
    out.devices.push_back({phone::kIFacialMocapDevice + asked++, 0});
    out.asked.push_back(text);
    out.feeds.push_back(
        {.name = text,
         .run = [host = std::string(parsed->host), port = parsed->port.value_or(face::kIFacialMocapPort),
                 text](live::FeedPort& session) { Asker(host, port, text, session).run(); },
         .heard = false});
  }
  return out;
}

Result<sensor::Rig> with_listened(sensor::Rig rig, const std::vector<sensor::DeviceKey>& devices,
                                  const std::string& use) {
  MIEN_TRY_ASSIGN(const auto added, phone::without_sensor(rig, devices));
  if (use.empty() && !added.empty())
    return fail(ErrorCode::bad_usage, "it was not said what the phone is for", "--listen",
                "give --phone truth to record it beside the sensors, or --phone source to let it move the "
                "face");
  if (!use.empty() && added.empty())
    return fail(ErrorCode::bad_usage,
                devices.empty() ? "no phone is listened to" : "the rig has a sensor for it, with a role",
                "--phone " + use,
                devices.empty() ? "give --listen livelink://0.0.0.0 or ifacialmocap://PHONE too"
                                : "leave out --phone");
  return phone::with_phones(std::move(rig), added,
                            use == "truth" ? phone::PhoneUse::truth : phone::PhoneUse::source);
}

}  // namespace mien::app
