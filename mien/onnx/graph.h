#pragma once

#include <onnx/onnx_pb.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace mien::onnx {

/// The operators' version, and the file format's that came with it.
inline constexpr std::int64_t kOpset = 17;
inline constexpr std::int64_t kIrVersion = 8;

/// One axis of an input or output: its length, or the name of a length that whoever runs the graph chooses.
using Axis = std::variant<std::size_t, const char*>;

enum class Element { f32, i64 };

/// What a graph takes or gives.
struct Port {
  std::string name;
  Element element = Element::f32;
  std::vector<Axis> shape;
  std::string says;  ///< Meaning, unit, range; stands in the file.
};

struct Attribute {
  const char* name;
  std::variant<std::int64_t, float, std::vector<std::int64_t>> value;
};

/// An ONNX graph that is being written, node after node. Values are known by their names; those inside are
/// numbered. Nothing here checks shapes: onnx::checker does in the tests. Source: IR.md in the documentation
/// of github.com/onnx/onnx.
class Graph {
 public:
  /// `says` describes the graph to who opens the file.
  Graph(const std::string& name, const std::string& says);

  void input(const Port& port) { describe(port, *graph().add_input()); }
  void output(const Port& port) { describe(port, *graph().add_output()); }
  /// A text that stands in the file under a key.
  void tell(const std::string& key, const std::string& text);

  /// A tensor that stands in the file. `name` is its alone. Returns `name`.
  std::string constant(const std::string& name, const std::vector<std::size_t>& shape,
                       std::span<const float> values);
  std::string constant(const std::string& name, const std::vector<std::int64_t>& values);
  std::string scalar(const std::string& name, float value) { return constant(name, {}, {&value, 1}); }

  /// A node with one result, whose name it returns: `as`, or a number.
  std::string add(const char* op, const std::vector<std::string>& inputs,
                  const std::vector<Attribute>& attributes = {}, const std::string& as = {});
  /// x W^T + b of rows, W being [out, in] as model files have it.
  std::string gemm(const std::string& x, const std::string& weight, const std::string& bias,
                   const std::string& as = {}) {
    return add("Gemm", {x, weight, bias}, {{"transB", std::int64_t{1}}}, as);
  }
  /// `count` parts of one size along an axis.
  std::vector<std::string> split(const std::string& x, std::size_t count, std::int64_t axis);

  /// The file.
  [[nodiscard]] std::vector<std::byte> bytes() const;

 private:
  ::onnx::GraphProto& graph() { return *model_.mutable_graph(); }
  ::onnx::NodeProto& node(const char* op, const std::vector<std::string>& inputs);
  static void describe(const Port& port, ::onnx::ValueInfoProto& value);

  ::onnx::ModelProto model_;
  std::size_t values_ = 0;
};

}  // namespace mien::onnx
