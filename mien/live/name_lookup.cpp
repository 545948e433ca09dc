#include "mien/live/name_lookup.h"

#include <boost/asio/ip/address.hpp>
#include <boost/asio/post.hpp>
#include <mutex>
#include <thread>

namespace mien::live {

namespace asio = boost::asio;

/// What the thread that asks shares with who asked it.
struct NameLookup::Waiting {
  std::mutex mutex;
  asio::io_context* network = nullptr;  // Null: nobody waits any more.
  bool asked = false;                   // Of the io_context's thread, as what follows.
  OnAnswer on_answer;
};

NameLookup::NameLookup(asio::io_context& network, Ask ask)
    : network_(network), ask_(std::move(ask)), waiting_(std::make_shared<Waiting>()) {
  waiting_->network = &network;
}

NameLookup::~NameLookup() {
  const std::scoped_lock lock(waiting_->mutex);
  waiting_->network = nullptr;
  waiting_->on_answer = nullptr;
}

void NameLookup::find(const std::string& host, std::uint16_t port, OnAnswer on_answer) {
  boost::system::error_code no_number;
  const asio::ip::address number = asio::ip::make_address(host, no_number);
  waiting_->on_answer = std::move(on_answer);
  const auto hand_over = [](const std::shared_ptr<Waiting>& waiting, const Answer& answer) {
    waiting->asked = false;
    if (const OnAnswer its = std::exchange(waiting->on_answer, nullptr)) its(answer);
  };
  if (!no_number) {
    asio::post(network_,
               [hand_over, waiting = waiting_, answer = Answer{{}, {asio::ip::tcp::endpoint(number, port)}}] {
                 hand_over(waiting, answer);
               });
    return;
  }
  if (std::exchange(waiting_->asked, true)) return;
  std::thread([hand_over, host, port, ask = ask_, waiting = waiting_] {
    Answer answer = ask(host, port);
    const std::scoped_lock lock(waiting->mutex);
    if (waiting->network == nullptr) return;
    asio::post(*waiting->network,
               [hand_over, waiting, answer = std::move(answer)] { hand_over(waiting, answer); });
  }).detach();
}

NameLookup::Answer NameLookup::ask_system(const std::string& host, std::uint16_t port) {
  asio::io_context network(1);
  Answer answer;
  for (const auto& entry : asio::ip::tcp::resolver(network).resolve(host, std::to_string(port), answer.error))
    answer.found.push_back(entry.endpoint());
  return answer;
}

}  // namespace mien::live
