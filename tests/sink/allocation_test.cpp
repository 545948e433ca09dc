// The live path allocates nothing once its buffers have grown: counted, by taking the place of operator new.
#include <gtest/gtest.h>

#include "mien/sink/sink.h"
#include "tests/allocation_count.h"
#include "tests/folder.h"
#include "tests/sink/loopback.h"

namespace mien::sink::allocation_test {
namespace {

face::OutputFrame frame_at(std::int64_t index) {
  face::OutputFrame frame;
  frame.time = DeviceTime(frame_offset(index));
  for (std::size_t i = 0; i < face::kShapeCount; ++i)
    frame.weights[i] = static_cast<float>((index + static_cast<std::int64_t>(i)) % 61) / 61;
  return frame;
}

TEST(Allocation, NoneAfterTheFirstFrames) {
  boost::asio::io_context network;
  test::Receiver receiver(network);
  const mien::test::Folder folder;
  const std::string there = fmt::format("127.0.0.1:{}", receiver.port());
  for (const std::string& address : {"livelink://" + there, "vmc://" + there,
                                     "vrchat://" + there + "?binary=7", "ifacialmocap://" + there}) {
    auto sink = open_sink(network, address);
    ASSERT_TRUE(sink) << sink.error().message();
    for (int i = 0; i < 130; ++i) (*sink)->send(frame_at(i), i);
    const std::size_t before = mien::test::allocation_count();
    for (int i = 130; i < 400; ++i) (*sink)->send(frame_at(i), i);
    EXPECT_EQ(mien::test::allocation_count() - before, 0u) << address;
    EXPECT_EQ((*sink)->status().sent, 400u);
  }
  // A writer's thread takes the rows at times of its own: its two buffers grow to half a second, or to what
  // a busy disk lets gather, and no row has an allocation of its own.
  auto sink = open_sink(network, "csv:" + (folder / "a.csv").string());
  ASSERT_TRUE(sink);
  for (int i = 0; i < 600; ++i) (*sink)->send(frame_at(i), i);
  const std::size_t before = mien::test::allocation_count();
  for (int i = 600; i < 3000; ++i) (*sink)->send(frame_at(i), i);
  EXPECT_LT(mien::test::allocation_count() - before, 20u);
}

}  // namespace
}  // namespace mien::sink::allocation_test
