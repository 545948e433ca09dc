#pragma once

#include <utility>  // Before Asio 1.74, which forgets it.
//
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/system/error_code.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace mien::live {

/// Finds the addresses of a host by its name, on a thread of its own that is left to itself where nobody
/// waits for it any more: a system whose name server is dead says nothing for half a minute, and no session
/// may wait so long for its end. At most one such thread at a time. A number is no name and is answered
/// without one. All calls, and the answers, on the thread that runs the io_context.
class NameLookup {
 public:
  struct Answer {
    boost::system::error_code error;
    std::vector<boost::asio::ip::tcp::endpoint> found;
  };
  /// Asks, and waits for it. On any thread; has to outlive nothing.
  using Ask = std::function<Answer(const std::string& host, std::uint16_t port)>;
  using OnAnswer = std::function<void(const Answer&)>;

  /// `ask`: the system.
  explicit NameLookup(boost::asio::io_context& network, Ask ask = ask_system);
  NameLookup(const NameLookup&) = delete;
  NameLookup& operator=(const NameLookup&) = delete;
  /// Whoever was asked is not waited for.
  ~NameLookup();

  /// The answer goes to who asked last: while one is being waited for, nobody is asked again. Always for the
  /// same host and port.
  void find(const std::string& host, std::uint16_t port, OnAnswer on_answer);

  [[nodiscard]] static Answer ask_system(const std::string& host, std::uint16_t port);

 private:
  struct Waiting;
  boost::asio::io_context& network_;
  Ask ask_;
  std::shared_ptr<Waiting> waiting_;
};

}  // namespace mien::live
