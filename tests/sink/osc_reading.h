#pragma once

#include <gtest/gtest.h>
#include <oscpack/osc/OscReceivedElements.h>

#include <string>
#include <variant>
#include <vector>

#include "mien/sink/datagrams.h"

namespace mien::sink::test {

using OscArgument = std::variant<int, float, bool, std::string>;

struct OscMessage {
  std::string address;
  std::vector<OscArgument> arguments;
  bool operator==(const OscMessage&) const = default;
};

/// All messages of some datagrams, each of which must be a bundle "now" of messages; in their order.
inline std::vector<OscMessage> osc_messages(const Datagrams& datagrams) {
  std::vector<OscMessage> messages;
  for (std::size_t i = 0; i < datagrams.size(); ++i) {
    const auto bytes = datagrams[i];
    const osc::ReceivedPacket packet(reinterpret_cast<const char*>(bytes.data()),
                                     static_cast<osc::osc_bundle_element_size_t>(bytes.size()));
    EXPECT_TRUE(packet.IsBundle());
    const osc::ReceivedBundle bundle(packet);
    EXPECT_EQ(bundle.TimeTag(), 1u);
    for (auto element = bundle.ElementsBegin(); element != bundle.ElementsEnd(); ++element) {
      const osc::ReceivedMessage received(*element);
      OscMessage& message = messages.emplace_back();
      message.address = received.AddressPattern();
      for (auto argument = received.ArgumentsBegin(); argument != received.ArgumentsEnd(); ++argument) {
        if (argument->IsFloat())
          message.arguments.emplace_back(argument->AsFloat());
        else if (argument->IsInt32())
          message.arguments.emplace_back(static_cast<int>(argument->AsInt32()));
        else if (argument->IsBool())
          message.arguments.emplace_back(argument->AsBool());
        else if (argument->IsString())
          message.arguments.emplace_back(std::string(argument->AsString()));
        else
          ADD_FAILURE() << message.address << ": an argument of another type";
      }
    }
  }
  return messages;
}

}  // namespace mien::sink::test
